"""Compiling with numba, and many runs in processes."""

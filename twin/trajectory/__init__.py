"""Trajectory of a drive: noise-free quantities at the physics steps, and the end of the drive."""

"""Compiled functions, and processes that run many calls."""

import os

# numba writes a message for every form of a call that it tries and drops, and colours each
os.environ.setdefault("NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING", "1")

"""Times of a log as text: h:mm from the start of the log, and the date of the start."""

from __future__ import annotations

import numpy as np

from twin.io.estimates_csv import DATED_NS

SHORT_S = 600.0
"""Below this, seconds are worth showing [s]."""


def hours(time_s: float) -> str:
    """Text h:mm of a time in seconds, rounded to the minute."""
    minutes = round(time_s / 60.0)
    return f"{minutes // 60}:{minutes % 60:02d}"


def hours_seconds(time_s: float) -> str:
    """Text h:mm:ss of a time in seconds, rounded to the second."""
    seconds = round(time_s)
    return f"{seconds // 3600}:{seconds // 60 % 60:02d}:{seconds % 60:02d}"


def start_text(start_ns: int) -> str:
    """Sentence that states which instant 0:00 is.

    Args:
        start_ns: first epoch of the log [ns]: UTC, or, if too small for a date, the log's clock.
    """
    if start_ns < DATED_NS:
        return f"0:00 is {start_ns * 1e-9:g} s of the log's clock"
    stamp = np.datetime_as_string(np.datetime64(start_ns, "ns"), unit="s")
    return f"0:00 is {str(stamp).replace('T', ' ')} UTC"

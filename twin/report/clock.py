"""Axes of time of a log: h:mm from its start."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, MultipleLocator

from twin.report.draw import Drawing
from twin.scores.hours import SHORT_S, hours

_STEPS_S = (60, 120, 300, 600, 900, 1800, 3600, 7200, 10800, 21600, 43200, 86400)
_MOST_TICKS = 8


def time_axis(axes: Axes, span_s: float) -> None:
    """Label the abscissa of seconds since the start, with h:mm in a long log."""
    if span_s < SHORT_S:
        axes.set_xlabel("time since start [s]")
        return
    fitting = (step for step in _STEPS_S if span_s <= _MOST_TICKS * step)
    step_s = next(fitting, 86400 * int(np.ceil(span_s / 86400 / _MOST_TICKS)))
    axes.xaxis.set_major_locator(MultipleLocator(step_s))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: hours(value)))
    axes.set_xlabel("time since start [h:mm]")


def clocked(drawing: Drawing | None, span_s: float) -> Drawing | None:
    """A drawing over time with its abscissa as `time_axis` has it."""
    if drawing is None:
        return None
    draw: Callable[..., None] = drawing.draw

    def with_clock(*axes: Any) -> None:
        draw(*axes)
        for each in axes:
            time_axis(each, span_s)
            if each is not axes[-1]:
                each.set_xlabel("")

    return replace(drawing, draw=with_clock)

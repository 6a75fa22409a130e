"""Figures of a study: a quantity's mean and interval for each estimator, over what was swept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from twin.report.palette import TRUTH_COLOUR, Look, looks
from twin.report.printed import Picture, legend_columns
from twin.studies.summary import Group, mean_of

SPREAD = 0.7
"""Share of a setting's place that its estimators stand side by side in."""
BARS: Any = {"ms": 4.0, "lw": 1.1, "capsize": 2.5}
LABEL_LETTERS = 34
"""Longest line of a label, in letters; it is broken between words."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Drawn:
    """A quantity that is drawn."""

    label: str
    """Name and unit on the axis."""
    scale: float
    """Axis' unit in the quantity's."""
    bound: str = ""
    """Quantity that no estimator's mean square error is below."""


def picture(groups: Sequence[Group], quantity: str, drawn: Drawn) -> Picture | None:
    """The figure of a quantity; None where it was nowhere measured.

    One field swept over numbers is the abscissa, with a panel for each scenario; otherwise every
    setting has a line of its own.

    Args:
        groups: all of a study.
        quantity: column of the table.
        drawn: how it is drawn.
    """
    shown = [group for group in groups if group.values(quantity)]
    if not shown:
        return None
    look = looks(group.estimator for group in groups)
    build = _over_numbers if _numeric(shown) else _by_setting
    return Picture(partial(build, shown, quantity, drawn, look), columns=2)


def _numeric(groups: Sequence[Group]) -> bool:
    """Whether exactly one field was swept, over numbers."""
    values = [group.swept[0][1] for group in groups if len(group.swept) == 1]
    numbers = all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values)
    return len(values) == len(groups) and numbers and len(set(values)) > 1


def _over_numbers(
    groups: Sequence[Group], quantity: str, drawn: Drawn, look: dict[str, Look]
) -> Figure:
    scenarios = list(dict.fromkeys(group.scenario for group in groups))
    size = (min(max(4.8, 3.4 * len(scenarios)), 14.0), 3.6)
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(1, len(scenarios), sharey=True, squeeze=False)[0]
    for axes, scenario in zip(panels, scenarios, strict=True):
        of_scenario = [group for group in groups if group.scenario == scenario]
        of_scenario.sort(key=_swept)
        for name, (colour, mark, line) in look.items():
            own = [group for group in of_scenario if group.estimator == name]
            centre, reach = _means(own, quantity, drawn.scale)
            at = [_swept(group) for group in own]
            axes.errorbar(at, centre, reach, fmt=mark + line, color=colour, label=name, **BARS)
        bounds = {_swept(group): _bound(group, drawn) for group in of_scenario}
        if np.isfinite(list(bounds.values())).any():
            axes.plot(*zip(*bounds.items(), strict=True), "--", color=TRUTH_COLOUR, label="bound")
        axes.set_title(fill(scenario, LABEL_LETTERS))
        axes.set_xlabel(groups[0].swept[0][0])
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    panels[0].set_ylabel(drawn.label)
    _legend(figure, panels[0])
    return figure


def _by_setting(
    groups: Sequence[Group], quantity: str, drawn: Drawn, look: dict[str, Look]
) -> Figure:
    places = {setting: i for i, setting in enumerate(dict.fromkeys(g.setting for g in groups))}
    labels = [fill(setting, LABEL_LETTERS, break_on_hyphens=False) for setting in places]
    lines = max(len(look), 1 + max(label.count("\n") for label in labels))
    figure = Figure(figsize=(7.0, 1.2 + 0.18 * lines * len(places)), layout="constrained")
    axes = figure.subplots()
    step = SPREAD / len(look)
    for i, (name, (colour, mark, _)) in enumerate(look.items()):
        own = [group for group in groups if group.estimator == name]
        at = [places[group.setting] + (i - (len(look) - 1) / 2) * step for group in own]
        centre, reach = _means(own, quantity, drawn.scale)
        axes.errorbar(centre, at, xerr=reach, fmt=mark, color=colour, label=name, **BARS)
    bounds = {places[group.setting]: _bound(group, drawn) for group in groups}
    if np.isfinite(list(bounds.values())).any():
        place, level = (np.array(each, float) for each in zip(*bounds.items(), strict=True))
        half = 0.5 * SPREAD
        axes.vlines(level, place - half, place + half, color=TRUTH_COLOUR, ls="--", label="bound")
    axes.set_yticks(range(len(places)), labels)
    axes.set_ylim(len(places) - 0.5, -0.5)
    axes.set_xlim(left=min(0.0, axes.get_xlim()[0]))
    axes.grid(visible=False, axis="y")
    axes.set_xlabel(drawn.label)
    _legend(figure, axes)
    return figure


def _legend(figure: Figure, axes: Axes) -> None:
    handles, names = axes.get_legend_handles_labels()
    ncols = legend_columns(names, figure.get_figwidth())
    figure.legend(handles, names, loc="outside lower center", ncols=ncols)


def _swept(group: Group) -> float:
    return float(group.swept[0][1])


def _bound(group: Group, drawn: Drawn) -> float:
    """Mean bound of a setting; NaN where it is not known."""
    return drawn.scale * mean_of(group, drawn.bound).mean if drawn.bound else np.nan


def _means(groups: Sequence[Group], quantity: str, scale: float) -> tuple[Array, Array]:
    """Means, and how far their intervals reach below and above; a single seed has none."""
    means = [mean_of(group, quantity) for group in groups]
    below, above = ([m.mean - m.low for m in means], [m.high - m.mean for m in means])
    return scale * np.array([m.mean for m in means]), scale * np.nan_to_num([below, above])

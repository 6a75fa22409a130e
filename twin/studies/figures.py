"""Figures of a study: a quantity's mean and interval for each estimator, over what was swept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from twin.report.palette import PICTURE, colours
from twin.studies.summary import Group, mean

SPREAD = 0.7
"""Share of a setting's place that its estimators stand side by side in."""
MARKS = "os^D"
BARS: Any = {"ms": 4.0, "lw": 1.1, "capsize": 2.5}

Array = NDArray[np.float64]
Looks = Mapping[str, tuple[str, str]]


def draw(groups: Sequence[Group], quantity: str, path: Path, *, label: str) -> bool:
    """Write a figure as PNG; False if the quantity was nowhere measured.

    One field swept over numbers is the abscissa, with a panel for each scenario; otherwise every
    setting has a line of its own.

    Args:
        groups: all of a study.
        quantity: column of the table.
        path: the file.
        label: the quantity, with its unit.
    """
    shown = [group for group in groups if group.values(quantity)]
    if not shown:
        return False
    looks = _looks(groups)
    with mpl.rc_context(PICTURE):
        figure = (_over_numbers if _numeric(shown) else _by_setting)(shown, quantity, label, looks)
        handles, names = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=min(len(names), 5))
        figure.savefig(path)
    return True


def _looks(groups: Sequence[Group]) -> Looks:
    """Colour and mark of each estimator; the colours come round, the marks then differ."""
    palette = colours(dict.fromkeys(group.estimator for group in groups))
    return {name: (colour, MARKS[i // 6]) for i, (name, colour) in enumerate(palette.items())}


def _numeric(groups: Sequence[Group]) -> bool:
    """Whether exactly one field was swept, over numbers."""
    values = [group.swept[0][1] for group in groups if len(group.swept) == 1]
    numbers = all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values)
    return len(values) == len(groups) and numbers and len(set(values)) > 1


def _over_numbers(groups: Sequence[Group], quantity: str, label: str, looks: Looks) -> Figure:
    scenarios = list(dict.fromkeys(group.scenario for group in groups))
    size = (min(max(4.8, 3.4 * len(scenarios)), 14.0), 3.6)
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(1, len(scenarios), sharey=True, squeeze=False)[0]
    for axes, scenario in zip(panels, scenarios, strict=True):
        for name, (colour, mark) in looks.items():
            own = [g for g in groups if (g.scenario, g.estimator) == (scenario, name)]
            own.sort(key=lambda g: float(g.swept[0][1]))
            centre, half = _means(own, quantity)
            at = [float(g.swept[0][1]) for g in own]
            axes.errorbar(at, centre, half, fmt=f"{mark}-", color=colour, label=name, **BARS)
        axes.set_title(scenario)
        axes.set_xlabel(groups[0].swept[0][0])
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    panels[0].set_ylabel(label)
    return figure


def _by_setting(groups: Sequence[Group], quantity: str, label: str, looks: Looks) -> Figure:
    places = {setting: i for i, setting in enumerate(dict.fromkeys(g.setting for g in groups))}
    step = SPREAD / len(looks)
    figure = Figure(figsize=(7.0, 1.2 + 0.16 * len(looks) * len(places)), layout="constrained")
    axes = figure.subplots()
    for i, (name, (colour, mark)) in enumerate(looks.items()):
        own = [g for g in groups if g.estimator == name]
        at = [places[g.setting] + (i - (len(looks) - 1) / 2) * step for g in own]
        centre, half = _means(own, quantity)
        axes.errorbar(centre, at, xerr=half, fmt=mark, color=colour, label=name, **BARS)
    axes.set_yticks(range(len(places)), list(places))
    axes.set_ylim(len(places) - 0.5, -0.5)
    axes.set_xlim(left=min(0.0, axes.get_xlim()[0]))
    axes.grid(visible=False, axis="y")
    axes.set_xlabel(label)
    return figure


def _means(groups: Sequence[Group], quantity: str) -> tuple[Array, Array]:
    """Means and half their intervals; from a single seed there is no interval to draw."""
    means = [mean(group.values(quantity).values()) for group in groups]
    return np.array([m.mean for m in means]), np.nan_to_num([m.high - m.mean for m in means])

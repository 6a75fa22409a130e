"""Figures of a calibration: residuals over time, parity, what is known together, the holdout."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from twin.calibration.known import known
from twin.report.draw import STYLE, Drawing

if TYPE_CHECKING:
    from twin.calibration.fitting import Fit
    from twin.calibration.holdout import Holdout
    from twin.calibration.result import Calibration

Array = NDArray[np.float64]
MOST_IN_CORNER = 8


def residuals(found: Calibration) -> Drawing:
    """Residuals over their sd, over time."""

    def draw(axes: Axes) -> None:
        scaled = found.fit.residual / found.fit.noise.sd()
        for i, channel in enumerate(found.channels):
            axes.plot(found.time_s, scaled[:, i], ".", ms=4.0, label=channel)
        axes.axhspan(-2.0, 2.0, color="0.9", zorder=0)
        axes.set(xlabel="time [s]", ylabel="residual / sd")

    return Drawing(title="Residuals over time", draw=draw)


def parity(found: Calibration, measured: Array) -> Drawing:
    """Predicted against measured, each channel over its mean."""

    def draw(axes: Axes) -> None:
        foretold = measured - found.fit.residual
        size = np.maximum(np.abs(measured).mean(axis=0), 1e-12)
        for i, channel in enumerate(found.channels):
            axes.plot(measured[:, i] / size[i], foretold[:, i] / size[i], ".", ms=4.0,
                      label=channel)  # fmt: skip
        low, high = axes.get_xlim()
        axes.plot([low, high], [low, high], color="0.6", lw=0.8, zorder=0)
        axes.set(xlabel="measured / mean", ylabel="foretold / mean")

    return Drawing(title="Parity", draw=draw)


def ahead(holdout: Holdout) -> Drawing:
    """Slip of the part held back: predicted with its band, and measured."""

    def draw(axes: Axes) -> None:
        time_s, slip, sd = holdout.rows.time_s, 100.0 * holdout.slip, 100.0 * holdout.slip_sd
        axes.errorbar(time_s, slip, 1.96 * sd, fmt="none", ecolor="#9ecae1", label="95 % band")
        axes.plot(time_s, slip, ".", color="#0072B2", label="foretold")
        axes.plot(time_s, 100.0 * holdout.measured, ".", color="black", ms=3.0, label="measured")
        axes.set(xlabel="time [s]", ylabel="slip [%]")

    return Drawing(title="Slip of the part held back", draw=draw)


def corner(fit: Fit) -> str:
    """An SVG of the posterior of each two parameters: ellipses of 68 and 95 %."""
    order = np.argsort(np.diag(fit.cov) / fit.prior.sd**2)[:MOST_IN_CORNER]
    count, sds = len(order), np.sqrt(np.diag(fit.cov))
    angle = np.linspace(0.0, 2.0 * np.pi, 60)
    circle = np.array([np.cos(angle), np.sin(angle)])
    with mpl.rc_context(STYLE | {"font.size": 7.0}):
        figure = Figure(figsize=(9.0, 9.0))
        axes = figure.subplots(count, count, squeeze=False)
        for row, i in enumerate(order):
            for column, j in enumerate(order):
                here = axes[row, column]
                if column > row:
                    here.set_axis_off()
                    continue
                here.tick_params(labelsize=5.0)
                if column == row:
                    x = np.linspace(-3.0, 3.0, 80)
                    here.plot(np.exp(fit.u[i] + sds[i] * x), np.exp(-0.5 * x**2), color="#0072B2")
                    here.set_yticks([])
                    here.set_title(known(fit.prior.names[i]).about, fontsize=6.0)
                    continue
                factor = np.linalg.cholesky(fit.cov[np.ix_([j, i], [j, i])])
                for radius in (1.515, 2.448):
                    x, y = np.exp(fit.u[[j, i]][:, None] + radius * factor @ circle)
                    here.plot(x, y, color="#0072B2", lw=0.8)
        figure.set_layout_engine("constrained")
        text = io.StringIO()
        nameless = {"Date": None, "Creator": None, "Format": None, "Type": None}
        figure.savefig(text, format="svg", transparent=True, metadata=nameless)
    element = text.getvalue()
    element = element[element.index("<svg") :]
    label = '<svg role="img" aria-label="Corner plot" class="figure spread" '
    return element.replace("<svg ", label, 1)

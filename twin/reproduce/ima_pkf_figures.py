"""Figures like those of the IMA-PKF paper, as inline SVG."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes

from scenarios.ima_pkf import Trial, simulate
from scenarios.ima_pkf_signals import SETUP, streams
from twin.io.result_rows import Row
from twin.pipeline.named import load
from twin.report.draw import svg
from twin.report.palette import TRUTH_COLOUR, colours
from twin.reproduce.ima_pkf_methods import ADAPTIVE
from twin.streams import Table

METHODS = {"KF": "kf-z2", **ADAPTIVE}
PALETTE = colours(("KF", "PSO-PKF", "MA-PKF", "IMA-PKF", "tuned KF"))


def signals(trial: Trial) -> str:
    """Speeds by GNSS, front and rear wheels, with the truth."""
    s = simulate(trial)
    parts = (
        ("GNSS", s.gnss_mps, s.ground_mps),
        ("front wheels", s.front_mps, s.ground_mps),
        ("rear wheels", s.rear_mps, s.wheel_mps),
    )

    def draw(*axes: Axes) -> None:
        for ax, (name, measured, true) in zip(axes, parts, strict=True):
            ax.plot(s.time_s, measured, color=PALETTE["PSO-PKF"], lw=0.6)
            ax.plot(s.time_s, true, color=TRUTH_COLOUR, lw=1.0)
            ax.set(ylabel=f"{name}\n[m/s]")
        axes[-1].set(xlabel="time [s]")

    return svg("Measured and true speeds", draw, rows=3)


def slips(trial: Trial) -> str:
    """Slip by each of the four methods over the truth, one below the other."""
    s, found = simulate(trial), estimates(trial)

    def draw(*axes: Axes) -> None:
        for ax, (name, slip) in zip(axes, found.items(), strict=True):
            ax.plot(s.time_s, 100 * slip, color=PALETTE[name], lw=0.7)
            ax.plot(s.time_s, 100 * s.slip, color=TRUTH_COLOUR, lw=1.0)
            ax.set(ylabel=f"{name}\nslip [%]", ylim=(-10, 50))
        axes[-1].set(xlabel="time [s]")

    return svg("Slip by four methods", draw, rows=4)


def gnss_speed(trial: Trial) -> str:
    """GNSS speed with its disturbances, and the truth."""
    s = simulate(trial)

    def draw(ax: Axes) -> None:
        ax.plot(s.time_s, s.gnss_mps, color=PALETTE["PSO-PKF"], lw=0.7, label="GNSS")
        ax.plot(s.time_s, s.ground_mps, color=TRUTH_COLOUR, lw=1.0, label="truth")
        ax.set(xlabel="time [s]", ylabel="ground speed [m/s]")

    return svg("GNSS speed with disturbances", draw)


def errors(trials: Sequence[Trial]) -> str:
    """|error| of slip by each method: every trial thin, their root mean square thick."""
    found = [(simulate(trial), estimates(trial)) for trial in trials]
    time_s = found[0][0].time_s
    off = {name: np.abs([100 * (by[name] - true.slip) for true, by in found]) for name in METHODS}
    top = float(max(each.max() for each in off.values()))

    def draw(*axes: Axes) -> None:
        for ax, (name, each) in zip(axes, off.items(), strict=True):
            ax.plot(time_s, each[:6].T, color="#bbb", lw=0.4)
            rms = np.sqrt(np.mean(each**2, axis=0))
            ax.plot(time_s, rms, color=PALETTE[name], lw=1.0)
            ax.set(ylabel=f"{name}\n|error| [%]", ylim=(0, top))
        axes[-1].set(xlabel="time [s]")

    return svg("Absolute error of slip", draw, rows=4)


def estimates(trial: Trial) -> Table:
    """Slip by each of the four methods. Shapes (n,)."""
    measured = streams(simulate(trial))
    loaded = {name: load("estimator", key) for name, key in METHODS.items()}
    return {name: e.run(e.init(SETUP), measured)[1]["slip"] for name, e in loaded.items()}


def field_slips(runs: Mapping[int, tuple[Table, dict[str, Table]]]) -> str:
    """Slip over time at each depth [cm]: truth, KF and IMA-PKF of one run."""

    def draw(*axes: Axes) -> None:
        for ax, (cm, (truth, by)) in zip(axes, runs.items(), strict=True):
            for name, table in by.items():
                time_s = table["epoch_ns"] * 1e-9
                ax.plot(time_s, 100 * table["slip"], color=PALETTE[name], lw=0.6, label=name)
            time_s, on = truth["epoch_ns"] * 1e-9, truth["ploughing"].astype(bool)
            ax.plot(time_s, 100 * truth["slip"], color=TRUTH_COLOUR, lw=0.8, label="truth")
            level = 100 * float(np.median(truth["slip"][on]))
            ax.set(ylabel=f"{cm} cm\nslip [%]", ylim=(0.0, 2.2 * level))
        axes[-1].set(xlabel="time [s]")

    return svg("Slip while ploughing", draw, rows=len(runs))


def field_errors(rows: Sequence[Row], depths_cm: Sequence[int]) -> str:
    """MAE and RMSE of slip by depth, with 95 % intervals."""
    values = {(row["case"], row["quantity"]): row for row in rows}
    names = ("KF", "tuned KF", "IMA-PKF")

    def draw(*axes: Axes) -> None:
        for ax, quantity in zip(axes, ("MAE", "RMSE"), strict=True):
            for i, name in enumerate(names):
                found = [values[f"{cm} cm", f"{quantity}, {name}"] for cm in depths_cm]
                at = np.arange(len(depths_cm)) + 0.25 * (i - 1)
                height = [100 * row["ours"] for row in found]
                half = [50 * (row.get("high", 0.0) - row.get("low", 0.0)) for row in found]
                ax.bar(at, height, 0.23, yerr=half, color=PALETTE[name], label=name)
            ax.set_xticks(range(len(depths_cm)), [f"{cm} cm" for cm in depths_cm])
            ax.set(ylabel=f"{quantity} [%]")

    return svg("Errors of slip by depth", draw, rows=2)

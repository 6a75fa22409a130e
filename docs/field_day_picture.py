"""Lays the simulated day of the T7.165S beside its log: `python docs/field_day_picture.py`.

Writes docs/pictures/field-day.svg and prints the table of docs/field-days.md. Takes some minutes.
"""

from __future__ import annotations

import io
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from twin.io.atomic import write_text
from twin.logs.drive_statistics import drive_statistics, ratios
from twin.pipeline.named import load
from twin.report.palette import FIGURE
from twin.simulation.build import build
from twin.simulation.simulate import simulate

PICTURE = Path(__file__).parent / "pictures" / "field-day.svg"
SCENARIO = "field-day-t7165s"
LOG = {
    "wheel_mps_rms_1s": 0.1806, "wheel_mps_mad_1s": 0.0, "wheel_mps_rms_20s": 0.7680,
    "wheel_mps_mad_20s": 0.0483, "engine_rpm_rms_1s": 103.1, "engine_rpm_mad_1s": 2.57,
    "engine_rpm_rms_20s": 498.1, "engine_rpm_mad_20s": 20.3, "slip_rms_1s": 0.1125,
    "slip_mad_1s": 0.0236, "slip_rms_20s": 0.1499, "slip_mad_20s": 0.0700, "standing": 0.481,
    "stops_per_h": 38.5,
}  # fmt: skip
"""Of the log of 3.3 h at 1 Hz (github.com/lindiap/tractor-field-operations-dataset, CC BY-NC 4.0),
by `drive_statistics`, its wheel speed times 0.993, where slip is zero."""
LOG_ON = {
    "wheel_mps_rms_1s": 0.2262, "wheel_mps_mad_1s": 0.0232, "wheel_mps_rms_20s": 0.9618,
    "wheel_mps_mad_20s": 0.5918, "engine_rpm_rms_1s": 129.0, "engine_rpm_mad_1s": 17.0,
    "engine_rpm_rms_20s": 622.7, "engine_rpm_mad_20s": 361.0, "slip_rms_1s": 0.1125,
    "slip_mad_1s": 0.0236, "slip_rms_20s": 0.1499, "slip_mad_20s": 0.0700, "standing": 0.186,
    "stops_per_h": 60.8,
}  # fmt: skip
"""The same while the engine runs."""
SECOND = 500
"""Physics steps."""
LAG_S = 0.2
"""How far the speed of the log's receiver is behind its wheels: at this they agree best."""
DOPPLER_SD_MPS = 0.016
"""Noise of the receiver's speed in motion [m/s], by second differences where the log is steady."""
ENGINE_SD_RPM = 0.8
"""Noise of the engine speed on a bus [rpm], measured as docs/sensors.md says."""
CAN_MPS = 1.0 / 256.0 / 3.6
"""Resolution of the wheel-based vehicle speed (SAE J1939-71, SPN 84)."""


def driven() -> tuple[NDArray[np.float64], ...]:
    """Wheel speed, ground speed and engine speed of the day, as a logger at 1 Hz has them."""
    rows: list[NDArray[np.float64]] = []
    lag = round(LAG_S / 0.002)
    for chunk in simulate(build(load("scenario", SCENARIO))):
        at = np.arange(SECOND - 1, len(chunk), SECOND)
        rim = (chunk["spin_radps"] * chunk["rolling_radius_m"])[:, 2:].mean(axis=1)
        ground = chunk["wheel_speed_x_mps"][:, 2:].mean(axis=1)
        rows.append(np.stack([rim[at], ground[at - lag], chunk["engine_radps"][at] * 30.0 / np.pi]))
    wheel, ground, engine = np.abs(np.concatenate(rows, axis=1))
    rng = np.random.default_rng(0)
    noise = rng.normal(0.0, DOPPLER_SD_MPS, len(ground))
    ground = np.abs(ground + np.where(ground > 0.05, noise, 0.0))
    noise = rng.normal(0.0, ENGINE_SD_RPM, len(engine))
    engine = np.abs(engine + np.where(engine > 0.0, noise, 0.0))
    return np.round(wheel / CAN_MPS) * CAN_MPS, ground, np.round(engine * 8.0) / 8.0


def words(name: str) -> str:
    """A statistic in words: `wheel_mps_rms_1s` is `wheel speed, rms, 1 s`."""
    if name in ("standing", "stops_per_h"):
        return {"standing": "share of standing", "stops_per_h": "stops per hour"}[name]
    what, kind, step = name.rsplit("_", 2)
    named = {"wheel_mps": "wheel speed", "engine_rpm": "engine speed", "slip": "slip"}[what]
    return f"{named}, {kind.upper() if kind == 'mad' else kind}, {step.removesuffix('s')} s"


def figure(
    day: tuple[NDArray[np.float64], ...], whole: dict[str, float], on: dict[str, float]
) -> str:
    """Ten minutes of the day, and its statistics over those of the log, as SVG."""
    wheel, _, engine = day
    drawn = Figure(figsize=(9.0, 4.2), layout="constrained")
    grid = drawn.add_gridspec(2, 2, width_ratios=(1.15, 1.0))
    upper, right = drawn.add_subplot(grid[0, 0]), drawn.add_subplot(grid[:, 1])
    lower = drawn.add_subplot(grid[1, 0], sharex=upper)
    shown = slice(5400, 6000)
    minutes = np.arange(600) / 60.0
    upper.plot(minutes, wheel[shown], lw=1.0, color="#0072B2")
    lower.plot(minutes, engine[shown], lw=1.0, color="#D55E00")
    upper.set_ylabel("wheel speed [m/s]")
    lower.set_ylabel("engine speed [rpm]")
    lower.set_xlabel("time from 1.5 h on [min]")
    upper.tick_params(labelbottom=False)
    names = list(LOG_ON)
    right.axvspan(1.0 / 1.5, 1.5, color="#e8e8e8", lw=0)
    right.axvline(1.0, color="#808080", lw=0.8)
    for label, found, mark in (("engine running", on, "o"), ("whole day", whole, "x")):
        known = [name for name in names if name in found]
        at = [names.index(name) for name in known]
        right.plot([found[name] for name in known], at, mark, label=label, ms=5)
    right.set_yticks(range(len(names)), [words(name) for name in names])
    right.invert_yaxis()
    right.set_xscale("log")
    right.set_xticks([0.5, 1 / 1.5, 1.0, 1.5, 2.0], ["0.5", "1/1.5", "1", "1.5", "2"])
    right.minorticks_off()
    right.set_xlim(0.4, 2.5)
    right.set_xlabel("simulated over the log's")
    right.legend(loc="lower left", frameon=False)
    text = io.StringIO()
    drawn.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()


def main() -> None:
    """Drive the day, draw it, and print the table."""
    day = driven()
    whole, on = (drive_statistics(*day, engine_on=which) for which in (False, True))
    with mpl.rc_context(FIGURE | {"svg.hashsalt": "field day"}):
        write_text(PICTURE, figure(day, ratios(whole, LOG), ratios(on, LOG_ON)))
    print("| statistic | log, whole | simulated | log, engine running | simulated |")
    print("|---|---|---|---|---|")
    for name in LOG:
        row = (LOG[name], whole[name], LOG_ON[name], on[name])
        print(f"| {words(name)} | " + " | ".join(f"{value:.3g}" for value in row) + " |")


if __name__ == "__main__":
    main()

"""A made-up log of field work: a road, passes under load, turns, standing; and what was found."""

from __future__ import annotations

import numpy as np

from twin.io.run_folder import Record
from twin.logs.job import Implement
from twin.pipeline.drive import findings
from twin.streams import Setup, Streams


def job(passes=4, *, pull="draft_pin_n", road_mps=8.0):
    """A road, then passes of 60 s at 2 m/s with turns of 20 s, then standing; once a second."""
    legs = [("road", 120, road_mps, 0.0, 0.0)]
    for _ in range(passes):
        legs += [("work", 60, 2.0, 0.0, 1.0), ("turn", 20, 1.5, np.pi / 20, 0.0)]
    legs += [("stand", 30, 0.0, 0.0, 0.0)]
    kind = np.concatenate([[name] * n for name, n, *_ in legs])
    speed, rate, load = (
        np.concatenate([[leg[i]] * leg[1] for leg in legs]).astype(float) for i in (2, 3, 4)
    )
    n = len(kind)
    epoch_ns = np.arange(n) * 10**9
    heading = np.cumsum(rate)
    stamps = {"epoch_ns": epoch_ns, "arrival_ns": epoch_ns}
    gnss = {
        **stamps, "east_m": np.cumsum(speed * np.cos(heading)),
        "north_m": np.cumsum(speed * np.sin(heading)), "v_east_mps": speed * np.cos(heading),
        "v_north_mps": speed * np.sin(heading), "heading_rad": heading,
    }  # fmt: skip
    level = {"draft_pin_n": 20e3 * load, "engine_load": 0.3 + 0.5 * load,
             "hitch_m": 0.5 - 0.6 * load}  # fmt: skip
    machine = {**stamps, "fuel_lph": 5.0 + 20.0 * load}
    if pull:
        machine[pull] = level[pull]
    slip = np.where(kind == "work", 0.1, 0.0)
    slip[200:240] += 0.1  # the second pass
    estimate = {"epoch_ns": epoch_ns, "slip": slip, "speed_mps": speed}
    return Streams({"gnss": gnss, "machine": machine}), estimate, kind


SETUP = Setup(machine="a <tractor>", wheelbase_m=2.5, track_front_m=1.8, track_rear_m=1.8, cg_x_m=1)
STREAMS, ESTIMATE, _ = job(passes=10)
RUN = Record(setup=SETUP, streams=STREAMS, estimates={"ratio": ESTIMATE})
SPREAD = {"median": 0.1, "p05": 0.09, "p95": 0.2, "n": 9}
SCORES = {
    "scenario": "drive", "seed": None, "window_s": None, "estimators": {"ratio": {}},
    "slip": {"ratio": SPREAD}, "notes": ["gnss: <gap> of 5 s"],
    **findings(STREAMS, RUN.estimates, Implement(width_m=3.0)),
}  # fmt: skip

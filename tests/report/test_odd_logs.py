"""Whatever a log holds, its numbers and its page are made, without a warning."""

from __future__ import annotations

import numpy as np
import pytest

from twin.io.run_folder import Record
from twin.logs import Log
from twin.logs.job import Implement
from twin.logs.timeline import MACHINE
from twin.pipeline.drive import findings
from twin.pipeline.protocol import applied
from twin.report.page import page
from twin.streams import Setup, Streams, Table

SETUP = Setup(machine="odd", wheelbase_m=2.5, track_front_m=1.8, track_rear_m=1.8, cg_x_m=1.0)
SENSORS = {
    "gnss": ("east_m", "north_m", "v_east_mps", "v_north_mps", "heading_rad"),
    "wheels": ("speed_rl_mps", "speed_rr_mps"),
    "machine": MACHINE,
    "imu": ("gyro_z_radps",),
}


def odd(rng: np.random.Generator) -> tuple[Streams, dict[str, Table]]:
    """Random sensors, columns, rates, holes, spikes, gaps; epochs out of order and repeated."""
    tables = {}
    for sensor, columns in SENSORS.items():
        if rng.random() < 0.3:
            continue
        n = int(rng.choice([0, 1, 2, 5, 40, 400]))
        step_s = rng.choice([0.01, 0.1, 1.0, 7.0])
        steps = rng.choice([0.0, 1.0, 90.0], n, p=[0.05, 0.94, 0.01]) * step_s
        epoch_ns = ((rng.choice([0.0, 1.7e9]) + np.cumsum(steps)) * 1e9).astype(np.int64)
        arrival_ns = epoch_ns.copy()
        if n > 5 and rng.random() < 0.3:
            epoch_ns[2], epoch_ns[3] = epoch_ns[3], epoch_ns[2]
        chosen = [c for c in columns if rng.random() < 0.8]
        table: Table = {"epoch_ns": epoch_ns, "arrival_ns": arrival_ns}
        for column in chosen:
            values = rng.choice([0.0, 1.0, 3.0, 900.0]) * rng.standard_normal(n).cumsum()
            values = values if rng.random() < 0.8 else np.full(n, rng.choice([0.0, 2.0, np.nan]))
            table[column] = np.where(rng.random(n) < rng.choice([0.0, 0.3, 0.98]), np.nan, values)
        tables[sensor] = table
    times = max((t["epoch_ns"] for t in tables.values()), key=len, default=np.empty(0, np.int64))
    times = np.sort(times)
    slip = np.where(rng.random(len(times)) < 0.3, np.nan, rng.normal(0.1, 0.1, len(times)))
    estimates: dict[str, Table] = {"ratio": {"epoch_ns": times, "slip": slip}}
    if rng.random() < 0.5:
        estimates["ratio"]["speed_mps"] = rng.normal(2.0, 1.0, len(times))
    return Streams(tables), estimates if rng.random() < 0.9 else {}


@pytest.mark.parametrize("seed", range(40))
def test_an_odd_log_has_its_page(seed: int) -> None:
    streams, estimates = odd(np.random.default_rng(seed))
    log, beside = applied(Log(streams=streams, setup=SETUP))
    found = findings(log.streams, estimates, Implement(width_m=3.0))
    run = Record(setup=SETUP, streams=log.streams, estimates=estimates)
    text = page(run, {"scenario": "odd", "slip": {}, **beside, **found})
    assert "nan" not in text.split("<svg")[0].lower().replace("name", "")

"""What `twin bench` measures: time of a physics step, speed and memory of a whole run.

Compared figures are measured in turn in one process, and the best of many short stretches counts,
because the machine's other work only ever adds time.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import mujoco

from twin import runfolder
from twin.commands.run import Options, execute
from twin.machine.build import build
from twin.machine.files import model_path
from twin.machine.simulate import Cab
from twin.registry import load
from twin.rows import row
from twin.scenario import Course, Field, Scenario, Soil

STRETCHES, STEPS = 60, 200
NO_SENSORS = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)


def rows() -> list[dict[str, Any]]:
    """All measurements, as rows with their bounds."""
    return [*step_rows(), *run_rows()]


def step_rows() -> list[dict[str, Any]]:
    """Time of a step while ploughing, against MuJoCo's own contacts, and of what adds to it."""
    rough = load("scenario", "plough-25cm")
    grounds = {
        "rough": rough,
        "plane": replace(rough, field=Field()),
        "soil map": load("scenario", "plough-patchy"),
        "bekker": replace(rough, soil=Soil(preset="lete-sand", law="bekker")),
        "brixius": replace(rough, soil=Soil(preset="lete-sand", cone_index_kpa=1200.0)),
    }
    cases = [*(_ploughing(scenario) for scenario in grounds.values()), _native()]
    times = _best(*(partial(mujoco.mj_step, *case, STEPS) for case in cases))
    own_us, plane_us, map_us, bekker_us, brixius_us, native_us = times
    case = "physics step, ploughing, sensors off"
    return [
        row(case, "time with the soil law", own_us, "us"),
        row(case, "time on MuJoCo's own contacts", native_us, "us"),
        row(case, "ratio", own_us / native_us, "1", high=0.8),
        row(case, "time on a height field over a plane's", own_us / plane_us, "1", high=1.2),
        row(case, "the same with a map of two soils", map_us / plane_us, "1"),
        row(case, "time by Bekker-Wong over Brixius'", bekker_us / brixius_us, "1", high=2.0),
    ]


def _ploughing(scenario: Scenario) -> tuple[Any, Any]:
    """A ploughing machine at its depth, sensors off."""
    cab = Cab(build(scenario))
    while cab.observe().depth_m < 0.24:
        cab.act()
    model = cab.batch.get_model(0)
    model.opt.disableflags = NO_SENSORS
    return model, cab.batch.get_data(0)


def _native() -> tuple[Any, Any]:
    """The machine's scene as it stands in plain MuJoCo, settled, then rolling at 1.5 m/s."""
    spec = mujoco.MjSpec.from_file(str(model_path("taishan_1404a").parent / "scene.xml"))
    spec.compiler.discardvisual = True  # as ours is compiled: looks cost time and change nothing
    model = spec.compile()
    model.opt.disableflags = NO_SENSORS
    state = mujoco.MjData(model)
    mujoco.mj_step(model, state, 2000)
    state.qvel[0] = 1.5
    for wheel, radius_m in (("fl", 0.62), ("fr", 0.62), ("rl", 0.83), ("rr", 0.83)):
        state.joint(f"taishan_1404a/{wheel}_spin").qvel[0] = 1.5 / radius_m
    return model, state


def _best(*actions: Callable[[], None]) -> list[float]:
    """Shortest time of each action per step [us], the actions taken in turn."""
    best = [float("inf")] * len(actions)
    for _ in range(STRETCHES):
        for i, action in enumerate(actions):
            start = time.perf_counter()
            action()
            best[i] = min(best[i], (time.perf_counter() - start) / STEPS * 1e6)
    return best


def run_rows() -> list[dict[str, Any]]:
    """Speed and memory of a whole run, files written, imports and compiling done before."""
    scenario = load("scenario", "plough-25cm")
    with tempfile.TemporaryDirectory() as folder:
        short = replace(scenario, course=Course(length_m=5.0))
        execute(short, Options(out=Path(folder) / "first", quiet=True))
        start = time.perf_counter()
        directory = execute(scenario, Options(out=Path(folder) / "second", quiet=True))
        wall_s = time.perf_counter() - start
        truth = runfolder.read(directory).truth or {}
        simulated_s = float(truth["epoch_ns"][-1]) * 1e-9
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    peak_mb = peak / (1e6 if sys.platform == "darwin" else 1e3)
    case = "plough-25cm, files written"
    return [
        row(case, "simulated time per wall time", simulated_s / wall_s, "1", low=30.0),
        row(case, "wall time", wall_s, "s"),
        row(case, "peak memory", peak_mb, "MB", high=700.0),
    ]

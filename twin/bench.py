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
from twin.scenario import Course

STRETCHES, STEPS = 60, 200
NO_SENSORS = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)


def rows() -> list[dict[str, Any]]:
    """All measurements, as rows with their bounds."""
    return [*step_rows(), *run_rows()]


def step_rows() -> list[dict[str, Any]]:
    """Time of a step while ploughing, against the same machine on MuJoCo's own contacts."""
    cab = Cab(build(load("scenario", "plough-25cm")))
    while cab.observe().depth_m < 0.24:
        cab.act()
    ours, ours_state = cab.batch.get_model(0), cab.batch.get_data(0)
    native, native_state = _native()
    ours.opt.disableflags = native.opt.disableflags = NO_SENSORS
    own_us, native_us = _best(
        lambda: mujoco.mj_step(ours, ours_state, STEPS),
        lambda: mujoco.mj_step(native, native_state, STEPS),
    )
    case = "physics step, ploughing, sensors off"
    return [
        row(case, "time with the soil law", own_us, "us"),
        row(case, "time on MuJoCo's own contacts", native_us, "us"),
        row(case, "ratio", own_us / native_us, "1", high=0.8),
    ]


def _native() -> tuple[Any, Any]:
    """The machine's scene as it stands in plain MuJoCo, settled, then rolling at 1.5 m/s."""
    spec = mujoco.MjSpec.from_file(str(model_path("taishan_1404a").parent / "scene.xml"))
    spec.compiler.discardvisual = True  # as ours is compiled: looks cost time and change nothing
    model = spec.compile()
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

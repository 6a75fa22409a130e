"""Lists of events drawn at random, and what no driver could do."""

from dataclasses import dataclass

import numpy as np

from tests.simulation.closure import Balance, balance
from twin.errors import TwinError
from twin.scenario import Course, Driver, Event, Field, Plough, Scenario
from twin.simulation.build import build
from twin.simulation.simulate import simulate
from twin.trajectory.phase import Phase

MACHINES = ("taishan_1404a", "nh_t7165s", "jd_8245r", "electric_tractor")
DRIVEN_S = 40.0
"""So much of a drive is looked at."""
TURNS_MPS = 0.3
"""Faster than this no driver changes the direction of the gear."""


def drawn(seed):
    """The scenario of a seed. Raises TwinError where its events do not go together."""
    rng = np.random.default_rng([25, seed])
    machine = MACHINES[rng.integers(4)]
    ploughs = machine != "electric_tractor" and rng.random() < 0.7
    passes = 1 if rng.random() < 0.7 else 2
    times = np.sort(rng.uniform(0.5, 25.0, rng.integers(1, 7)))
    return Scenario(
        name=f"test-random-{seed}", machine=machine, seed=seed,
        field=Field(grade_deg=float(rng.uniform(-12.0, 12.0)) if passes == 1 else 0.0),
        plough=Plough(depth_m=float(rng.uniform(0.1, 0.28))) if ploughs else None,
        course=Course(
            length_m=float(rng.uniform(10.0, 40.0)), passes=passes,
            headland=("loop", "backing")[rng.integers(2)],
        ),
        driver=Driver(
            shifts=bool(rng.random() < 0.5), starts_standing=bool(rng.random() < 0.3),
            reaction_s=float(rng.uniform(0.1, 1.0)),
            headland_kmh=float(rng.uniform(2.0, 6.0)) if rng.random() < 0.4 else None,
        ),
        events=tuple(event(rng, float(t), machine) for t in times),
    )  # fmt: skip


def event(rng, at_s, machine):
    """One event, most by time, some on a condition."""
    most_kg = 40.0 if machine == "electric_tractor" else 400.0
    kinds = {
        "throttle": {"engine_rpm": float(rng.uniform(950.0, 2200.0))},
        "shift": {"by": int(rng.integers(-4, 5))}
        if rng.random() < 0.6
        else {"kmh": float(rng.uniform(2.0, 15.0))},
        "clutch": {"pedal": float(rng.random()), "for_s": float(rng.uniform(0.2, 3.0))},
        "brake": {"pedal": float(rng.random()), "for_s": float(rng.uniform(0.2, 3.0))},
        "stop": {"for_s": float(rng.uniform(0.0, 5.0)), "engine_off": bool(rng.random() < 0.3)},
        "reverse": {"distance_m": float(rng.uniform(0.5, 5.0))},
        "lift": {},
        "lower": {},
        "depth": {"depth_m": float(rng.uniform(0.1, 0.28))},
        "front_drive": {"engaged": bool(rng.random() < 0.6)},
        "lock": {"engaged": bool(rng.random() < 0.5)},
        "mass": {"mass_kg": float(most_kg * rng.uniform(0.125, 1.0)), "rate_kgps": 50.0},
    }
    do = list(kinds)[rng.integers(len(kinds))]
    when = {"at_s": at_s}
    if rng.random() < 0.2:
        when = {"when": f"engine_rpm < {rng.uniform(900.0, 1600.0):.0f}", "times": 2}
    return Event(do=do, **when, **kinds[do])


@dataclass(frozen=True)
class Drive:
    """What is looked at of a drive."""

    scenario: Scenario
    balance: Balance
    wrong: tuple[str, ...]
    """What no driver could do."""
    last: np.ndarray
    end: str


def drive(seed):
    """Drive a seed's scenario; None where it is refused."""
    try:
        scenario = drawn(seed)
        machine = build(scenario)
    except TwinError:
        return None
    chunks = []
    for chunk in simulate(machine):
        chunks.append(chunk)
        if chunk.epoch_ns[-1] > DRIVEN_S * 1e9:
            break
    columns = {n: np.concatenate([c[n] for c in chunks]) for n in chunks[0].columns}
    return Drive(
        scenario, balance(chunks), tuple(wrongs(scenario, columns)),
        columns["position_w"][-1], str(chunks[-1].end),
    )  # fmt: skip


def wrongs(scenario, columns):
    """States that no driver could be in."""
    ratio, box = columns["gear_ratio"], scenario.gearbox
    speed = columns["wheel_speed_x_mps"][:, 2:].mean(axis=1)
    for name, values in columns.items():
        free = scenario.plough is None and name in (
            "laser_m", "inclination_rad", "plough_pitch_rad"
        )  # fmt: skip
        if not free and not np.isfinite(values).all():
            yield f"{name} is not finite"
    low, high = min(box.ratios) * (1.0 - 1e-9), max(box.ratios) * (1.0 + 1e-9)
    if box.stepless:
        if np.any((np.abs(ratio) < low) | (np.abs(ratio) > high)):
            yield "a ratio that the machine has not"
    elif not set(np.abs(ratio).tolist()) <= set(box.ratios):
        yield "a gear that the machine has not"
    turned = np.flatnonzero(np.diff(np.sign(ratio)))
    if np.any(np.abs(speed[turned]) > TURNS_MPS):
        yield f"the direction changed at {np.abs(speed[turned]).max():.2f} m/s"
    rpm = columns["engine_radps"] * 30.0 / np.pi
    if scenario.facts.diesel and rpm.min() < -30.0:
        yield f"an engine that turns backwards at {rpm.min():.0f} rpm"
    if rpm.max() > 1.2 * scenario.facts.numbers["engine.no_load_rpm"]:
        yield f"an engine at {rpm.max():.0f} rpm"
    backing = (ratio < 0.0) & (speed < -0.5)
    if scenario.plough is not None and np.any(columns["depth_m"][backing] > 0.15):
        yield "backing with the implement in the ground"
    if not set(np.unique(columns["phase"])) <= {float(p) for p in Phase}:
        yield "a phase that is none"

"""Layer 1: what holds a machine downhill at full throttle, and what its engine gives at most."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from twin.physics import block
from twin.physics.engine import full_load_torque_nm
from twin.scenario import Course, Drive, Field, Scenario, Soil
from twin.simulation.build import build
from twin.simulation.simulate import simulate
from twin.trajectory.end import OVERSPEED
from twin.validate.check import Basis, Check, near, within

GRADES_DEG = (-6.0, -15.0)
GEARS = (66.0, 45.0, 30.0)
TAISHAN = Scenario(name="validate-downhill", course=Course(approach_m=1.0, length_m=60.0))
ELECTRIC = Scenario(
    name="validate-downhill-electric",
    machine="electric_tractor",
    soil=Soil(preset="dry"),
    drive=Drive(gear_ratio=50.0, engine_set_rpm=3000.0),
    course=Course(approach_m=1.0, length_m=20.0),
)
SOURCE = "engine drag by Millington and Hartles (SAE 680590) or regeneration, and service brakes"


def downhill() -> list[Check]:
    """Greatest engine speed down two grades, and whether the weight's power is accounted for."""
    out = []
    for grade_deg in GRADES_DEG:
        field = Field(grade_deg=grade_deg)
        drives = {
            f"Taishan, gear ratio {g:g}": _drive(
                TAISHAN, field, Drive(gear_ratio=g, engine_set_rpm=2400.0)
            )
            for g in GEARS
        } | {"electric tractor": _drive(ELECTRIC, field, ELECTRIC.drive)}
        out += [
            within(
                f"{grade_deg:g} deg, {name}",
                "greatest engine speed over no-load speed",
                seen["speed"],
                "1",
                high=OVERSPEED,
                basis=Basis(
                    source=SOURCE,
                    grade="assumed",
                    why="what a diesel stands; the driver's habits are assumed",
                ),
            )
            for name, seen in drives.items()
        ]
        steepest = drives[f"Taishan, gear ratio {GEARS[-1]:g}"]
        out.append(
            near(
                f"{grade_deg:g} deg, Taishan, gear ratio {GEARS[-1]:g}",
                "losses and stores over the work of the weight",
                steepest["closure"],
                "1",
                1.0,
                absolute=0.01,
                basis=Basis(
                    source="conservation of energy",
                    grade="derived",
                    why="every loss is computed from its own force and speed, brakes among them",
                ),
            )
        )
    braked = within(
        f"{grade_deg:g} deg, Taishan, gear ratio {GEARS[-1]:g}",
        "work of the brakes over the weight's",
        steepest["brake"],
        "1",
        low=0.1,
        high=0.6,
        basis=Basis(
            grade="derived",
            source="m g sin(15) r = 11.3 kN m at the axle; motored engine 4.0, rolling and slip "
            "3.5 to 4",
            why="the brakes take what is left, less while they are not yet pressed",
        ),
    )
    return [*out, braked, _most_power()]


def _drive(scenario: Scenario, field: Field, drive: Drive) -> dict[str, float]:
    """Engine speed over no-load, the brakes' share of the weight's power, and how that closes."""
    machine = build(replace(scenario, field=field, drive=drive))
    chunks = list(simulate(machine))
    columns = {n: np.concatenate([c[n] for c in chunks]) for n in chunks[0].columns}
    rpm = columns["engine_radps"] * 30.0 / np.pi
    dt_s = machine.scenario.timestep_s
    gone_j = columns["potential_j"][0] - columns["potential_j"]
    losses = [n for n in columns if n.startswith("power_") and n != "power_engine_w"]
    spent_j = dt_s * float(sum(columns[n].sum() for n in losses) - columns["power_engine_w"].sum())
    gained_j = float(columns["kinetic_j"][-1] - columns["kinetic_j"][0])
    return {
        "speed": float(rpm.max() / machine.numbers["engine.no_load_rpm"]),
        "brake": dt_s * float(columns["power_brake_w"].sum()) / float(gone_j[-1]),
        "closure": (spent_j + gained_j) / float(gone_j[-1]),
    }


def _most_power() -> Check:
    """The full-load curve at every whole speed."""
    machine = build(TAISHAN, settle=False)
    engine = machine.model.numeric_data[-block.SIZE :][block.ENGINE : block.COUPLING]
    rpm = np.arange(1.0, machine.numbers["engine.no_load_rpm"] + 1.0)
    power_w = np.array([full_load_torque_nm(engine, n) * n * np.pi / 30.0 for n in rpm])
    return within(
        "full load, any speed",
        "greatest crank power over the stated",
        power_w.max() / 103e3,
        "1",
        low=0.99,
        high=1.01,
        basis=Basis(
            source="Fu et al., table 1: 103 kW",
            grade="published",
            why="a torque curve has a stated maximum power; peak torque and speeds are assumed",
        ),
    )

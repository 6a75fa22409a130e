"""Parameter blocks written out by hand, from the published numbers and not from the models."""

import numpy as np

from twin.machine.tread import tread_part
from twin.physics.block import Coupling, Engine, Field, Plough, Soil, Wheel


def filled(size, values):
    out = np.zeros(size)
    for index, value in values.items():
        out[index] = value
    return out


def soil(*, cone_index_kpa=1000.0, radial=False, **own):
    """Brixius 1987: bias or radial tyre on a cohesive-frictional soil."""
    values = {
        Soil.FRICTION: 0.88,
        Soil.CONE_INDEX_KPA: cone_index_kpa,
        Soil.SLIP_RATE: 9.5 if radial else 7.5,
        Soil.ROLLING_MOMENT: 0.0325 if radial else 0.04,
        Soil.MOBILITY_RESISTANCE: 0.9 if radial else 1.0,
        Soil.DRAFT_SCALE: 0.85,
        Soil.DRAFT_LENGTH_M: 4.0,
    }
    return filled(Soil.SIZE, values | {Soil[name.upper()]: x for name, x in own.items()})


def with_tread(values):
    """A wheel's numbers and those derived of them."""
    return filled(Wheel.SIZE, values | tread_part(values))


def wheel():
    """18.4-38 bias tyre: b 0.467 m, d 1.755 m, deflection a fifth of the section height."""
    return with_tread(
        {
            Wheel.WIDTH_M: 0.467,
            Wheel.DIAMETER_M: 1.755,
            Wheel.DEFLECTION_RATIO: 0.2,
            Wheel.FREE_ROLLING_RADIUS_M: 0.8489,
            Wheel.STIFFNESS_NPM: 383e3,
            Wheel.DAMPING_NSPM: 3500.0,
            Wheel.RELAXATION_LONG_M: 0.2,
            Wheel.RELAXATION_LAT_M: 0.7,
            Wheel.LATERAL_RATIO: 0.85,
            Wheel.SHEAR_DAMPING_S: 0.2,
            Wheel.NOMINAL_LOAD_N: 21.7e3,
            Wheel.INERTIA_KGM2: 95.0,
        },
    )


def soil_of_mobility(number, load_n, *, radial=False):
    """A soil whose cone index gives the tyre a chosen mobility number."""
    b, d = 0.467, 1.755
    bracket = (1.0 + 5.0 * 0.2) / (1.0 + 3.0 * b / d)
    return soil(cone_index_kpa=number * load_n / (1e3 * b * d * bracket), radial=radial)


def engine(**own):
    """447 N m at 2200 rpm, 30 % torque rise at 1450 rpm, governed to 2376 rpm; `own` by name."""
    return filled(
        Engine.SIZE,
        {
            Engine.RATED_TORQUE_NM: 447.0,
            Engine.RATED_RPM: 2200.0,
            Engine.TORQUE_RISE: 1.30,
            Engine.PEAK_RPM: 1450.0,
            Engine.NO_LOAD_RPM: 2376.0,
            Engine.IDLE_RPM: 800.0,
            Engine.DROOP_RPM_PER_NM: 0.394,
            Engine.PARASITIC_NM: 25.0,
            Engine.TRANSMISSION_EFFICIENCY: 0.87,
            Engine.MAX_POWER_W: 103e3,
            Engine.DISPLACEMENT_M3: 6.5e-3,
            Engine.STROKE_M: 0.125,
            Engine.GEAR_RATIO: 66.0,
        }
        | {Engine[name.upper()]: x for name, x in own.items()},
    )


def motor(**own):
    """8 N m and 1 kW, of which it takes half back; 20 rpm/(N m) at 3000 rpm; `own` by name."""
    values = {
        "kind": 1.0, "rated_torque_nm": 8.0, "rated_rpm": 1200.0, "no_load_rpm": 3000.0,
        "idle_rpm": 0.0, "droop_rpm_per_nm": 20.0, "parasitic_nm": 0.1, "max_power_w": 1000.0,
        "regeneration_w": 500.0, "transmission_efficiency": 0.85, "displacement_m3": 0.0,
        "stroke_m": 0.0, "gear_ratio": 50.0,
    }  # fmt: skip
    return engine(**(values | own))


def element():
    """A brake: 15 kN m at a twist of 0.01 rad."""
    values = {Coupling.CAPACITY_NM: 15e3, Coupling.WINDUP_RAD: 0.01, Coupling.DAMPING_S: 0.02}
    return filled(Coupling.SIZE, values)


def plough():
    """Four bodies of 0.35 m; ASABE D497 mould-board numbers."""
    return filled(
        Plough.SIZE,
        {
            Plough.BODIES: 4,
            Plough.BODY_WIDTH_M: 0.35,
            Plough.DRAFT_A: 652.0,
            Plough.DRAFT_C: 5.1,
            Plough.DRAFT_WIDTH: 0.35,
            Plough.FACTOR_MEDIUM: 0.70,
            Plough.FACTOR_COARSE: 0.45,
            Plough.VERTICAL_RATIO: 0.2,
            Plough.FORCE_DEPTH_RATIO: 2.0 / 3.0,
            Plough.SIDE_RATIO: 0.25,
            Plough.WHEEL_RADIUS_M: 0.3,
            Plough.WHEEL_STIFFNESS_NPM: 120e3,
            Plough.WHEEL_DAMPING_NSPM: 4000.0,
            Plough.WHEEL_RESISTANCE_RATIO: 0.1,
            Plough.SOIL_STIFFNESS_NPM: 500e3,
        },
    )


def level(**own):
    """Ground through the world's origin, level, smooth, without a furrow; `own` by field name."""
    values = {Field.AHEAD: 1.0, Field.LEFT + 1: 1.0, Field.NORMAL + 2: 1.0, Field.SEED: 1.0}
    values |= {Field.PASS_WAY: 1.0, Field.FURROW_END_M: 1e9}
    return filled(Field.SIZE, values | {Field[name.upper()]: x for name, x in own.items()})


NO_NODES = np.zeros(1, dtype=np.float32)
"""What a model without height fields has for their nodes."""


def furrowed(side, **own):
    """A furrow 0.25 m deep on one side (+1 left), from 10 m on, at its depth 3 m later."""
    shape = {
        "furrow_side": side,
        "furrow_depth_m": 0.25,
        "furrow_edge_m": 0.65,
        "furrow_start_m": 10.0,
        "furrow_ramp_m": 3.0,
        "furrow_width_m": 0.5,
        "wall_stiffness_npm": 400e3,
        "wall_damping_nspm": 20e3,
    }
    return level(**(shape | own))

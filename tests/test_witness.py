"""Every field of a scenario turns something: it changes truth or streams, or is refused by name.

The fields are found by walking the dataclasses,
so a new one without a witness fails. A witness is a
scenario as short as will do, and another value of the field in it.
"""

import dataclasses
import re
import types
import typing
from functools import cache

import numpy as np
import pytest

from scenarios.ima_pkf import DISTURBED, Trial
from twin.errors import BadInput
from twin.pipeline.run import run
from twin.scenario import Course, Drive, Event, Field, Patch, Plough, Scenario, Soil
from twin.scenario.fields import replaced
from twin.sensors import Camera, Fault, Gnss, Outage, Sensors

NOT_TURNED = {
    "name", "about", "soil.numbers.name", "soil.numbers.about",  # names and texts
    "soil.numbers", "soil.numbers.deformable",  # kept numbers, which repeat what the preset says
}  # fmt: skip
OF_THE_FIELD = {
    f"field.other_soil.{name}"
    for name in (
        "draft_cv", "draft_length_m", "ripple_cv", "strength_cv", "rocks_per_100m2", "rock_kn",
    )
}  # fmt: skip
"""What the other soil never has of its own: always refused."""
LISTS = ("events", "field.patches", "sensors.faults", "sensors.gnss.outages")

ROLLING = Scenario(
    name="rolling",
    field=Field(cross_slope_deg=8.0),
    course=Course(approach_m=0.5, length_m=1.0, start_left_m=0.1),
    sensors=Sensors(gnss=None, imu=None, wheels=None, depth=None, machine=None),
)
LONG = replaced(ROLLING, {"course": Course(approach_m=15.0, length_m=1.0)})
PLOUGHING = replaced(
    ROLLING,
    {"plough": Plough(), "course": Course(approach_m=1.0, length_m=1.0), "sensors": Sensors()},
)
TURNING = replaced(LONG, {"course.passes": 2})
OUTAGES = (
    Outage(start_s=0.1, duration_s=0.1, kind="corrections"),
    Outage(start_s=0.3, duration_s=0.2, kind="mask"),
    Outage(start_s=0.6, duration_s=0.1, kind="block"),
)


@dataclasses.dataclass(frozen=True)
class Refused:
    """A value of a field that this witness does not read."""

    value: object


BASES = {
    "rolling": ROLLING,
    "long": LONG,
    "ploughing": PLOUGHING,
    "held": replaced(
        PLOUGHING,
        {"plough": Plough(hitch="mix", expected_draft_scale=1.5), "course.length_m": 4.0},
    ),
    "floating": replaced(PLOUGHING, {"plough.hitch": "float"}),
    "kept": PLOUGHING.with_numbers(),
    "bekker": replaced(PLOUGHING, {"soil.law": "bekker"}),
    "bekker kept": replaced(PLOUGHING, {"soil.law": "bekker"}).with_numbers(),
    "rocky": replaced(PLOUGHING, {"soil.rocks_per_100m2": 25.0, "course.length_m": 3.0}),
    "mapped": replaced(ROLLING, {"field.height_map": "heights.npy", "field.soil_map": "soils.npy"}),
    "mixed": replaced(
        PLOUGHING,
        {
            "field.other_share": 0.5,
            "field.other_length_m": 2.0,
            "field.other_soil": Soil(preset="soft", law="bekker"),
        },
    ),
    "patched": replaced(ROLLING, {"field.patches": (Patch(start_m=0.5, length_m=0.5,
    friction_factor=0.8),)}),
    "electric": replaced(
        ROLLING,
        {
            "machine": "electric_tractor",
            "drive": Drive(gear_ratio=50.0, engine_set_rpm=2400.0, differential_lock=False),
            "course.edge_m": 1.0,
            "course.start_left_m": 0.25,
        },
    ),
    "sensing": replaced(ROLLING, {"sensors": Sensors()}),
    "stuck": replaced(
        PLOUGHING,
        {"plough.depth_m": 0.35, "soil.draft_scale": 2.0, "sensors.gnss": Gnss()},
    ),
    "failing": replaced(
        ROLLING,
        {
            "course.length_m": 2.5,
            "sensors": Sensors(
                gnss=Gnss(outages=OUTAGES),
                faults=(Fault(kind="imu-bias", start_s=0.2, duration_s=0.3),),
            )
        },
    ),
    "looking": replaced(
        ROLLING,
        {
            "sensors.camera": Camera(
                width_px=160, height_px=120, position_m=(1.25, 0.0, -0.33), rate_hz=20.0
            )
        },
    ),
    "told": replaced(
        ROLLING,
        {
            "course.length_m": 5.0,
            "events": (
                Event(do="throttle", at_s=0.3, engine_rpm=1500.0),
                Event(do="clutch", at_s=0.6, pedal=0.7, for_s=0.3),
                Event(do="lock", at_s=1.0, engaged=False),
                Event(do="mass", at_s=1.2, tank="seed", mass_kg=300.0, rate_kgps=100.0),
            ),
        },
    ),
    "shifting": replaced(
        ROLLING,
        {
            "course.length_m": 6.0,
            "events": (
                Event(do="shift", at_s=0.3, gear=9),
                Event(do="shift", at_s=1.3, kmh=4.0),
                Event(do="shift", at_s=2.3, by=1),
            ),
        },
    ),
    "stopping": replaced(
        ROLLING,
        {
            "course.length_m": 10.0,
            "events": (
                Event(do="stop", at_m=1.0, for_s=0.5),
                Event(do="reverse", distance_m=1.0),
                Event(do="stop", at_m=5.0, for_s=1.0),
                Event(do="mass", when="speed_kmh < 1", mass_kg=100.0, rate_kgps=100.0),
            ),
        },
    ),
    "deeper": replaced(
        PLOUGHING,
        {"course.length_m": 4.0, "events": (Event(do="depth", at_m=2.5, depth_m=0.2),)},
    ),
    "turning": replaced(
        TURNING, {"events": (Event(do="brake", at_m=5.0, in_pass=1, pedal=0.3, for_s=0.3),)}
    ),
    "backing": replaced(TURNING, {"course.headland": "backing", "driver.headland_rpm": 1400.0}),
    "road": replaced(TURNING, {"course.road_m": 20.0}),
    "signals": DISTURBED,
    "downhill": replaced(
        ROLLING, {"field.grade_deg": -15.0, "course.length_m": 8.0, "drive.gear_ratio": 40.0}
    ),
}  # fmt: skip

WITNESSES: dict[str, dict[str, object]] = {
    "rolling": {
        "machine": "electric_tractor", "plough": Plough(), "timestep_s": 0.001, "seed": 1,
        "zero_slip": "field-pull",
        "field.cross_slope_deg": 5.0, "field.grade_deg": 3.0, "field.roughness_class": "D",
        "field.height_map": "heights.npy", "field.soil_map": "soils.npy", "field.other_share": 0.5,
        "field.patches": (Patch(start_m=0.5, length_m=1.0, friction_factor=0.5),),
        "drive.gear_ratio": 50.0, "drive.engine_set_rpm": 1500.0, "drive.all_wheel_drive": True,
        "drive.gear_kmh": 5.0,
        "drive.differential_lock": False, "course.approach_m": 0.7, "course.length_m": 1.2,
        "course.heading_deg": 30.0, "course.start_left_m": 0.0, "course.hold_line": False,
        "soil.strength_cv": 0.2, "soil.draft_scale": Refused(0.5),
        "sensors.gnss": Gnss(), "sensors.camera": Camera(width_px=160, height_px=120),
        "events": (Event(do="brake", at_s=0.2, pedal=0.5, for_s=0.3),),
        "driver.starts_standing": True, "driver.reaction_s": Refused(1.0),
        "driver.pause_s": Refused(1.0), "driver.headland_rpm": Refused(1400.0),
        "driver.headland_kmh": Refused(3.0), "driver.headland_rpm_sd": Refused(100.0),
        "driver.road_rpm": Refused(1500.0), "driver.road_kmh": Refused(4.0),
        "course.headland": Refused("backing"), "course.backings": Refused(2),
    },
    "long": {"course.passes": 2},
    "downhill": {"drive.exhaust_brake": True},
    "ploughing": {
        "implement": "plough_3",
        "soil.preset": "soft", "soil.law": "bekker", "soil.friction": 0.6,
        "soil.cone_index_kpa": 800.0, "soil.draft_scale": 0.5, "soil.draft_cv": 0.3,
        "soil.draft_length_m": 1.0, "soil.ripple_cv": 0.3, "soil.strength_cv": 0.2,
        "soil.rocks_per_100m2": 25.0, "soil.rock_kn": Refused(20.0),
        "soil.cohesion_kpa": Refused(20.0),
        "plough.depth_m": 0.2, "plough.wheel_share": 0.3, "plough.furrow": "none",
        "plough.hitch": "float", "plough.expected_draft_scale": 0.5,
        "plough.drop_rate_radps": 0.2, "plough.upper_limit_rad": 0.5,
        "plough.front_ballast_kg": 200.0, "plough.top_link_drop_m": 0.1,
        "plough.draft_mix": Refused(0.7), "plough.sensitivity_rad": Refused(0.1),
        "plough.deepest_m": Refused(0.3), "field.other_soil.preset": Refused("firm"),
        "sensors.depth": None, "sensors.machine": None, "sensors.wheels": None,
        "sensors.imu": None,
        "sensors.depth.rate_hz": 25.0, "sensors.depth.laser_sd_m": 0.01,
        "sensors.depth.clod_sd_m": 0.01, "sensors.depth.clod_length_m": 0.3,
        "sensors.depth.inclinometer_sd_rad": 0.01, "sensors.depth.latency_s": 0.01,
        "sensors.depth.latency_jitter_s": 0.001, "sensors.depth.laser_bias_m": 0.01,
        "sensors.depth.inclination_bias_rad": 0.01,
        "sensors.machine.rate_hz": 20.0, "sensors.machine.latency_s": 0.02,
        "sensors.machine.latency_jitter_s": 0.004, "sensors.machine.reference_torque_nm": 500.0,
        "sensors.machine.lower_link_m": 0.8,
        "sensors.machine.steer_sd_rad": 0.02, "sensors.machine.draft_pin_sd_n": 900.0,
        "sensors.machine.engine_sd_radps": 0.4,
        "sensors.machine.axle_torque_sd_nm": 300.0, "sensors.machine.steer_bias_rad": 0.02,
        "sensors.machine.draft_pin_scale_error": 0.1,
    },
    "held": {
        "plough.draft_mix": 0.8, "plough.sensitivity_rad": 0.04, "plough.deepest_m": 0.25,
        "plough.wheel_share": 0.3,
    },
    "floating": {"plough.wheel_share": Refused(0.3), "plough.expected_draft_scale": 0.5},
    "rocky": {"soil.rock_kn": 30.0},
    "kept": {
        "soil.numbers.cone_index_kpa": 800.0, "soil.numbers.friction": 0.6,
        "soil.numbers.front_grip": 0.5, "soil.numbers.slip_rate": 9.0,
        "soil.numbers.rolling_moment": 0.03, "soil.numbers.mobility_resistance": 0.5,
        "soil.numbers.strength_cv": 0.2, "soil.numbers.draft_scale": 0.5,
    },
    "bekker": {
        "soil.friction": 0.6, "soil.cone_index_kpa": Refused(800.0), "soil.k_c_kn_per_m_n1": 50.0,
        "soil.k_phi_kn_per_m_n2": 2000.0, "soil.sinkage_exponent": 0.7, "soil.cohesion_kpa": 20.0,
        "soil.friction_angle_deg": 25.0, "soil.shear_modulus_m": 0.03,
        "soil.lateral_shear_ratio": 2.0, "soil.unit_weight_knpm3": 20.0, "soil.stress_peak": 0.3,
        "soil.stress_peak_slip": 0.3, "soil.slip_sinkage": 0.5, "soil.strength_cv": 0.2,
    },
    "bekker kept": {
        "soil.numbers.deformable.k_c_kn_per_m_n1": 50.0,
        "soil.numbers.deformable.k_phi_kn_per_m_n2": 2000.0,
        "soil.numbers.deformable.sinkage_exponent": 0.7,
        "soil.numbers.deformable.cohesion_kpa": 20.0,
        "soil.numbers.deformable.friction_angle_deg": 25.0,
        "soil.numbers.deformable.shear_modulus_m": 0.03,
        "soil.numbers.deformable.lateral_shear_ratio": 2.0,
        "soil.numbers.deformable.unit_weight_knpm3": 20.0,
        "soil.numbers.deformable.stress_peak": 0.3,
        "soil.numbers.deformable.stress_peak_slip": 0.3,
        "soil.numbers.deformable.slip_sinkage": 0.5,
    },
    "mapped": {"field.map_cell_m": 0.2, "field.map_start_m": -1.0},
    "mixed": {
        "field.other_length_m": 4.0,
        **{f"field.other_soil.{name}": value for name, value in {
            "preset": "tilled", "law": "brixius", "friction": 0.5, "cone_index_kpa": 800.0,
            "draft_scale": 0.9, "draft_cv": Refused(0.3), "draft_length_m": Refused(1.0),
            "ripple_cv": Refused(0.3),
            "strength_cv": Refused(0.2), "rocks_per_100m2": Refused(25.0), "rock_kn": Refused(20.0),
            "k_c_kn_per_m_n1": 50.0, "k_phi_kn_per_m_n2": 2000.0, "sinkage_exponent": 0.7,
            "cohesion_kpa": 10.0, "friction_angle_deg": 25.0, "shear_modulus_m": 0.03,
            "lateral_shear_ratio": 2.0, "unit_weight_knpm3": 20.0, "stress_peak": 0.3,
            "stress_peak_slip": 0.3, "slip_sinkage": 0.5,
        }.items()},
        **{f"soil.{name}": value for name, value in {
            "cone_index_kpa": 800.0, "cohesion_kpa": 10.0, "friction": 0.5,
        }.items()},
    },
    "patched": {
        "field.patches.0.start_m": 0.7, "field.patches.0.length_m": 0.8,
        "field.patches.0.friction_factor": 0.5, "field.patches.0.cone_index_factor": 0.5,
    },
    "electric": {
        "drive.gear_ratio": 60.0, "drive.engine_set_rpm": 2000.0, "drive.all_wheel_drive": True,
        "drive.differential_lock": True, "course.edge_m": 0.5, "course.approach_m": 0.7,
        "course.length_m": 1.2, "course.hold_line": False, "course.start_left_m": 0.0,
    },
    "sensing": {
        "course.calibration_m": 5.0, "soil.draft_cv": Refused(0.3),
        "sensors.depth.laser_sd_m": Refused(0.01),
        "sensors.gnss.rate_hz": 10.0, "sensors.gnss.latency_s": 0.1,
        "sensors.gnss.latency_jitter_s": 0.02, "sensors.gnss.white_sd_m": 0.01,
        "sensors.gnss.coloured_sd_m": 0.01, "sensors.gnss.coloured_tau_s": 10.0,
        "sensors.gnss.vertical_factor": 1.0, "sensors.gnss.velocity_sd_mps": 0.1,
        "sensors.gnss.heading_sd_rad_m": 0.01, "sensors.gnss.satellites_main": 20.0,
        "sensors.gnss.satellites_aux": 20.0, "sensors.gnss.heading_bias_rad": 0.1,
        "sensors.gnss.heading_bias_sd_rad": 0.1,
        "sensors.gnss.lever_arm_error_m": (0.1, 0.0, 0.0), "sensors.gnss.outages": OUTAGES,
        "sensors.gnss.float_sd_m": Refused(0.5), "sensors.gnss.single_tau_s": Refused(10.0),
        "sensors.faults": (Fault(kind="imu-bias", start_s=0.2, duration_s=0.3),),
        "sensors.ignition_off_s": ((0.2, 0.1),),
        "sensors.imu.rate_hz": 40.0, "sensors.imu.internal_rate_hz": 400.0,
        "sensors.imu.filter_order": 6, "sensors.imu.filter_cut_hz": 10.0,
        "sensors.imu.latency_s": 0.01, "sensors.imu.latency_jitter_s": 0.002,
        "sensors.imu.gyro_noise_radps_rthz": 0.001, "sensors.imu.accel_noise_mps2_rthz": 0.05,
        "sensors.imu.gyro_instability_radps": 0.01, "sensors.imu.accel_instability_mps2": 0.1,
        "sensors.imu.wander_tau_s": 1.0, "sensors.imu.gyro_bias_sd_radps": 0.01,
        "sensors.imu.accel_bias_sd_mps2": 0.5, "sensors.imu.scale_sd": 0.01,
        "sensors.imu.mounting_sd_rad": 0.05, "sensors.imu.gyro_range_radps": 2.0,
        "sensors.imu.accel_range_mps2": 20.0, "sensors.imu.vibration_rms_mps2": 2.0,
        "sensors.imu.firing_order": 2.0, "sensors.imu.gyro_bias_radps": (0.1, 0.0, 0.0),
        "sensors.imu.accel_bias_mps2": (0.1, 0.0, 0.0), "sensors.imu.scale_error": 0.01,
        "sensors.imu.mounting_error_rad": (0.1, 0.0, 0.0),
        "sensors.wheels.rate_hz": 25.0, "sensors.wheels.lines": 500, "sensors.wheels.decoding": 2,
        "sensors.wheels.latency_s": 0.02, "sensors.wheels.latency_jitter_s": 0.002,
        "sensors.wheels.read_jitter_s": 1e-3,
        "sensors.wheels.radius_error": (0.1, 0.0, 0.0, 0.0), "sensors.wheels.radius_error_sd": 0.05,
    },
    "stuck": {
        "sensors.gnss.rest_velocity_sd_mps": 0.01, "sensors.gnss.rest_velocity_tau_s": 5.0,
        "driver.shifts": True,
    },
    "failing": {
        "sensors.gnss.extrapolation_sd_mps": 0.5, "sensors.gnss.float_sd_m": 1.0,
        "sensors.gnss.float_tau_s": 5.0, "sensors.gnss.single_sd_m": 5.0,
        "sensors.gnss.single_tau_s": 5.0, "sensors.gnss.masked_velocity_factor": 6.0,
        "sensors.gnss.satellites_masked": 12.0, "sensors.gnss.outages.0.kind": "block",
        "sensors.gnss.outages.0.start_s": 0.0, "sensors.gnss.outages.0.duration_s": 0.15,
        "sensors.faults.0.kind": "gnss-spike", "sensors.faults.0.start_s": 0.4,
        "sensors.faults.0.duration_s": 0.5, "sensors.imu": Refused(None),
    },
    "looking": {
        "sensors.camera.rate_hz": 25.0, "sensors.camera.width_px": 192,
        "sensors.camera.height_px": 140, "sensors.camera.binning": 2,
        "sensors.camera.field_of_view_deg": 40.0, "sensors.camera.position_m": (1.0, 0.0, -0.33),
        "sensors.camera.height_m": 0.4, "sensors.camera.exposure_s": 0.01,
        "sensors.camera.gain": 0.5, "sensors.camera.full_well_e": 1000.0,
        "sensors.camera.read_noise_e": 100.0, "sensors.camera.vignetting": 0.0,
        "sensors.camera.latency_s": 0.05, "sensors.camera.latency_jitter_s": 0.01,
        "sensors.camera.loss_chance": 0.5, "sensors.camera.mount_yaw_sd_rad": 0.1,
        "sensors.camera.mount_tilt_sd_rad": 0.05, "sensors.camera.odometry": "orb-similarity",
        "sensors.camera.processing_s": 0.1,
    },
    "told": {
        "events.0.at_s": 0.4, "events.0.engine_rpm": 1800.0, "events.1.do": "brake",
        "events.1.pedal": 1.0, "events.1.for_s": 0.4, "events.2.engaged": True,
        "events.3.mass_kg": 50.0, "events.3.tank": "fuel", "events.3.rate_kgps": 50.0,
    },
    "shifting": {"events.0.gear": 11, "events.1.kmh": 8.0, "events.2.by": 2},
    "stopping": {
        "events.0.at_m": 1.3, "events.0.for_s": 0.7, "events.0.engine_off": True,
        "events.1.distance_m": 1.3, "events.3.when": "speed_kmh < 2", "events.3.times": 2,
        "driver.reaction_s": 0.2, "driver.pause_s": 1.0,
        "driver.headland_rpm": 1400.0, "driver.headland_kmh": 3.0,
        "driver.headland_rpm_sd": Refused(100.0),
    },
    "deeper": {"events.0.depth_m": 0.15},
    "turning": {
        "events.0.in_pass": 2, "course.headland": "backing", "course.backings": Refused(2),
        "course.road_m": 20.0, "driver.headland_rpm": 1400.0, "driver.headland_kmh": 3.0,
        "driver.headland_rpm_sd": Refused(100.0),
    },
    "backing": {"course.backings": 2, "driver.headland_rpm_sd": 100.0, "driver.pause_s": 1.0},
    "road": {"driver.road_rpm": 1500.0, "driver.road_kmh": 10.0},
    "signals": {
        "seed": 1, "track": "rough", "disturbance": "none", "disturbed": "truth",
        "noise": "proportional", "wheel_accel": False, "accel_bias_sd_mps2": 0.1,
    },
}  # fmt: skip
"""Witness -> another value of each field it is called for."""


def paths(kind, prefix=""):
    """Every field of a dataclass and of those within it; of a list its first element."""
    hints = typing.get_type_hints(kind)
    for field in dataclasses.fields(kind):
        path, hint = prefix + field.name, hints[field.name]
        inner = [h for h in (hint, *typing.get_args(hint)) if dataclasses.is_dataclass(h)]
        alone = bool(inner) and not isinstance(hint, types.UnionType) and path not in LISTS
        if not alone:
            yield path
        for each in inner:
            yield from paths(each, f"{path}.0." if path in LISTS else f"{path}.")


def bits(scenario):
    """Everything a run gives."""
    done = run(scenario, estimators={})
    tables = {"truth": done.truth, **done.streams.tables}
    return {
        f"{name}.{column}": np.asarray(values).tobytes()
        for name, table in tables.items()
        for column, values in table.items()
    }


@cache
def usual(base):
    return bits(BASES[base])


@pytest.fixture
def maps(tmp_path, monkeypatch):
    """The folder of the maps that some witnesses name."""
    monkeypatch.chdir(tmp_path)
    shares = np.linspace(0.0, 1.0, 60) * np.ones((40, 1))
    np.save("soils.npy", shares)
    np.save("heights.npy", 0.1 * shares**2)


def test_every_field_has_a_witness():
    kept = ("field.other_soil.numbers", "machine_numbers", "implement_numbers")
    fields = {p for p in paths(Scenario) if not p.startswith(kept)}
    named = {
        base: {re.sub(r"\.\d+\.", ".0.", p): not isinstance(v, Refused) for p, v in own.items()}
        for base, own in WITNESSES.items()
    }
    signals = named.pop("signals")
    turned = {path for own in named.values() for path, turns in own.items() if turns}
    refused = {path for own in named.values() for path, turns in own.items() if not turns}
    assert turned == fields - NOT_TURNED - OF_THE_FIELD
    assert refused >= OF_THE_FIELD
    assert signals.keys() == set(paths(Trial)) - NOT_TURNED


@pytest.mark.parametrize("base", WITNESSES)
def test_every_field_turns_something_or_is_refused_by_name(base, maps):
    idle = []
    for path, value in WITNESSES[base].items():
        if isinstance(value, Refused):
            with pytest.raises(BadInput, match=re.escape(path)):
                run(replaced(BASES[base], {path: value.value}), estimators={})
        elif bits(replaced(BASES[base], {path: value})) == usual(base):
            idle.append(path)
    assert not idle

"""What an observation holds: its entries in order, each within stated bounds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from gymnasium.spaces import Box

from twin.streams import WHEELS


@dataclass(frozen=True)
class Entry:
    """One number of an observation; the tables of the environment's docstring say what it means."""

    name: str
    low: float
    high: float


TASK = (
    Entry("throttle", -1.0, 1.0),
    Entry("lift_set_rad", -0.45, 1.0),
    Entry("slip_target", 0.0, 0.5),
    Entry("depth_target_m", 0.0, 0.35),
)
ESTIMATE = (
    Entry("slip", -1.0, 1.0),
    Entry("slip_sd", 0.0, 1.0),
    Entry("speed_mps", -5.0, 10.0),
    Entry("wheel_speed_mps", -5.0, 10.0),
    Entry("depth_m", -1.0, 1.0),
    Entry("engine_radps", 0.0, 400.0),
    Entry("engine_load", 0.0, 1.25),
    Entry("draft_pin_n", -2e5, 2e5),
    Entry("hitch_m", -1.0, 1.0),
)
SENSORS = (
    *(Entry(f"gnss.v_{axis}_mps", -10.0, 10.0) for axis in ("east", "north", "up")),
    Entry("gnss.heading_rad", -4.0, 7.0),
    Entry("gnss.age_s", 0.0, 10.0),
    *(Entry(f"imu.gyro_{axis}_radps", -5.0, 5.0) for axis in "xyz"),
    *(Entry(f"imu.accel_{axis}_mps2", -100.0, 100.0) for axis in "xyz"),
    *(Entry(f"wheels.ticks_{wheel}", -2000.0, 2000.0) for wheel in WHEELS),
    Entry("depth.laser_m", -2.0, 4.0),
    Entry("depth.inclination_rad", -1.6, 1.6),
    Entry("machine.steer_rad", -1.0, 1.0),
    Entry("machine.hitch_m", -1.0, 1.0),
    Entry("machine.draft_pin_n", -2e5, 2e5),
    Entry("machine.axle_torque_nm", -2e5, 2e5),
    Entry("machine.engine_radps", 0.0, 400.0),
    Entry("machine.engine_load", 0.0, 1.25),
    Entry("machine.fuel_lph", 0.0, 100.0),
)
TRUTH = (
    Entry("slip", -1.0, 1.0),
    *(Entry(f"slip_{wheel}", -1.0, 1.0) for wheel in WHEELS),
    Entry("speed_mps", -5.0, 10.0),
    Entry("v_y_rear_mps", -5.0, 5.0),
    Entry("wheel_speed_mps", -5.0, 10.0),
    Entry("depth_m", 0.0, 1.0),
    Entry("draft_n", -2e5, 2e5),
    Entry("axle_torque_nm", -2e5, 2e5),
    Entry("engine_radps", -100.0, 400.0),
    Entry("engine_torque_nm", -500.0, 1000.0),
    *(Entry(f"load_{wheel}_n", 0.0, 2e5) for wheel in WHEELS),
)
FIELD_TASK = (
    Entry("throttle", -1.0, 1.0),
    Entry("gear_kmh", 0.0, 30.0),
    Entry("lift_set_rad", -0.45, 1.0),
    Entry("mix", 0.0, 1.0),
    Entry("depth_target_m", 0.0, 0.35),
)
FIELD_MODES = {
    "estimate": (*ESTIMATE, *FIELD_TASK),
    "sensors": (*SENSORS, *FIELD_TASK),
    "truth": (*TRUTH, *FIELD_TASK),
}
"""The same with a gear, and a hitch between position and draft."""
TORQUE_TASK = (
    Entry("torque_left", -1.0, 1.0),
    Entry("torque_right", -1.0, 1.0),
    Entry("slip_target", 0.0, 0.5),
)
TORQUE_ESTIMATE = (
    *ESTIMATE[:2],
    Entry("slip_rl", -1.0, 1.0),
    Entry("slip_rr", -1.0, 1.0),
    *ESTIMATE[2:4],
    Entry("sideslip_rear_rad", -1.6, 1.6),
    Entry("imu.gyro_z_radps", -5.0, 5.0),
)
TORQUE_SENSORS = tuple(e for e in SENSORS if not e.name.startswith(("depth.", "machine.")))
TORQUE_TRUTH = (
    *TRUTH[:8],
    Entry("draft_n", -2e5, 2e5),
    Entry("axle_torque_nm", -2e5, 2e5),
    *TRUTH[-4:],
)
TRACTION_TASK = (
    *TORQUE_TASK[:2],
    Entry("line_left_m", -10.0, 10.0),
    Entry("line_heading_rad", -3.2, 3.2),
)
TRACTION_MODES = {
    "estimate": (*TORQUE_ESTIMATE, *TRACTION_TASK),
    "sensors": (*TORQUE_SENSORS, *TRACTION_TASK),
    "truth": (*TORQUE_TRUTH, *TRACTION_TASK),
}
"""The same with a line to hold."""
MODES = {"estimate": (*ESTIMATE, *TASK), "sensors": (*SENSORS, *TASK), "truth": (*TRUTH, *TASK)}
"""Entries of an observation by the constructor's `observation`, ploughing."""
TORQUE_MODES = {
    "estimate": (*TORQUE_ESTIMATE, *TORQUE_TASK),
    "sensors": (*TORQUE_SENSORS, *TORQUE_TASK),
    "truth": (*TORQUE_TRUTH, *TORQUE_TASK),
}
"""The same with a torque on each rear wheel."""


def space(entries: tuple[Entry, ...]) -> Box[np.float32]:
    """The box of the entries' bounds."""
    bounds = np.array([(e.low, e.high) for e in entries], dtype=np.float32)
    return Box(bounds[:, 0], bounds[:, 1], dtype=np.float32)

"""From what MuJoCo recorded to named columns, all at one epoch.

Recorded sensordata and userdata belong to the state before their step; so do all columns made here,
and nothing is taken from the state after it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from twin.compute import quaternion
from twin.machine.build import Machine
from twin.machine.fuel import fuel_lph
from twin.machine.zero_slip import radius_factors
from twin.physics import block
from twin.physics.block import MachineSlot, PowerSlot, WheelSlot
from twin.trajectory.end import End
from twin.trajectory.trajectory import Trajectory
from twin.truth.motion import slip_ratio

Array = NDArray[np.float64]
Record: TypeAlias = dict[str, Array]
"""What a Batch recorded after each step, by name. Shapes (nsim, steps, ...)."""

WHEEL_COLUMNS = {
    "rolling_radius_m": WheelSlot.ROLLING_RADIUS_M,
    "slip": WheelSlot.SLIP,
    "tread_speed_y_mps": WheelSlot.TREAD_SPEED_Y_MPS,
    "load_n": WheelSlot.LOAD_N,
    "shear_x_n": WheelSlot.SHEAR_X_N,
    "shear_y_n": WheelSlot.SHEAR_Y_N,
    "resistance_n": WheelSlot.RESISTANCE_N,
    "wheel_speed_x_mps": WheelSlot.SPEED_X_MPS,
    "wheel_speed_y_mps": WheelSlot.SPEED_Y_MPS,
    "spin_radps": WheelSlot.RATE_RADPS,
    "wall_n": WheelSlot.WALL_N,
}
MACHINE_COLUMNS = {
    "engine_radps": MachineSlot.ENGINE_RADPS,
    "engine_torque_nm": MachineSlot.ENGINE_TORQUE_NM,
    "axle_torque_nm": MachineSlot.AXLE_TORQUE_NM,
    "draft_n": MachineSlot.DRAFT_N,
    "depth_m": MachineSlot.DEPTH_M,
    "depth_wheel_n": MachineSlot.DEPTH_WHEEL_N,
    "plough_side_n": MachineSlot.SIDE_N,
    "landside_n": MachineSlot.LANDSIDE_N,
}
POWER_COLUMNS = {
    f"power_{slot.name.lower()}_w": slot for slot in PowerSlot if slot is not PowerSlot.SIZE
}
SENSOR_COLUMNS = (
    "potential_j", "kinetic_j",
    "position_w", "world_from_body", "velocity_w", "gyro_b", "imu_accel_b", "cg_velocity_w",
    "antenna_main_w", "antenna_main_velocity_w", "antenna_aux_w",
    "fl_steer_rad", "fr_steer_rad", "front_swing_rad",
)  # fmt: skip


CLOSING = (
    "qvel", "qfrc_passive", "qfrc_actuator", "qfrc_constraint", "qfrc_bias", "qfrc_spring",
)  # fmt: skip
"""What closes the power balance: generalised speeds and forces."""
RECORDED = ("sensordata", "userdata", *CLOSING)
"""What a run records of every step."""
DECIDED = ("phase", "gear_ratio", "power_mass_w")
"""What a driver of a course adds to it."""


class Recorder:
    """Turns records into trajectories, counting the steps so that epochs are exact."""

    def __init__(self, machine: Machine) -> None:
        model = machine.model
        self.steps = 0
        self.velocity: Array | None = None  # generalised, before the next step
        self.step_ns = round(model.opt.timestep * 1e9)
        self.world_from_ground = machine.world_from_ground
        self.normal, self.heights = machine.world_from_ground[:, 2], machine.maps.get("heights")
        self.plough = machine.scenario.plough is not None
        self.numbers = machine.numbers
        self.own_zero = machine.scenario.zero_slip == "law"
        self.factors = radius_factors(machine.scenario, model.numeric_data[-block.SIZE :])
        self.sensors = {
            model.sensor(i).name: slice(adr, adr + dim)
            for i, (adr, dim) in enumerate(
                zip(model.sensor_adr.tolist(), model.sensor_dim.tolist(), strict=True)
            )
        }

        self.angles, self.rates = (
            [self.sensors[f"{wheel}_{what}"].start for wheel in block.WHEELS]
            for what in ("angle_rad", "rate_radps")
        )

    @property
    def time_s(self) -> float:
        """Simulated time recorded so far."""
        return self.steps * self.step_ns * 1e-9

    def sensed(self, record: Record) -> Trajectory:
        """One record of (1, steps, ...) with the columns alone that sensors read."""
        sensordata, slots = record["sensordata"][0], record["userdata"][0]
        n = len(slots)
        epoch_ns = (self.steps + np.arange(n, dtype=np.int64)) * self.step_ns
        self.steps += n
        return Trajectory(epoch_ns, self._sensed(sensordata, slots))

    def trajectory(self, records: Sequence[Record], end: End | None = None) -> Trajectory:
        """One trajectory from consecutive records of (1, steps, ...) each; the last has an end."""
        sensordata = np.concatenate([r["sensordata"][0] for r in records])  # (n, nsensordata)
        slots = np.concatenate([r["userdata"][0] for r in records])  # (n, nuserdata)
        n = len(slots)
        epoch_ns = (self.steps + np.arange(n, dtype=np.int64)) * self.step_ns
        self.steps += n
        columns = self._columns(sensordata, slots)
        if "qvel" in records[0]:
            columns |= self._closing(
                {k: np.concatenate([r[k][0] for r in records]) for k in CLOSING}, records
            )
        for name in DECIDED:
            if name in records[0]:
                columns[name] = np.concatenate([r[name][0] for r in records])
        return Trajectory(epoch_ns, columns, end)

    def _closing(self, record: dict[str, Array], records: Sequence[Record]) -> dict[str, Array]:
        """What the power balance needs beside the laws' own terms.

            contact = -F_c . (v + v') / 2        step = (F_g - F) . (v' - v) / 2

        with v before and v' after the step. F_c holds joints within their limits and the hull and
        the plough's frame off the ground. Powers are force times speed at the start of a step; the
        step does F . (v + v') / 2 dt on the masses, and moves what has a potential (weight,
        springs, F_g) by v' dt: `step` is the difference, of the first order in the time step.
        """
        after = record["qvel"]
        first = after[:1] if self.velocity is None else self.velocity
        before = np.concatenate([first, after[:-1]])
        if "entry" in records[0]:  # where a gear went in, the shaft's speed has jumped
            starts = np.cumsum([0, *(len(r["userdata"][0]) for r in records[:-1])])
            before[starts] = np.concatenate([r["entry"][0] for r in records])
        self.velocity = after[-1:].copy()
        change = after - before
        stored = record["qfrc_spring"] - record["qfrc_bias"]
        lossy = record["qfrc_passive"] - record["qfrc_spring"] + record["qfrc_actuator"]
        contact = record["qfrc_constraint"]
        return {
            "power_contact_w": -np.sum(contact * (before + 0.5 * change), axis=1),
            "power_step_w": 0.5 * np.sum((stored - lossy) * change, axis=1),
        }

    def _sensed(self, sensordata: Array, slots: Array) -> dict[str, Array]:
        """What sensors read."""

        def sensor(name: str) -> Array:
            values = sensordata[:, self.sensors[name]]
            return values[:, 0] if values.shape[1] == 1 else values

        columns = {name: sensor(name) for name in SENSOR_COLUMNS}
        columns["wheel_angle_rad"] = sensordata[:, self.angles]
        columns["wheel_rate_radps"] = sensordata[:, self.rates]
        columns["steer_rad"] = 0.5 * (columns["fl_steer_rad"] + columns["fr_steer_rad"])
        machine = slots[:, block.MACHINE_SLOTS :]
        columns |= {name: machine[:, slot] for name, slot in MACHINE_COLUMNS.items()}
        engine_radps = columns["engine_radps"]
        crank_w = columns["engine_torque_nm"] * engine_radps
        columns["fuel_lph"] = fuel_lph(self.numbers, crank_w, engine_radps)
        linkage = "hitch_rad" in self.sensors
        columns["hitch_rad"] = sensor("hitch_rad") if linkage else np.zeros(len(slots))
        columns["ground_normal_w"] = np.broadcast_to(self.normal, (len(slots), 3))
        return columns | self._laser(sensor, len(slots))

    def _columns(self, sensordata: Array, slots: Array) -> dict[str, Array]:
        """What sensors read, and what is true beside it."""

        def sensor(name: str) -> Array:
            return sensordata[:, self.sensors[name]][:, 0]

        columns = self._sensed(sensordata, slots)
        wheels = slots[:, : block.MACHINE_SLOTS].reshape(len(slots), 4, int(WheelSlot.SIZE))
        machine, powers = slots[:, block.MACHINE_SLOTS :], slots[:, block.POWER_SLOTS :]
        columns |= {name: wheels[:, :, slot] for name, slot in WHEEL_COLUMNS.items()}
        if not self.own_zero:
            columns |= self._by_zero(columns)
        columns |= {name: powers[:, slot] for name, slot in POWER_COLUMNS.items()}
        columns["slip_angle_rad"] = np.arctan2(
            -columns["tread_speed_y_mps"], np.abs(columns["wheel_speed_x_mps"])
        )
        linkage, none = "hitch_rad" in self.sensors, np.zeros(len(slots))
        columns["power_lift_w"] = -sensor("lift_nm") * sensor("lift_radps") if linkage else none
        columns["power_steer_w"] = -(
            sensor("steer_left_nm") * sensor("fl_steer_radps")
            + sensor("steer_right_nm") * sensor("fr_steer_radps")
        )
        columns["draft_w"] = machine[:, MachineSlot.DRAFT_X_N : MachineSlot.DRAFT_Z_N + 1]
        return columns

    def _by_zero(self, columns: dict[str, Array]) -> dict[str, Array]:
        """Rolling radius and slip by the scenario's zero: `twin.machine.zero_slip`."""
        radius_m = columns["rolling_radius_m"] * self.factors
        rim_mps = columns["spin_radps"] * radius_m
        slip = slip_ratio(rim_mps, columns["wheel_speed_x_mps"])
        return {"rolling_radius_m": radius_m, "slip": slip}

    def _height_m(self, place_w: Array) -> Array:
        """Height of the ground's map at places. Shape (n, 3) -> (n,)."""
        if self.heights is None:
            return np.zeros(len(place_w))
        place = place_w @ self.world_from_ground
        return self.heights.at(place[:, 0], place[:, 1])

    def _laser(self, sensor: Callable[[str], Array], n: int) -> dict[str, Array]:
        """True range of the depth laser to the ground below it, and inclination of its frame.

        None without a plough.
        """
        if not self.plough:
            names = ("laser_m", "inclination_rad", "plough_pitch_rad")
            return {name: np.full(n, np.nan) for name in names}
        attitude = sensor("plough.world_from_laser").T
        down = -np.stack(quaternion.z_axis(*attitude), axis=1)
        _, _, ahead_up = quaternion.x_axis(*attitude)
        laser_w = sensor("plough.laser_w")
        above_m = laser_w @ self.normal - self._height_m(laser_w)
        return {
            "laser_m": -above_m / (down @ self.normal),
            "inclination_rad": np.arcsin(np.clip(ahead_up, -1.0, 1.0)),
            "plough_pitch_rad": sensor("plough.pitch_rad"),
        }

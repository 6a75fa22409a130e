"""The recording protocol driven by the simulated tractor, clutch, brakes and all, as a log."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from twin.logs import Log
from twin.physics.block import MACHINE_SLOTS, MachineSlot
from twin.rig.tractor import tractor
from twin.scenario import Drive, Soil
from twin.streams import Setup, Streams
from twin.validate.by_hand import hold, rolling

STEP_S = 0.02
NOMINAL_RADIUS_M = 0.85
"""What the log's maker took for the radius of the rear wheels."""
BIAS_RADPS = 0.003
TOW_N_PER_MPS = 8000.0
AWAY_RAD = 0.98 * np.pi
EASE_S = 4.0
"""The clutch is let in over so long [s]."""
SOIL = Soil(cone_index_kpa=2000.0)


@dataclass
class Recorder:
    """Drives phase by phase and keeps what instruments would see, 50 times a second."""

    heading_rad: float = 0.0

    def __post_init__(self) -> None:
        self.machine = tractor("protocol", SOIL, gear=Drive(gear_ratio=30.0))
        self.state = rolling(self.machine)
        self.rows: list[tuple[float, ...]] = []
        self.phases: dict[str, list[tuple[float, float]]] = {}
        self.steps = round(STEP_S / self.machine.model.opt.timestep)

    def drive(self, name: str, seconds: float, *, tow_mps: float = 0.0, **controls: float) -> None:
        """Hold controls for a time, and the heading; a clutch that is let in is let in slowly."""
        state, start_s = self.state, float(self.state.time)
        pedal = self.machine.model.actuator("clutch_pedal").id
        before, root = float(state.ctrl[pedal]), self.machine.model.body("tractor").id
        for i in range(round(seconds / STEP_S)):
            eased = max(controls["clutch_pedal"], before - i * STEP_S / EASE_S)
            off = np.remainder(self.heading_rad - self.yaw_rad + np.pi, 2 * np.pi) - np.pi
            steer = float(np.clip(1.5 * off, -0.5, 0.5))
            steering = {"steer_left": steer, "steer_right": steer}
            hold(self.machine, state, **{**controls, **steering, "clutch_pedal": eased})
            pull_n = TOW_N_PER_MPS * (tow_mps - self.speed_mps) if tow_mps else 0.0
            state.xfrc_applied[root, :2] = pull_n * np.array(
                [np.cos(self.yaw_rad), np.sin(self.yaw_rad)]
            )
            mujoco.mj_step(self.machine.model, state, self.steps)
            rates = [float(state.joint(f"{w}_spin").qvel[0]) for w in ("rl", "rr")]
            engine = float(state.userdata[MACHINE_SLOTS + MachineSlot.ENGINE_RADPS])
            self.rows.append(
                (state.time, *state.qpos[:2], *state.qvel[:2], *rates, state.qvel[5], engine)
            )
        self.phases.setdefault(name, []).append((start_s, float(state.time)))

    @property
    def yaw_rad(self) -> float:
        w, _, _, z = self.state.qpos[3:7]
        return float(2.0 * np.arctan2(z, w))

    @property
    def speed_mps(self) -> float:
        return float(np.hypot(*self.state.qvel[:2]))


def machine_drive(seed: int = 1, *, brake: float = 0.15) -> tuple[Log, Recorder]:
    """The log, and who drove it."""
    r = Recorder()
    rest = {"brake": brake, "clutch_pedal": 1.0, "throttle": 0.0}
    go = {"brake": 0.0, "clutch_pedal": 0.0}
    r.drive("stop", 4.0, **rest)
    r.drive("stand", 40.0, **rest)
    for _ in range(3):
        r.drive("go", 7.0, throttle=0.3, **go)
        r.drive("stop", 8.0, **rest)
    for turned in (AWAY_RAD, 0.0):
        r.drive("go", 6.0, throttle=0.2, **go)
        r.drive("pass", 30.0, throttle=0.2, **go)
        r.heading_rad = turned
        r.drive("turn", 12.0, throttle=0.15, **go)
    for turned in (AWAY_RAD, 0.0):
        r.drive("go", 16.0, throttle=0.9, **go)
        r.drive("coast", 8.0, brake=0.0, clutch_pedal=1.0, throttle=0.0)
        r.drive("stop", 8.0, **rest)
        r.heading_rad = turned
        r.drive("turn", 16.0, throttle=0.2, **go)
    r.drive("stop", 6.0, **rest)
    r.drive("towed", 40.0, tow_mps=2.0, brake=0.0, clutch_pedal=1.0, throttle=0.0)
    r.drive("stop", 6.0, **rest)
    r.drive("stand", 40.0, **rest)
    return _log(np.array(r.rows), seed), r


def _log(rows: np.ndarray, seed: int) -> Log:
    rng = np.random.default_rng(seed)
    time_s, east, north, v_east, v_north, rl, rr, yaw_rate, engine = rows.T
    epoch_ns = (time_s * 1e9).round().astype(np.int64)
    stamps = {"epoch_ns": epoch_ns, "arrival_ns": epoch_ns}
    slow = slice(None, None, 5)
    noise = 0.01 * rng.standard_normal((2, len(east[slow])))
    gnss = {
        "epoch_ns": epoch_ns[slow], "arrival_ns": epoch_ns[slow], "east_m": east[slow],
        "north_m": north[slow], "v_east_mps": v_east[slow] + noise[0],
        "v_north_mps": v_north[slow] + noise[1],
    }  # fmt: skip
    wheels = {f"speed_{w}_mps": NOMINAL_RADIUS_M * v for w, v in (("rl", rl), ("rr", rr))}
    gyro = yaw_rate + BIAS_RADPS + 1e-3 * rng.standard_normal(len(yaw_rate))
    tables = {
        "gnss": gnss, "wheels": {**stamps, **wheels}, "imu": {**stamps, "gyro_z_radps": gyro},
        "machine": {**stamps, "engine_radps": engine},
    }  # fmt: skip
    setup = Setup(
        machine="taishan_1404a", wheelbase_m=2.5, track_front_m=1.6, track_rear_m=1.6, cg_x_m=1.0
    )
    return Log(streams=Streams(tables), setup=setup)

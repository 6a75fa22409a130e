"""Samples wait a little and are taken in order of epoch; what is told is brought up to now.

One module, because predict and correct change one record in place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from estimators.estimate import SLOW_MPS
from estimators.four_state import FourState
from estimators.layout import STALE_S
from estimators.sideslip_ekf import model, tilt
from estimators.sideslip_ekf.model import (
    FREE_RAD2,
    GYRO_BIAS,
    HEADING,
    SLIDE,
    SLIDE_REAR,
    V_X,
    V_Y,
    Array,
    Nominal,
    Tuning,
)
from estimators.sideslip_ekf.tilt import Tilt
from twin.streams import COLUMNS, WHEELS, Setup, Streams, Table

LAG_NS = 120_000_000
"""A sample waits until another is so much newer, so that late ones find their place."""
STALE_NS = round(STALE_S * 1e9)
SEEN_NS = 500_000_000
"""The forward speed is the camera's for so long after a frame."""
USUAL_S = 1.0 / 30.0
"""Between two frames, where a stream does not tell [s]."""
SAME_S = 0.001
"""Instants as near as this are one."""
SLOW_S = 2.0
STRAIGHT_RADPS = 0.03
"""Turning slower than this is straight on."""
DRIVING_MPS = 0.3
READ = {
    "gnss": ("v_east_mps", "v_north_mps", "heading_rad", "quality", "velocity_sd_mps",
             "heading_sd_rad"),
    "imu": ("gyro_x_radps", "gyro_y_radps", "gyro_z_radps", "accel_x_mps2", "accel_y_mps2"),
    "wheels": (*(f"ticks_{w}" for w in WHEELS), *(f"speed_{w}_mps" for w in WHEELS),
               "speed_sd_mps"),
    "camera": ("v_x_mps", "v_y_mps", "var_x_m2ps2", "var_y_m2ps2", "cov_xy_m2ps2", "interval_s",
               "used"),
}  # fmt: skip
LATERAL = ("v_y_mps", "sideslip_rad", "sideslip_sd_rad", "sideslip_m", "sideslip_sd_m",
           "sideslip_rear_rad", "sideslip_rear_m")  # fmt: skip

Sample = tuple[int, str, tuple[float, ...]]
"""Epoch, sensor, values as in READ; for "towed" a speed and its sd. A camera's sample is two:
"camera" at the middle of its interval is the forward speed and its variance, "frame" at its end
both speeds, the variance and the interval."""


@dataclass
class State:
    """What is carried from chunk to chunk; only `Work` changes one, and that a copy of its own."""

    slip: Any
    """State of the filter that tells slip."""
    nominal: Nominal
    towed: tuple[int, ...]
    """Numbers of the wheels that are not driven."""
    tick_m: tuple[float, ...]
    """Path per tick of each wheel, NaN without ticks."""
    x: Array
    """Mean (13,), in the order of `model.V_X` to `model.ASIDE`, as is the covariance."""
    p: Array
    lateral_psd: float
    """Of the lateral speed's walk [m2/s3]."""
    epoch_ns: int = -1
    """Of the filter."""
    newest_ns: int = -1
    lateral_ns: int = -1
    """When a lateral speed was last measured."""
    camera_ns: int = -1
    """When the camera last measured one."""
    frame_ns: int = -1
    """Of its last frame, up to which the path aside is known."""
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """The last turn rates."""
    slow: tuple[float, float] = (0.0, 0.0)
    """Mean rates of roll and pitch over SLOW_S: no chassis goes on rolling, so they are bias."""
    spun_s: float = 0.0
    """Time that is in them."""
    spin_ns: int = -1
    tilt: Tilt = field(default_factory=Tilt)
    last_ns: tuple[tuple[str, int], ...] = ()
    """Newest epoch of each sensor."""
    ticks: tuple[float, ...] = (math.nan,) * 4
    tick_ns: int = -1
    waiting: tuple[Sample, ...] = ()


@dataclass(frozen=True, kw_only=True)
class SideslipEkf:
    """Extended Kalman filter of camera, GNSS, gyro and wheels for sideslip, with mounting errors.

        x = [v_x, v_y of the camera, heading, gyro bias, heading bias, camera yaw, camera scale,
             wheel scale, slide of the centre of gravity, slide of the rear axle,
             pull of the pixels, gyro scale, path to the left since the last frame]

    The slides are the sideslip amounts, integrals of lateral speed, so that their sd knows of the
    biases they share. Camera yaw and heading bias are found where the machine drives straight on
    over level ground, which the accelerometer tells: there the rear axle does not slide. Through a
    masking the camera and the gyro go on alone.

    Speed along the ground and slip are the filter's own where the camera tells them, with the
    wheels' nominal radius; else, as all of the wheels, they are `four-state`'s.
    """

    tuning: Tuning = field(default_factory=Tuning)

    def init(self, setup: Setup) -> State:
        """The state before the first sample."""
        nominal = Nominal.of(setup)
        wheels = setup.wheels
        per_turn = wheels.counts_per_turn if wheels and wheels.counts_per_turn else math.nan
        radius = wheels.radius_m if wheels else {}
        x, p = model.begin(nominal, self.tuning)
        return State(
            slip=FourState().init(setup),
            nominal=nominal,
            towed=tuple(i for i, w in enumerate(WHEELS) if w not in setup.driven),
            tick_m=tuple(2.0 * math.pi * radius.get(w, math.nan) / per_turn for w in WHEELS),
            x=x,
            p=p,
            lateral_psd=self.tuning.accel_y_psd,
        )

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The state after the chunk, and a table with one row per accepted wheel sample.

        A wheel sample that is not newer than the last one, or over 5 s older than the newest sample
        of any sensor, gives no row.
        """
        slip, table = FourState().run(state.slip, chunk)
        work = Work(replace(state, slip=slip), self.tuning)
        columns = {
            s: np.column_stack([chunk.column(s, n).astype(float) for n in names])
            for s, names in READ.items()
            if s in chunk
        }
        names = tuple(COLUMNS)
        told = []
        for sensor, row in zip(*chunk.merge_order(), strict=True):
            name = names[sensor]
            if name in columns:
                epoch_ns = int(chunk[name]["epoch_ns"][row])
                if work.arrived(epoch_ns, name, columns[name][row]) and name == "wheels":
                    told.append(work.told())
        lateral = np.array(told).reshape(-1, len(LATERAL) + 2)
        table |= {n: lateral[:, i].copy() for i, n in enumerate(LATERAL)}
        return work.state, self._with_slip(table, lateral[:, -2], lateral[:, -1])

    def _with_slip(self, table: Table, speed_mps: Array, speed_sd_mps: Array) -> Table:
        """The table with the filter's own speed, and slip from it, where that is known.

        s = (w - v) / m,  m = max(|w|, |v|, 0.05 m/s);  the radius's error is that of two wheels
        """
        known = np.isfinite(speed_mps) & np.isfinite(table["wheel_speed_mps"])
        wheel = table["wheel_speed_mps"]
        size = np.fmax(np.fmax(np.abs(wheel), np.abs(speed_mps)), SLOW_MPS)
        sd = np.hypot(speed_sd_mps, self.tuning.wheel_scale_sd / math.sqrt(2.0) * wheel) / size
        own = {"speed_mps": speed_mps, "slip": (wheel - speed_mps) / size, "slip_sd": sd}
        return table | {n: np.where(known, column, table[n]) for n, column in own.items()}


class Work:
    """A state while a chunk is taken in; the one it began with is left as it was."""

    def __init__(self, state: State, tuning: Tuning) -> None:
        self.state = replace(state, x=state.x.copy(), p=state.p.copy())
        self.tuning = tuning

    def arrived(self, epoch_ns: int, sensor: str, values: Array) -> bool:
        """Take in a sample that has arrived; whether it is newer than its sensor's last."""
        state = self.state
        last = dict(state.last_ns)
        if epoch_ns <= last.get(sensor, -1):
            return False
        newest = max(state.newest_ns, epoch_ns)
        if sensor == "camera" and values[-1] != 1.0:
            return False  # its epoch may be that of the next one
        last[sensor] = epoch_ns
        state.last_ns, state.newest_ns = tuple(last.items()), newest
        if newest - epoch_ns > STALE_NS:
            return False
        self._wait(epoch_ns, sensor, values)
        self._take_due()
        return True

    def _wait(self, epoch_ns: int, sensor: str, values: Array) -> None:
        sample: Sample = (epoch_ns, sensor, tuple(values.tolist()))
        if sensor == "wheels":
            found = self._towed(epoch_ns, values)
            if found is None:
                return
            sample = found
        more = _camera(epoch_ns, values) if sensor == "camera" else (sample,)
        self.state.waiting = tuple(sorted((*self.state.waiting, *more), key=lambda s: s[:2]))

    def _towed(self, epoch_ns: int, values: Array) -> Sample | None:
        """Mean speed of the towed wheels over the interval of two readings, at its middle."""
        state = self.state
        ticks, dt = tuple(values[:4].tolist()), (epoch_ns - state.tick_ns) * 1e-9
        steps = [(ticks[i] - state.ticks[i]) * state.tick_m[i] for i in state.towed]
        middle_ns = epoch_ns - (epoch_ns - state.tick_ns) // 2
        state.ticks, state.tick_ns = ticks, epoch_ns
        if steps and dt < STALE_S and all(map(math.isfinite, steps)):
            sd = state.tick_m[state.towed[0]] / dt / math.sqrt(6.0 * len(steps))
            return middle_ns, "towed", (sum(steps) / len(steps) / dt, sd)
        speeds = [float(values[4 + i]) for i in state.towed]
        if speeds and all(map(math.isfinite, speeds)):
            sd = float(values[8])
            return epoch_ns, "towed", (sum(speeds) / len(speeds), sd if sd > 0.0 else 0.05)
        return None

    def _take_due(self) -> None:
        due_ns = self.state.newest_ns - LAG_NS
        while self.state.waiting and self.state.waiting[0][0] <= due_ns:
            first, *rest = self.state.waiting
            self.state.waiting = tuple(rest)
            self._take(*first)

    def _take(self, epoch_ns: int, sensor: str, values: tuple[float, ...]) -> None:
        if sensor == "imu":
            self._turn(epoch_ns, values)
        spin = self._spin_at(epoch_ns)
        self._carry(epoch_ns, spin[2])
        if sensor == "imu":
            self._level()
        elif sensor == "camera":
            x, p, own = self.state.x, self.state.p, self.state.nominal
            model.take_ahead(x, p, values[0], values[1], spin[2], own, self.tuning)
        elif sensor == "frame":
            self._frame(values)
        elif sensor == "gnss":
            self._gnss(values, np.array(spin))
        elif sensor == "towed" and abs(spin[2]) < STRAIGHT_RADPS:
            model.take_wheels(self.state.x, self.state.p, values[0], values[1], self.tuning)

    def _carry(self, epoch_ns: int, rate: float) -> None:
        """Predict to an epoch; after a gap start again, with the biases that are known."""
        state = self.state
        dt = (epoch_ns - state.epoch_ns) * 1e-9
        if state.epoch_ns >= 0 and dt > STALE_S:
            model.forget(state.x, state.p, self.tuning)
            state.lateral_psd, state.frame_ns = self.tuning.accel_y_psd, -1
            state.tilt = tilt.forget(state.tilt)
        elif state.epoch_ns >= 0 and dt > 0.0:
            psd = state.lateral_psd
            model.predict(state.x, state.p, dt, rate, psd, state.nominal, self.tuning)
        state.epoch_ns = max(epoch_ns, state.epoch_ns)

    def _turn(self, epoch_ns: int, values: tuple[float, ...]) -> None:
        """Remember the turn rates; feel the vertical."""
        state = self.state
        p, q, r = (v if math.isfinite(v) else s for v, s in zip(values, state.spin, strict=False))
        dt = min((epoch_ns - state.spin_ns) * 1e-9, 0.1) if state.spin_ns >= 0 else 0.02
        rate = model.turning(state.x, r)
        ahead = values[3] + rate * model.rear_mps(state.x, r, state.nominal)
        left = values[4] - rate * state.x[V_X]
        own = state.tilt
        if state.spin_ns >= 0 and epoch_ns - state.spin_ns > STALE_NS:
            own = tilt.forget(own)
        state.tilt = tilt.felt(own, ahead, left, float(state.x[HEADING]), dt)
        gain = dt / min(state.spun_s + dt, SLOW_S)
        roll, pitch = state.slow
        state.slow = roll + gain * (p - roll), pitch + gain * (q - pitch)
        state.spun_s += dt
        state.spin, state.spin_ns = (p, q, r), epoch_ns

    def _spin_at(self, epoch_ns: int) -> tuple[float, ...]:
        """Turn rates at an epoch: linear between IMU samples, held where there is no next one."""
        state = self.state
        for next_ns, sensor, values in state.waiting:
            if sensor == "imu" and all(map(math.isfinite, values[:3])) and state.spin_ns >= 0:
                share = (epoch_ns - state.spin_ns) / max(next_ns - state.spin_ns, 1)
                return tuple(a + share * (b - a) for a, b in zip(state.spin, values, strict=False))
        return state.spin

    def _level(self) -> None:
        state = self.state
        rate = model.turning(state.x, state.spin[2])
        driving = abs(state.x[V_X]) > DRIVING_MPS and state.p[V_X, V_X] < 1.0
        if state.tilt.level and driving and abs(rate) < STRAIGHT_RADPS:
            model.take_level(state.x, state.p, state.spin[2], state.nominal, self.tuning)

    def _frame(self, values: tuple[float, ...]) -> None:
        state, (ahead, left, variance, interval_s) = self.state, values
        known_s = (state.epoch_ns - state.frame_ns) * 1e-9 if state.frame_ns >= 0 else math.inf
        follows = abs(known_s - interval_s) < SAME_S
        state.frame_ns = state.epoch_ns
        frame = model.Frame(ahead, left, variance, interval_s, follows)
        taken, state.lateral_psd = model.take_aside(
            state.x, state.p, frame, state.lateral_psd, self.tuning
        )
        if taken:
            state.lateral_ns = state.camera_ns = state.epoch_ns

    def _gnss(self, values: tuple[float, ...], spin: Array) -> None:
        east, north, azimuth, quality, velocity_sd, heading_sd = values
        state, nominal = self.state, self.state.nominal
        spin[:2] -= state.slow  # 1e-3 rad/s under an antenna 0.7 m up are 0.07 % of 1 m/s
        spin[2] = model.turning(state.x, spin[2])
        rotation = state.tilt.rotation
        if math.isfinite(azimuth):
            sd = heading_sd if heading_sd > 0.0 else nominal.heading_sd_rad
            model.take_heading(state.x, state.p, azimuth, sd, rotation, nominal)
        known = state.p[HEADING, HEADING] < 0.1 * FREE_RAD2
        if quality != 0.0 and math.isfinite(east + north) and known:
            sd = velocity_sd if velocity_sd > 0.0 else nominal.velocity_sd_mps
            flat = np.array([east, north])
            if model.take_velocity(state.x, state.p, flat, sd, rotation, spin, nominal):
                state.lateral_ns = state.epoch_ns

    def told(self) -> tuple[float, ...]:
        """LATERAL at the newest epoch: the filter's own, brought up at its lateral speed.

        Then the forward speed and its sd, NaN where no frame told it lately.
        """
        state = self.state
        x, p, nominal = state.x, state.p, state.nominal
        if state.lateral_ns < 0:
            return (math.nan,) * (len(LATERAL) + 2)
        ahead_s = max((state.newest_ns - state.epoch_ns) * 1e-9, 0.0)
        if ahead_s > STALE_S:  # after a gap nothing is known of the speeds yet
            sd = math.sqrt(p[SLIDE, SLIDE])
            nan = math.nan
            return nan, nan, nan, float(x[SLIDE]), sd, nan, float(x[SLIDE_REAR]), nan, nan
        rate = model.turning(x, state.spin[2])
        v_y_rear = model.rear_mps(x, state.spin[2], nominal)
        v_y_cg = v_y_rear + nominal.cg_x_m * rate
        h = np.zeros(len(x))
        h[SLIDE], h[V_Y] = 1.0, ahead_s
        slide_sd = math.sqrt(max(float(h @ p @ h), 0.0))
        angles = (math.nan, math.nan, math.nan)
        if abs(x[V_X]) >= SLOW_MPS:
            arm = nominal.cg_x_m - nominal.camera_m[0]
            blurred = p[GYRO_BIAS, GYRO_BIAS] + nominal.gyro_sd_radps**2
            sd = math.sqrt(p[V_Y, V_Y] + arm * arm * blurred)
            angles = (
                math.atan2(v_y_cg, x[V_X]), sd / abs(x[V_X]), math.atan2(v_y_rear, x[V_X]),
            )  # fmt: skip
        slide, rear = x[SLIDE] + ahead_s * v_y_cg, x[SLIDE_REAR] + ahead_s * v_y_rear
        speed = (math.nan, math.nan)
        if state.camera_ns >= 0 and state.newest_ns - state.camera_ns < SEEN_NS:
            speed = (float(x[V_X]), math.sqrt(p[V_X, V_X]))
        return v_y_cg, angles[0], angles[1], slide, slide_sd, angles[2], rear, *speed


def _camera(epoch_ns: int, values: Array) -> tuple[Sample, ...]:
    """The two samples of a velocity; none where it or its covariance is unknown.

    The height errs along the velocity; a covariance's smaller eigenvalue is without that.
    """
    ahead, left, var_x, var_y, cov_xy, interval_s, _ = (float(v) for v in values)
    covariance = np.array([[var_x, cov_xy], [cov_xy, var_y]])
    if not (math.isfinite(ahead + left) and np.isfinite(covariance).all()):
        return ()
    variance = max(float(np.linalg.eigvalsh(covariance)[0]), 1e-10)
    span_s = interval_s if 0.0 < interval_s < STALE_S else USUAL_S
    end_ns = epoch_ns + round(0.5e9 * span_s)
    return (
        (epoch_ns, "camera", (ahead, variance)),
        (end_ns, "frame", (ahead, left, variance, span_s)),
    )

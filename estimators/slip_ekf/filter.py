"""The causal filter: every sample in order of arrival, at the epoch it was measured."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from estimators.innovations import keep, note
from estimators.kalman import Array, Record
from estimators.layout import (
    CAMERA,
    GNSS,
    GRAVITY_MPS2,
    IMU,
    OUT_OF_ORDER,
    RESTARTED,
    STALE_S,
    WHEELS,
)
from estimators.slip_ekf import learn, motion, rows
from estimators.slip_ekf.counts import take_wheels
from estimators.slip_ekf.judge import doubt, felt, heard, judged
from estimators.slip_ekf.layout import (
    ACROSS,
    BIAS,
    FROM_CAMERA,
    FROM_GNSS,
    FROM_IMU,
    FROM_TOWED,
    NUMBER,
    RECEIVER,
    SIZE,
    TILTING,
    V,
)
from estimators.slip_ekf.report import report
from estimators.slip_ekf.update import restart, take, variance
from twin.compute.compiled import array_law

FOLLOW = 4.0
"""An acceleration further off than this many sd is a new motion, and is followed."""
ACCEL_FLOOR_MPS2 = 0.01
"""No accelerometer is better than this."""
GYRO_BIAS_SD_RADPS = 1e-3
"""sd of a pitch gyro's bias, 0.06 degrees per second."""
UNHEARD_PSD, UNHEARD_S, ALONE_S, OWN_PSD = 0.2, 4.0, 0.3, 0.0135
"""Without an accelerometer: density of the jerk [m2/s5], time over which accelerations are
forgotten [s], and density of the driven
wheels own jerk [m2/s5]; the driver changes both speeds."""
MOST_EXCESS = 16.0
"""No receiver's noise is more than four times what it says."""
LEAN, LEAN_S, LEAN_SHARE, MOST_LEAN = 0.7, 4.0, 0.05, 3.0
"""Mean e / sqrt(S) of GNSS that is no noise, after what time it is no error of the receiver's
either [s], share of a sample in that mean, and what one counts at most."""
PRESS = 1.0
"""By so much per second counts that GNSS stays with what it says [1/s]."""
GYRO_GAP_S = 0.5
"""Step longer than this and the gyro's integral means nothing [s]."""


@array_law
def loop(
    signals: Any, slower: Array, nominal: Record, tuning: Record, memory: Record, out: Any
) -> int:
    """Take the samples, write an estimate per wheel sample; returns how many."""
    n = 0
    h = np.zeros(SIZE)
    f, q, room = np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    for i in range(len(signals)):
        signal = signals[i]
        memory.flags |= signal.flags
        if signal.flags & OUT_OF_ORDER:
            continue
        advance(signal.epoch_ns, nominal, tuning, memory, f, q, room)
        if measure(signal, slower[i], h, nominal, tuning, memory):
            report(out[n], signal, h, nominal, memory)
            n += 1
    return n


@array_law
def kept_innovations(
    signals: Any, slower: Array, nominal: Record, tuning: Record, memory: Record, kept: Any
) -> int:
    """Take the samples, keep their innovations; returns how many. The room is as `loop` has it."""
    count = 0
    h = np.zeros(SIZE)
    f, q, room = np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    for i in range(len(signals)):
        if not signals[i].flags & OUT_OF_ORDER:
            advance(signals[i].epoch_ns, nominal, tuning, memory, f, q, room)
            measure(signals[i], slower[i], h, nominal, tuning, memory)
            count = keep(memory.notes, signals[i], kept, count)
    return count


@array_law
def measure(
    signal: Record, slower: Array, h: Array, nominal: Record, tuning: Record, memory: Record
) -> bool:
    """Take a sample at its own epoch; whether an estimate is due, one per wheel sample."""
    age = (memory.time_ns - signal.epoch_ns) * 1e-9
    if age > STALE_S:
        memory.flags |= OUT_OF_ORDER
    elif signal.sensor == GNSS:
        _take_gnss(signal, age, h, tuning, memory)
    elif signal.sensor == IMU:
        _take_imu(signal, age, h, nominal, tuning, memory)
    elif signal.sensor == CAMERA:
        _take_camera(signal, age, h, tuning, memory)
    elif signal.sensor == WHEELS:
        take_wheels(signal, age, slower, h, nominal, tuning, memory)
        return True
    return False


@array_law
def advance(
    epoch_ns: int, nominal: Record, tuning: Record, memory: Record, f: Array, q: Array, room: Array
) -> None:
    """Predict to a newer epoch; start again after a gap."""
    dt = (epoch_ns - memory.time_ns) * 1e-9
    if memory.time_ns >= 0 and dt > STALE_S:
        memory.known = 0
        memory.spans[0] = memory.spans[1] = 0
        memory.first_mps = np.nan
        memory.refused_ns[:] = -1
        memory.lean_ns = -1
        memory.flags |= RESTARTED
    elif memory.time_ns >= 0 and dt > 0.0 and memory.known:
        memory.travelled_m += memory.x[V] * dt
        jerk, wheel, both = unrest(felt(memory), tuning, memory)
        fading = fading_s(tuning, memory)
        front_turn = nominal.wheelbase_m * memory.yaw_rate
        motion.step(memory.x, memory.rim_mps, front_turn, fading, dt, tuning, f)
        receiver = memory.excess[FROM_GNSS] * (tuning.receiver_share * nominal.velocity_sd_mps) ** 2
        quick = memory.excess[FROM_TOWED] * tuning.quick_sd**2
        camera, gravity = memory.camera_psd, nominal.gravity
        motion.noise(f, jerk, wheel, both, receiver, quick, camera, gravity, dt, tuning, q)
        motion.carry(memory.p, f, q, room)
        memory.cut[:] = 0
        if memory.keeps:
            memory.gained[:] = 0.0
            memory.lost[:, :] = 0.0
    memory.time_ns = max(memory.time_ns, epoch_ns)


@array_law
def fading_s(tuning: Record, memory: Record) -> float:
    """Time over which accelerations are forgotten [s]."""
    if felt(memory):
        return float(tuning.fading_s)
    return UNHEARD_S if math.isfinite(memory.off_towed) else ALONE_S


@array_law
def unrest(heard: bool, tuning: Record, memory: Record) -> tuple[float, float, float]:
    """Densities of the noise on a, on r, and of both together [m2/s5].

    Under load the wheels, held by the governor, lose a share of what the ground speed loses:
    r = load_gain a + own. Without an accelerometer nothing tells load from throttle, and the
    driver's throttle changes both speeds alike.
    """
    if heard:
        jerk = max(memory.jerk_psd, tuning.jerk_psd)
        gain, own = shared(tuning, memory), tuning.own_share
        return jerk, memory.spin * jerk * (gain**2 + own), gain * jerk
    jerk = UNHEARD_PSD * memory.unrest
    return jerk, jerk + OWN_PSD * memory.spin, jerk


@array_law
def shared(tuning: Record, memory: Record) -> float:
    """What of the ground's acceleration the driven wheels share, as far as it is learnt."""
    if memory.swings[1] == 0.0:
        return float(tuning.load_gain)
    return float(min(max(memory.swings[0] / memory.swings[1], 0.0), 1.0))


@array_law
def _is_carried(speed: float, epoch_ns: int, memory: Record) -> bool:
    """Whether a speed is the last one again, sooner than the receiver usually has a new one.

    Tables that join sensors of several rates repeat the slower ones' values on every row.
    """
    repeated = abs(speed - memory.repeated_mps) <= 1e-9 * abs(speed)
    since = (epoch_ns - memory.changed_ns) * 1e-9
    if repeated:
        return bool(since < 1.5 * memory.interval_s)
    if memory.changed_ns >= 0 and since < STALE_S:
        memory.interval_s += 0.2 * (since - memory.interval_s)
    memory.repeated_mps, memory.changed_ns = speed, epoch_ns
    return False


@array_law
def _take_gnss(signal: Record, age: float, h: Array, tuning: Record, memory: Record) -> None:
    """GNSS meets the speed of its own epoch; what the motion did since is noise."""
    speed, sd = signal.v_x_mps, signal.v_sd_mps
    if not (math.isfinite(speed) and math.isfinite(sd)):
        return
    if _is_carried(signal.horizontal_mps, signal.epoch_ns, memory):
        return
    heard(NUMBER[FROM_GNSS], signal.epoch_ns, speed, memory)
    if not memory.known:
        memory.first_mps, memory.first_var, memory.first_ns = speed, sd**2, signal.epoch_ns
        memory.measured_ns = signal.epoch_ns
        return
    error = speed - rows.gnss(memory.x, age, h)
    white = learn.white_var(NUMBER[FROM_GNSS], speed, signal.epoch_ns, sd**2, memory)
    white += max(memory.jerk_psd, tuning.jerk_psd) * age**3 / 3.0
    press = PRESS if signal.epoch_ns == memory.changed_ns else 0.0
    total = variance(memory.p, h, white)
    nis = error**2 / total
    off, sd = error + memory.x[RECEIVER], math.sqrt(total)
    _lean(off / sd, sd, signal.epoch_ns, press, memory)
    if judged(NUMBER[FROM_GNSS], h, error, white, press, tuning, memory):
        memory.excess[FROM_GNSS] = learn.factor(
            memory.excess[FROM_GNSS], nis, 1.0, 1.0, MOST_EXCESS
        )
        take(memory, h, error, white)
        memory.measured_ns = signal.epoch_ns
    if math.isfinite(signal.v_y_held_mps):
        rows.one(NUMBER[ACROSS], h)
        error, white = signal.v_y_held_mps - memory.x[ACROSS], signal.v_y_held_sd_mps**2
        total = variance(memory.p, h, white)
        if error**2 > tuning.gate**2 * total:  # a skid is rare, a wrong heading is not: in part
            memory.p[ACROSS, ACROSS] += 0.1 * error**2
        else:
            take(memory, h, error, white)


@array_law
def _lean(off: float, sd: float, epoch_ns: int, press: float, memory: Record) -> None:
    """Where GNSS is off the same way for long, within the gate, the estimate is in doubt.

    lean <- lean + share ((e + receiver) / sqrt(S) - lean)

    A receiver errs for some seconds and not longer; towed wheels that come to skid stay so.

    Args:
        off: how far it is off the ground speed, over sqrt(S).
        sd: sqrt(S) [m/s].
        epoch_ns: when.
        press: 0 for a value that repeats the last one to the bit, which tells nothing.
        memory: record, changed.
    """
    since = (epoch_ns - memory.lean_ns) * 1e-9
    if memory.lean_ns < 0 or since > STALE_S + LEAN_S or press == 0.0:
        memory.lean, memory.lean_ns = 0.0, epoch_ns
        return
    memory.lean += LEAN_SHARE * (min(max(off, -MOST_LEAN), MOST_LEAN) - memory.lean)
    if abs(memory.lean) < LEAN:
        memory.lean_ns = epoch_ns
    elif since > LEAN_S:
        doubt(NUMBER[FROM_GNSS], memory.lean * sd, LEAN_S, True, memory)
        memory.lean, memory.lean_ns = 0.0, epoch_ns


@array_law
def _take_camera(signal: Record, age: float, h: Array, tuning: Record, memory: Record) -> None:
    """A camera's forward speed; its own height is not known, and moves."""
    speed = signal.v_x_mps
    if not (math.isfinite(speed) and math.isfinite(signal.v_sd_mps)):
        return
    heard(NUMBER[FROM_CAMERA], signal.epoch_ns, speed, memory)
    white = signal.v_sd_mps**2 + (CAMERA_SD * speed) ** 2
    learn.camera_walk(speed, signal.epoch_ns, tuning.camera_psd, memory)
    if not memory.known:
        waited_s = (signal.epoch_ns - memory.first_ns) * 1e-9
        if not math.isfinite(memory.first_mps) or waited_s > STALE_S:
            memory.first_mps, memory.first_ns = speed, signal.epoch_ns
            memory.first_var = white + (tuning.scale_sd * speed) ** 2
        return
    error = speed - rows.camera(memory.x, age, h)
    if judged(NUMBER[FROM_CAMERA], h, error, white, 0.0, tuning, memory):
        take(memory, h, error, white)
        memory.measured_ns = signal.epoch_ns


CAMERA_SD = 0.005
"""sd of the quick part of a camera's relative error, as the chassis shakes."""


@array_law
def _take_imu(
    signal: Record, age: float, h: Array, nominal: Record, tuning: Record, memory: Record
) -> None:
    """An acceleration; how the gyro turns the body since the last one is known, and not learnt."""
    accel, leaking = signal.accel_x_mps2, nominal.gravity * GRAVITY_MPS2
    dt = (signal.epoch_ns - memory.imu_ns) * 1e-9
    rate = signal.pitch_rate_radps
    fresh = memory.imu_ns >= 0 and 0.0 < dt < GYRO_GAP_S
    memory.pitch_accel = (rate - memory.pitch_rate) / dt if fresh else 0.0
    if fresh:
        memory.pitch_rad += 0.5 * (memory.pitch_rate + rate) * dt
    memory.pitch_rate = rate
    if memory.known and math.isfinite(signal.gyro_y_radps):
        if not math.isfinite(memory.gyro):
            restart(memory, NUMBER[TILTING], (leaking * GYRO_BIAS_SD_RADPS) ** 2)
        elif fresh:
            tilt = 0.5 * (memory.gyro + signal.gyro_y_radps) * dt
            memory.x[BIAS] -= leaking * tilt
        else:  # nobody knows how the body turned
            memory.p[BIAS, BIAS] += (nominal.gravity * tuning.leak_sd) ** 2
        memory.gyro = signal.gyro_y_radps
        # the unit stands above the axle: pitching moves it
        accel -= memory.pitch_accel * nominal.imu_m[2]
    accel += signal.yaw_rate_radps**2 * nominal.imu_m[0]
    if not math.isfinite(accel):
        memory.imu_ns = signal.epoch_ns
        return
    floor = nominal.accel_sd_mps2 if math.isfinite(nominal.accel_sd_mps2) else 0.0
    level = accel + leaking * memory.pitch_rad
    white = learn.accel_var(level, signal.epoch_ns, max(floor, ACCEL_FLOOR_MPS2) ** 2, memory)
    memory.imu_ns = signal.epoch_ns
    if not memory.known:
        return
    error = accel - rows.accel(memory.x, h)
    white += max(memory.jerk_psd, tuning.jerk_psd) * age
    total = variance(memory.p, h, white)
    note(memory.notes, error, total)
    memory.nis_sum[FROM_IMU] += error**2 / total
    memory.nis_count[FROM_IMU] += 1
    if error**2 > FOLLOW**2 * total:
        jolt, step = error**2 - total, min(max(dt, 1e-3), 0.1)
        gain, own = shared(tuning, memory), tuning.own_share
        psd = jolt / step
        motion.shaken(memory.p, psd, psd * (gain**2 + own), psd * gain, step)
    take(memory, h, error, white)

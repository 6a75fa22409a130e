"""GNSS: a speed taken once, at its own epoch; a test of its mean innovation."""

from __future__ import annotations

import math

from estimators.kalman import Array, Record
from estimators.layout import STALE_S
from estimators.slip_ekf import learn, rows
from estimators.slip_ekf.judge import accepted, inflate, note_speed
from estimators.slip_ekf.layout import FROM_GNSS, GNSS_BIAS, NUMBER, V_Y
from estimators.slip_ekf.update import take, variance
from twin.compute.compiled import array_law

MOST_EXCESS = 16.0
"""Most factor of the variance of a receiver's noise."""
MOST_MEAN, MOST_MEAN_S, MEAN_SHARE, CLIP_SD = 0.7, 4.0, 0.05, 3.0
"""Mean e / sqrt(S) of GNSS that is no noise, after what time it is no error of the receiver's
either [s], share of a sample in that mean, and what one counts at most."""
EVIDENCE_PS = 1.0
"""Evidence for GNSS for each second that it goes on to be refused [1/s]."""


@array_law
def take_gnss(signal: Record, age: float, h: Array, tuning: Record, memory: Record) -> None:
    """GNSS meets the speed of its own epoch; what the motion did since is noise."""
    speed, sd = signal.v_x_mps, signal.v_sd_mps
    if not (math.isfinite(speed) and math.isfinite(sd)):
        return
    if _is_repeated(signal.horizontal_mps, signal.epoch_ns, memory):
        return
    note_speed(NUMBER[FROM_GNSS], signal.epoch_ns, speed, memory)
    if not memory.known:
        memory.first_mps, memory.first_var, memory.first_ns = speed, sd**2, signal.epoch_ns
        memory.measured_ns = signal.epoch_ns
        return
    error = speed - rows.gnss(memory.x, age, h)
    white = learn.white_var(NUMBER[FROM_GNSS], speed, signal.epoch_ns, sd**2, memory)
    white += max(memory.jerk_psd, tuning.jerk_psd) * age**3 / 3.0
    evidence_ps = EVIDENCE_PS if signal.epoch_ns == memory.changed_ns else 0.0
    total = variance(memory.p, h, white)
    nis = error**2 / total
    normalised, sd = error + memory.x[GNSS_BIAS], math.sqrt(total)
    _check_mean(normalised / sd, sd, signal.epoch_ns, evidence_ps, memory)
    if accepted(NUMBER[FROM_GNSS], h, error, white, evidence_ps, tuning, memory):
        memory.noise_factor[FROM_GNSS] = learn.factor(
            memory.noise_factor[FROM_GNSS], nis, 1.0, 1.0, MOST_EXCESS
        )
        take(memory, h, error, white)
        memory.measured_ns = signal.epoch_ns
    if math.isfinite(signal.v_y_held_mps):
        rows.one(NUMBER[V_Y], h)
        error, white = signal.v_y_held_mps - memory.x[V_Y], signal.v_y_held_sd_mps**2
        total = variance(memory.p, h, white)
        if error**2 > tuning.gate**2 * total:  # a skid is rare, a wrong heading is not: in part
            memory.p[V_Y, V_Y] += 0.1 * error**2
        else:
            take(memory, h, error, white)


@array_law
def _is_repeated(speed: float, epoch_ns: int, memory: Record) -> bool:
    """Whether a speed is the last one again, sooner than the receiver has had a new one so far.

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
def _check_mean(
    normalised: float, sd: float, epoch_ns: int, evidence_ps: float, memory: Record
) -> None:
    """Inflate the covariance where the mean innovation of GNSS stays far from zero.

    lean <- lean + share ((e + receiver) / sqrt(S) - lean)

    A receiver errs for some seconds and not longer; towed wheels that come to skid stay so.

    Args:
        off: how far it is off the ground speed, over sqrt(S).
        sd: sqrt(S) [m/s].
        epoch_ns: when.
        evidence_ps: 0 for a value that repeats the last one to the bit, which is no evidence.
        memory: record, changed.
    """
    since = (epoch_ns - memory.mean_innovation_ns) * 1e-9
    if memory.mean_innovation_ns < 0 or since > STALE_S + MOST_MEAN_S or evidence_ps == 0.0:
        memory.mean_innovation, memory.mean_innovation_ns = 0.0, epoch_ns
        return
    memory.mean_innovation += MEAN_SHARE * (
        min(max(normalised, -CLIP_SD), CLIP_SD) - memory.mean_innovation
    )
    if abs(memory.mean_innovation) < MOST_MEAN:
        memory.mean_innovation_ns = epoch_ns
    elif since > MOST_MEAN_S:
        inflate(NUMBER[FROM_GNSS], memory.mean_innovation * sd, MOST_MEAN_S, True, memory)
        memory.mean_innovation, memory.mean_innovation_ns = 0.0, epoch_ns

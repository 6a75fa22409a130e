"""The simulation of the IMA-PKF paper (INMATEH 77-13): signals of speeds, no vehicle.

Printed are: ground speed 1-3 m/s, 30 s at 50 Hz, the sensors' noise (R1, R2), and five disturbances
a trial. Its tracks are not; these are three kinds that a ploughing tractor might leave.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Array = NDArray[np.float64]

RATE_HZ, DURATION_S = 50.0, 30.0
SD = {"front": 0.10, "gnss": 0.13, "rear": 0.11, "accel": 0.06, "rear_accel": 0.06}
"""Noise of each signal as R1 and R2 print it [m/s, m/s2]."""
SHARE = 0.05
""""a standard deviation equal to 5 % of the signal amplitude"."""
CENTRES_S, CENTRE_SD_S = (6.0, 10.0, 15.0, 20.0, 25.0), 0.5
"""Means of the disturbances' times; their spread is not printed."""
AMPLITUDE_MPS, FREQUENCY_HZ, LENGTH_S = (0.4, 0.8), (4.5, 5.5), 0.2
RIPPLE_HZ = {"smooth": (), "medium": (0.7, 1.2), "rough": (0.7, 1.2, 1.9, 2.5)}
BURSTS, BURST_RISE_S = 8, 0.15
"""Bursts of slip on a rough track."""

Track = Literal["smooth", "medium", "rough"]


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One run of the simulation."""

    seed: int = 0
    track: Track = "medium"
    """Sines below 0.25 Hz; with ripple to 1.2 Hz; with ripple to 2.5 Hz and bursts of slip."""
    disturbance: Literal["none", "lobe", "cycle"] = "none"
    """Half a sine or a whole one in about 0.2 s: the paper's words allow both."""
    disturbed: Literal["gnss", "speeds", "truth"] = "gnss"
    """What it is added to: the GNSS speed, both measured ground speeds, or the motion itself."""
    noise: Literal["printed", "proportional"] = "printed"
    """The sd that R1 and R2 print, or 5 % of each speed as it is (accelerations as printed)."""
    wheel_accel: bool = True
    """Whether the driven wheels have an accelerometer of their own, which the paper names no
    sensor for and a real machine lacks."""
    accel_bias_sd_mps2: float = 0.0
    """sd of the accelerometers' biases; 0.1 m/s2 is 0.6 degrees of pitch."""


@dataclass(frozen=True, kw_only=True)
class Signals:
    """Truth and measurements of a trial, all at the same epochs; arrays of shape (1500,)."""

    time_s: Array
    ground_mps: Array
    """True ground speed v_e."""
    wheel_mps: Array
    """True theoretical speed of the driven wheels v_q."""
    slip: Array
    """(v_q - v_e) / max(v_q, v_e)."""
    front_mps: Array
    gnss_mps: Array
    rear_mps: Array
    accel_mps2: Array
    rear_accel_mps2: Array
    """NaN without a wheel accelerometer."""


def simulate(trial: Trial) -> Signals:
    """The signals of a trial. The same seed drives the same track whatever else changes."""
    roots = np.random.SeedSequence(trial.seed).spawn(4)
    track_rng, disturbance_rng, noise_rng, bias_rng = (np.random.default_rng(r) for r in roots)
    time = np.arange(1, round(DURATION_S * RATE_HZ) + 1) / RATE_HZ
    wheel, slip = _track(trial.track, track_rng)
    pulses = _disturbances(trial.disturbance, disturbance_rng)

    def ground(t: Array) -> Array:
        moved = pulses(t) if trial.disturbed == "truth" else 0.0
        return np.asarray(wheel(t) * (1.0 - slip(t)) + moved)

    v, w = ground(time), wheel(time)
    off = {name: pulses(time) * (trial.disturbed != "truth") for name in ("gnss", "front")}
    if trial.disturbed == "gnss":
        off["front"] = np.zeros_like(time)
    bias, wheel_bias = trial.accel_bias_sd_mps2 * bias_rng.standard_normal(2)
    noise = {name: noise_rng.standard_normal(time.shape) for name in SD}
    sd = {name: _sd(trial, name, w if name == "rear" else v) for name in SD}
    rear_accel = _slope(wheel, time) + wheel_bias + sd["rear_accel"] * noise["rear_accel"]
    return Signals(
        time_s=time,
        ground_mps=v,
        wheel_mps=w,
        slip=(w - v) / np.maximum(w, v),
        front_mps=v + off["front"] + sd["front"] * noise["front"],
        gnss_mps=v + off["gnss"] + sd["gnss"] * noise["gnss"],
        rear_mps=w + sd["rear"] * noise["rear"],
        accel_mps2=_slope(ground, time) + bias + sd["accel"] * noise["accel"],
        rear_accel_mps2=rear_accel if trial.wheel_accel else np.full_like(time, np.nan),
    )


def _sd(trial: Trial, name: str, speed_mps: Array) -> Array:
    printed = np.full_like(speed_mps, SD[name])
    proportional = trial.noise == "proportional" and not name.endswith("accel")
    return SHARE * speed_mps if proportional else printed


def _track(
    kind: Track, rng: Generator
) -> tuple[Callable[[Array], Array], Callable[[Array], Array]]:
    """Wheel speed 1.3-2.9 m/s and slip .06-.29 as functions of time."""
    phase = rng.uniform(0.0, 2.0 * np.pi, 4)
    ripples = [(hz, *rng.uniform(0.0, 2.0 * np.pi, 2)) for hz in RIPPLE_HZ[kind]]
    at = np.sort(rng.uniform(2.0, DURATION_S - 2.0, BURSTS)) if kind == "rough" else np.empty(0)

    def wheel(t: Array) -> Array:
        slow = 0.45 * np.sin(0.5 * t + phase[0]) + 0.2 * np.sin(1.4 * t + phase[1])
        ripple = sum(0.05 / hz * np.sin(2 * np.pi * hz * t + a) for hz, a, _ in ripples)
        return np.asarray(2.1 + slow + ripple)

    def slip(t: Array) -> Array:
        slow = 0.07 * np.sin(0.6 * t + phase[2]) + 0.03 * np.sin(1.3 * t + phase[3])
        ripple = sum(0.01 / hz * np.sin(2 * np.pi * hz * t + b) for hz, _, b in ripples)
        bursts = sum(0.04 * np.exp(-0.5 * ((t - when) / BURST_RISE_S) ** 2) for when in at)
        return np.asarray(0.175 + slow + ripple + bursts)

    return wheel, slip


def _disturbances(kind: str, rng: Generator) -> Callable[[Array], Array]:
    """Sum of the trial's five pulses as a function of time [m/s].

    lobe:   A sin(pi f tau),  0 <= tau < 1/f    one half-sine, 0.18-0.22 s long
    cycle:  A sin(2 pi f tau),  0 <= tau < 0.2 s
    """
    starts = rng.normal(CENTRES_S, CENTRE_SD_S)
    amplitudes = rng.uniform(*AMPLITUDE_MPS, len(starts)) * rng.choice((-1.0, 1.0), len(starts))
    frequencies = rng.uniform(*FREQUENCY_HZ, len(starts))

    def pulses(t: Array) -> Array:
        total = np.zeros_like(t)
        for start, amplitude, hz in zip(starts, amplitudes, frequencies, strict=True):
            tau = t - start
            if kind == "lobe":
                wave, length = np.sin(np.pi * hz * tau), 1.0 / hz
            else:
                wave, length = np.sin(2.0 * np.pi * hz * tau), LENGTH_S
            total += amplitude * wave * ((tau >= 0.0) & (tau < length))
        return total if kind != "none" else np.zeros_like(t)

    return pulses


def _slope(f: Callable[[Array], Array], t: Array) -> Array:
    """Derivative by central differences [1/s of f]."""
    return np.asarray((f(t + 1e-4) - f(t - 1e-4)) / 2e-4)

"""The simulation of the IMA-PKF paper (INMATEH 77-13): signals of speeds, no vehicle.

The paper gives ground speeds of 1-3 m/s, 30 s at 50 Hz, the sensors' noise (R1, R2), and five
disturbances a trial. It does not give the speeds over time; here are three plausible kinds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from scenarios.ima_pkf_signals import RATE_HZ, SD, SETUP, Signals, streams, truth
from scenarios.ima_pkf_tracks import DURATION_S, Track, disturbances, slope, track
from twin.streams import Setup, Streams, Table

Array = NDArray[np.float64]

SHARE = 0.05
""""a standard deviation equal to 5 % of the signal amplitude"."""


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One run of the simulation."""

    name: str = "ima-pkf"
    about: str = "signals of the IMA-PKF paper's simulation, no vehicle: 30 s at 50 Hz"
    seed: int = 0
    track: Track = "medium"
    """Sines below 0.25 Hz; with ripple to 1.2 Hz; with ripple to 2.5 Hz and bursts of slip."""
    disturbance: Literal["none", "lobe", "cycle"] = "none"
    """Half a sine or a whole one in about 0.2 s: the paper's words allow both."""
    disturbed: Literal["gnss", "speeds", "truth"] = "gnss"
    """What it is added to: the GNSS speed, both measured ground speeds, or the motion itself."""
    noise: Literal["printed", "proportional"] = "printed"
    """The sd printed as R1 and R2, or 5 % of each present speed (accelerations as printed)."""
    wheel_accel: bool = True
    """Whether the driven wheels have an accelerometer of their own, which the paper names no
    sensor for and a real machine lacks."""
    accel_bias_sd_mps2: float = 0.0
    """sd of the accelerometers' biases; 0.1 m/s2 is 0.6 degrees of pitch."""

    def unread(self) -> dict[str, str]:
        """Fields that `measure` does not read, and what they need."""
        return {} if self.disturbance != "none" else {"disturbed": "disturbance lobe or cycle"}

    def measure(self) -> tuple[Setup, Streams, Table]:
        """The estimators' set-up, the streams, and the truth."""
        signals = simulate(self)
        return setup(self), streams(signals), truth(signals)


CLEAN = Trial()
DISTURBED = Trial(
    name="ima-pkf-disturbed",
    about="the same with five half-sine disturbances of the GNSS speed",
    disturbance="lobe",
)


def setup(trial: Trial) -> Setup:
    """Set-up of a trial for the estimators: it has the sd of the biases, where there are any."""
    assert SETUP.imu is not None
    return replace(SETUP, imu=replace(SETUP.imu, accel_bias_sd_mps2=trial.accel_bias_sd_mps2))


def simulate(trial: Trial) -> Signals:
    """The signals of a trial. The same seed drives the same track whatever else changes."""
    roots = np.random.SeedSequence(trial.seed).spawn(4)
    track_rng, disturbance_rng, noise_rng, bias_rng = (np.random.default_rng(r) for r in roots)
    time = np.arange(1, round(DURATION_S * RATE_HZ) + 1) / RATE_HZ
    wheel, slip = track(trial.track, track_rng)
    pulses = disturbances(trial.disturbance, disturbance_rng)

    def ground(t: Array) -> Array:
        moved = pulses(t) if trial.disturbed == "truth" else 0.0
        return np.asarray(wheel(t) * (1.0 - slip(t)) + moved)

    v, w = ground(time), wheel(time)
    off = {name: pulses(time) * (trial.disturbed != "truth") for name in ("gnss", "front")}
    if trial.disturbed == "gnss":
        off["front"] = np.zeros_like(time)
    bias, wheel_bias = trial.accel_bias_sd_mps2 * bias_rng.standard_normal(2)
    noise = {name: noise_rng.standard_normal(time.shape) for name in SD}
    sd = {name: noise_sd(trial, name, w if name == "rear" else v) for name in SD}
    rear_accel = slope(wheel, time) + wheel_bias + sd["rear_accel"] * noise["rear_accel"]
    return Signals(
        time_s=time,
        ground_mps=v,
        wheel_mps=w,
        slip=(w - v) / np.maximum(w, v),
        front_mps=v + off["front"] + sd["front"] * noise["front"],
        gnss_mps=v + off["gnss"] + sd["gnss"] * noise["gnss"],
        rear_mps=w + sd["rear"] * noise["rear"],
        accel_mps2=slope(ground, time) + bias + sd["accel"] * noise["accel"],
        rear_accel_mps2=rear_accel if trial.wheel_accel else np.full_like(time, np.nan),
    )


def noise_sd(trial: Trial, name: str, speed_mps: Array) -> Array:
    """Standard deviation of a signal's noise, as printed or 5 % of the speed, in its unit. (n,)

    The 5 % are for speeds with `trial.noise` = "proportional".
    """
    printed = np.full_like(speed_mps, SD[name])
    proportional = trial.noise == "proportional" and not name.endswith("accel")
    return SHARE * speed_mps if proportional else printed

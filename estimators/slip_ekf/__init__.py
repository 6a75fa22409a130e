"""Slip from the two speeds of an extended Kalman filter of all streams, and its smoother.

Source of the structure: slip estimated beside the speed it couples to (Berntorp 2016, IEEE TCST 24,
1020; Kilic et al. 2021, RA-L), here by the wheels' own speed as a state, see `model`; the gate of
chi-square; the part of gravity in the acceleration and the radius as states.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators import signals
from estimators.estimate import unknown
from estimators.slip_ekf.filter import loop
from estimators.slip_ekf.layout import MEMORY
from estimators.slip_ekf.raised import USED, Lift, lifted, start
from estimators.slip_ekf.tuning import TUNING
from twin.streams import ESTIMATES, Setup, Streams, Table


@dataclass(frozen=True)
class State:
    """State between chunks; a plain value."""

    reader: signals.Reader
    lift: Lift
    tuning: NDArray[Any]
    """One record of `tuning.TUNING`."""
    memory: NDArray[Any]
    """One record of `layout.MEMORY`."""


@dataclass(frozen=True, kw_only=True)
class SlipEkf:
    """Ground speed, slip of the driven axle and of each wheel, sideslip, each with its sd.

    The state and how it moves: `model`; the rows and when they are refused: `filter`, `rows`. Ticks
    are taken as travel, whose rounding does not add up, and not as speeds, whose rounding does.
    GNSS meets the speed of its own epoch, v - a age. Defaults are from physics and from other seeds
    than the tests'. Three noise levels are estimated from the streams: that of the accelerometer,
    the process noise of the motion (`noise`), and that of the driven wheels from their innovations.
    """

    jerk_psd: float = 0.03
    """Density of the white jerk [m2/s5]."""
    restless: float = 2.0
    """Density of the jerk over what the accelerometer shows of it in some tenths of a second."""
    accel_tau: float = 1.0
    """Time over which an acceleration is forgotten [s]."""
    slip_share: float = 0.6
    """What makes slip grow, as an acceleration w s', over what slows the machine."""
    measured_slip_psd: float = 0.3
    """What is added to it where the wheels have accelerometers, which need no model of slip."""
    load_correlation: float = 0.93
    """Of what slows the ground speed with what makes slip grow: the draft does both at once."""
    unheard_psd: float = 0.15
    """What stands for the density that an accelerometer would show [m2/s5]."""
    unheard_share: float = 0.3
    """What stands for `slip_share` then: the driver changes both speeds."""
    unheard_tau: float = 0.3
    """What stands for `accel_tau` then [s]."""
    usual_tau: float = 5.0
    """Time in which slip comes back to what it usually is [s]."""
    usual_psd: float = 3e-5
    """Density of the walk of that [1/s]."""
    swing_sd: float = 0.001
    """sd of the slip that comes of pitching."""
    swing_hz: float = 1.8
    """Frequency of that; 1.5-4 Hz for a tractor on its tyres [Hz]."""
    swing_damping: float = 0.15
    """Its damping ratio."""
    leak_sd: float = 0.3
    """sd of gravity's share in the acceleration: 2 degrees of mean pitch [m/s2]."""
    leak_psd: float = 5e-6
    """Density of its walk, as the slope changes [m2/s5]."""
    bias_psd: float = 1e-9
    """Density of the walk of an accelerometer's own bias [m2/s5]."""
    gyro_bias_sd: float = 1e-3
    """sd of the pitch gyro's bias, 0.06 degrees per second [rad/s]."""
    radius_sd: float = 0.01
    """sd of the driven wheels' mean radius error: tyre pressure, wear, load."""
    radius_psd: float = 1e-9
    """Density of its walk [1/s]."""
    skid_sd: float = 0.02
    """sd of the towed wheels' error: radius, and skid under their motion resistance."""
    skid_psd: float = 1e-9
    """Density of its walk [1/s]."""
    quick_skid_sd: float = 0.003
    """sd of its quick part, as the load changes."""
    quick_radius_sd: float = 0.001
    """sd of the driven radius's quick part."""
    quick_tau: float = 0.15
    """Correlation time of the quick parts [s]."""
    late_sd: float = 0.02
    """sd of the receiver's error in its own time stamps [s]."""
    gate: float = 3.0
    """A ground speed further off than this many sd is refused."""
    back: float = 0.5
    """Once refused, a speed is taken again within this share of the gate."""
    patience: float = 0.4
    """But not for longer than this [s]."""
    trust: float = 15.0
    """And not for longer than this while another ground speed agrees with the estimate [s]."""
    lean: float = 4.0
    """A mean of GNSS's innovations further off than this many sd says that the others err."""
    follow: float = 4.0
    """An acceleration further off than this many sd is a new motion, and is followed."""
    zero_slip: float = 0.003
    """Slip with the plough out of the ground; 0.2-0.9 % pull nothing."""
    zero_slip_sd: float = 0.02
    """Its sd in one of 50 samples a second, 0.4 % over some seconds."""
    unload: float = -0.0075
    """Change of the counted over the true driven speed when the plough goes down: each rear wheel
    loses about 7 kN, and its radius grows by about 0.75 %."""
    unload_sd: float = 0.003
    """sd of that."""
    load: float = 0.0065
    """The same of the towed wheels, which get what the rear ones lose and shrink."""
    load_sd: float = 0.002
    """sd of that."""
    settle_sd: float = 0.05
    """sd by which gravity's leak changes then, as the body settles another way [m/s2]."""
    camera_scale_sd: float = 0.02
    """sd of the error of a camera's speed, that of its height: 1 cm in 0.5 m."""
    camera_scale_psd: float = 1e-6
    """Density of its walk, as the chassis sinks [1/s]."""
    camera_sd: float = 0.005
    """sd of its quick part, as the chassis shakes."""
    v_y_psd: float = 4e-4
    """Density of the walk of the velocity across the body [m2/s3]."""
    mount_sd: float = 0.00175
    """sd of the antennas' mounting angle, 0.1 degree [rad]."""
    accel_floor_sd: float = 0.01
    """No accelerometer is better than this [m/s2]."""

    def init(self, setup: Setup) -> State:
        """The state before the first sample."""
        tuning = np.zeros(1, TUNING)
        for field in dataclasses.fields(self):
            tuning[field.name] = getattr(self, field.name)
        memory = np.zeros(1, MEMORY)
        for name in MEMORY.names or ():
            if name.endswith("_ns"):
                memory[name] = -1
        memory["first_mps"] = np.nan
        memory["jerk_psd"] = self.unheard_psd
        return State(signals.start(setup), start(setup), tuning, memory)

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The state after the chunk, and a table with one row per accepted wheel sample.

        A wheel sample that is not newer than the last one, or over 5 s older than the newest sample
        of any sensor, gives no row.
        """
        reader, samples = signals.read(state.reader, chunk, USED)
        lift, raised = lifted(state.lift, chunk)
        memory = state.memory.copy()
        rows = unknown(len(samples))
        count = 0
        if len(rows):
            count = loop(samples, raised, reader.nominal[0], state.tuning[0], memory[0], rows)
        table = {name: np.ascontiguousarray(rows[name][:count]) for name in ESTIMATES}
        return State(reader, lift, state.tuning, memory), table


SLIP_EKF = SlipEkf()
"""Extended Kalman filter of GNSS, IMU and wheel speeds; slip from its two speeds."""

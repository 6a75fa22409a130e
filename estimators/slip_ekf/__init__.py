"""Slip from the two speeds of an extended Kalman filter of all streams.

Source of the structure: slip estimated beside the speed it couples to (Berntorp 2016, IEEE TCST 24,
1020; Kilic et al. 2021, RA-L), here by the wheels' own speed as a state, see `motion`; consider
states (Schmidt 1966); noise learnt from innovations (Mehra 1970, IEEE TAC 15, 175).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators import signals
from estimators.estimate import ROW
from estimators.slip_ekf.filter import UNHEARD_PSD, loop
from estimators.slip_ekf.held import USED, Held, held, start
from estimators.slip_ekf.layout import first_memory
from estimators.slip_ekf.tuning import TUNING
from twin.streams import ESTIMATES, Setup, Streams, Table


@dataclass(frozen=True)
class State:
    """State between chunks; a plain value."""

    reader: signals.Reader
    held: Held
    tuning: NDArray[Any]
    """One record of `tuning.TUNING`."""
    memory: NDArray[Any]
    """One record of `layout.MEMORY`."""


@dataclass(frozen=True, kw_only=True)
class SlipEkf:
    """Ground speed, slip of the driven axle and of each wheel, sideslip, each with its sd."""

    jerk_psd: float = 0.03
    """Least density of the white jerk [m2/s5]."""
    restless: float = 1.0
    """Density of the jerk over what the accelerometer shows of it in some tenths of a second."""
    fading_s: float = 1.0
    """Time over which an acceleration is forgotten [s]."""
    slip_s: float = 2.0
    """Correlation time of what slip is off the usual one by, as the draft varies [s]."""
    load_gain: float = 0.44
    """What governed wheels lose of their speed over what the ground speed loses under load."""
    own_share: float = 0.05
    """Density of the wheels' own jerk over that of the ground speed."""
    usual_psd: float = 3e-6
    """Density of the walk of the slip that load and ground call for [1/s]."""
    swing_sd: float = 0.001
    """sd of the slip that comes of pitching."""
    swing_hz: float = 1.8
    """Frequency of that; 1.5-4 Hz for a tractor on its tyres [Hz]."""
    leak_sd: float = 0.3
    """sd of gravity's share in the acceleration: 2 degrees of mean pitch [m/s2]."""
    leak_psd: float = 5e-5
    """Density of its walk, as the slope changes [m2/s5]."""
    bias_psd: float = 1e-9
    """Density of the walk of an accelerometer's own bias [m2/s5]."""
    scale_sd: float = 0.02
    """sd of the towed wheels' and of a camera's scale: radius and skid, 1 cm of height in 0.5 m."""
    towed_s: float = 7200.0
    """Time over which the towed wheels' scale is forgotten [s]."""
    camera_psd: float = 1e-6
    """Density of the walk of a camera's scale, as the chassis sinks [1/s]."""
    quick_sd: float = 0.003
    """sd of the quick part of the towed wheels' error, as the load changes."""
    quick_s: float = 0.15
    """Its correlation time [s]."""
    receiver_share: float = 0.1
    """sd of the part of GNSS's error that lasts, over the sd it states."""
    receiver_s: float = 2.0
    """Its correlation time [s]."""
    across_psd: float = 4e-4
    """Density of the walk of the velocity across the body [m2/s3]."""
    gate: float = 3.0
    """A ground speed further off than this many sd is refused."""
    patience_s: float = 0.3
    """But not for longer than this, unless the other sources speak against it [s]."""

    def init(self, setup: Setup) -> State:
        """The state before the first sample."""
        tuning = np.zeros(1, TUNING)
        for field in dataclasses.fields(self):
            tuning[field.name] = getattr(self, field.name)
        return State(signals.start(setup), start(setup), tuning, first_memory(UNHEARD_PSD))

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The state after the chunk, and a table with one row per accepted wheel sample.

        A wheel sample that is out of order, or over 5 s older than the newest sample, gives no row.
        """
        reader, samples = signals.read(state.reader, chunk, USED)
        known, slower = held(state.held, chunk)
        memory = state.memory.copy()
        rows = np.zeros(len(samples), ROW)
        for name in ESTIMATES:
            if ROW[name].kind == "f":
                rows[name] = np.nan
        count = 0
        if len(rows):
            count = loop(samples, slower, reader.nominal[0], state.tuning[0], memory[0], rows)
        table = {name: np.ascontiguousarray(rows[name][:count]) for name in ESTIMATES}
        return State(reader, known, state.tuning, memory), table


SLIP_EKF = SlipEkf()
"""Extended Kalman filter of GNSS, IMU and wheel speeds; slip from its two speeds."""

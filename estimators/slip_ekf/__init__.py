"""Slip from the two speeds of an extended Kalman filter of all streams.

Source of the structure: slip estimated beside the speed it couples to (Berntorp 2016, IEEE TCST 24,
1020; Kilic et al. 2021, RA-L), here by the wheels' own speed as a state, see `motion`; consider
states (Schmidt 1966); noise learnt from innovations (Mehra 1970, IEEE TAC 15, 175).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators import signals
from estimators.estimate import ROW
from estimators.innovations import KEPT, MOST, as_table
from estimators.slip_ekf.filter import kept_innovations, loop
from estimators.slip_ekf.held import USED, Held, held, start
from estimators.slip_ekf.jerk import NO_IMU_JERK_PSD
from estimators.slip_ekf.layout import first_memory
from twin.streams import ESTIMATES, Setup, Streams, Table


@dataclass(frozen=True)
class State:
    """State between chunks; a plain value."""

    reader: signals.Reader
    held: Held
    tuning: NDArray[Any]
    """One record of TUNING."""
    memory: NDArray[Any]
    """One record of `layout.MEMORY`."""


@dataclass(frozen=True, kw_only=True)
class SlipEkf:
    """Ground speed, slip of the driven axle and of each wheel, sideslip, each with its sd.

    The state and how it moves: `motion`. What each source measures: `rows`. One scalar update for
    all: `update`. When a source is refused, and when the covariance is inflated: `judge` and
    `consensus`. No single source outvotes two: towed wheels alone hold GNSS off for some seconds.

    Learnt on the way: noise of the accelerometer, of speeds and counts, and the jitter of the
    instants at which counters are read (`learn`, `counts`), never below the data sheet; how fast
    the motion changes; the line from load to traction, and the spread about it (`load`).
    Counts are taken as travel, whose rounding does not add up. GNSS meets the speed of its own
    epoch, and a speed that a table carries onto faster rows is taken once.

    Values are from physics and from other seeds and logs than the tests'; their grade is "assumed"
    where no source is named.
    """

    jerk_psd: float = 0.03
    """Least density of the white jerk [m2/s5]: 0.1 m/s2 in 0.3 s; more is learnt."""
    fading_s: float = 1.0
    """Time over which an acceleration is forgotten [s]."""
    slip_s: float = 2.0
    """Correlation time of slip about the expected one [s], as in a T7.165S's field log."""
    wheel_jerk_gain: float = 0.44
    """Change of the governed wheels' speed over that of the ground speed, until it is learnt;
    0.4 to 0.5 when ploughing in the twin, 1 where a throttle moves both."""
    wheel_jerk_share: float = 0.05
    """Density of the wheels' own jerk over that of the ground speed; more is learnt."""
    traction_psd: float = 3e-5
    """Density of the walk of the traction at the mean load [1/s]: 0.05 of its most in a minute."""
    pitch_slip_sd: float = 0.001
    """sd of the slip that comes of pitching."""
    pitch_hz: float = 1.8
    """Frequency of that [Hz]; 1.5-4 Hz for a tractor on its tyres."""
    gravity_sd: float = 0.3
    """sd of gravity's share in the acceleration [m/s2]: 2 degrees of mean pitch."""
    gravity_psd: float = 5e-5
    """Density of its walk [m2/s5]: 0.3 degrees in a minute, as the slope and the draft change."""
    bias_psd: float = 1e-9
    """Density of the walk of an accelerometer's own bias [m2/s5]."""
    scale_sd: float = 0.02
    """sd of the towed wheels' and of a camera's scale: radius and skid, 1 cm of height in 0.5 m."""
    towed_scale_s: float = 7200.0
    """Time over which the towed wheels' scale is forgotten [s]: 0.3 points in a minute."""
    camera_psd: float = 1e-6
    """Least density of the walk of a camera's scale [1/s]; more is learnt as the chassis sinks."""
    towed_fast_sd: float = 0.003
    """sd of the quick part of the towed wheels' error, as the load changes; more is learnt."""
    towed_fast_s: float = 0.15
    """Its correlation time [s]."""
    gnss_bias_share: float = 0.1
    """sd of the part of GNSS's error that lasts, over the sd it states; more is learnt."""
    gnss_bias_s: float = 2.0
    """Its correlation time [s]."""
    v_y_psd: float = 4e-4
    """Density of the walk of the velocity across the body [m2/s3]."""
    gate: float = 3.0
    """A ground speed further off than this many sd is refused."""
    hold_s: float = 0.3
    """An accelerometer's word alone holds a speed off for this time [s]: longer than the half-sines
    of 0.2 s of the IMA-PKF paper."""

    tunable: ClassVar[Mapping[str, str]] = {
        "traction_psd": "assumed",
        "pitch_slip_sd": "assumed",
        "gravity_psd": "assumed",
        "bias_psd": "assumed",
    }
    """Fields that the filter does not learn, for `twin tune` -> grade of the values above."""

    def init(self, setup: Setup) -> State:
        """The state before the first sample."""
        tuning = np.zeros(1, TUNING)
        for field in dataclasses.fields(self):
            tuning[field.name] = getattr(self, field.name)
        return State(signals.start(setup), start(setup), tuning, first_memory(NO_IMU_JERK_PSD))

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The state after the chunk, and a table with one row per accepted wheel sample.

        A wheel sample that is out of order, or over 5 s older than the newest sample, gives no row.
        """
        after, table, _ = self.run_and_held(state, chunk)
        return after, table

    def run_and_held(
        self, state: State, chunk: Streams
    ) -> tuple[State, Table, NDArray[np.float64]]:
        """The same, and what slower sensors had said at each sample, as `held` gives it."""
        reader, samples = signals.read(state.reader, chunk, USED)
        known, slow = held(state.held, chunk)
        memory = state.memory.copy()
        rows = np.zeros(len(samples), ROW)
        for name in ESTIMATES:
            if ROW[name].kind == "f":
                rows[name] = np.nan
        count = 0
        if len(rows):
            count = loop(samples, slow, reader.nominal[0], state.tuning[0], memory[0], rows)
        table = {name: np.ascontiguousarray(rows[name][:count]) for name in ESTIMATES}
        return State(reader, known, state.tuning, memory), table, slow

    def innovations(self, setup: Setup, streams: Streams) -> Table:
        """Innovation of each measurement, refused or not, and its predicted variance."""
        state = self.init(setup)
        reader, samples = signals.read(state.reader, streams, USED)
        _, slow = held(state.held, streams)
        memory, kept = state.memory.copy(), np.zeros(MOST * len(samples), KEPT)
        memory["notes"]["wanted"] = 1
        count = 0
        if len(samples):
            nominal, tuning = reader.nominal[0], state.tuning[0]
            count = kept_innovations(samples, slow, nominal, tuning, memory[0], kept)
        return as_table(kept[:count])


TUNING = np.dtype([(field.name, "f8") for field in dataclasses.fields(SlipEkf)], align=True)
"""What the filter can be tuned by, as compiled code reads it."""
SLIP_EKF = SlipEkf()
"""Extended Kalman filter of GNSS, IMU and wheel speeds; slip from its two speeds."""

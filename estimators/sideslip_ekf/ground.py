"""Which way the ground leans, and whether it is level: where sliding is known to be nothing.

Driven along twice, there and back, level ground feels the same to the body, and a slope does not:
what it adds changes its sign. So no bias of an accelerometer is taken for a slope, and half of what
differs is how far a field is not level.
"""

from __future__ import annotations

import math

from estimators.kalman import Array, Record
from estimators.sideslip_ekf import motion
from estimators.sideslip_ekf.layout import HEADING, SECTORS, V_X
from twin.compute.compiled import array_law

FELT_S, SLOW_S = 0.5, 8.0
"""Times over which forces are averaged, for the law of sliding and for the ground [s]."""
SETTLED_S = 3.0
"""A straight stretch shorter than this tells nothing of the ground [s]."""
ALIKE_MPS2 = 0.2
"""Forces there and back that differ by less are those of level ground, which leans by half of that,
by 0.6 degrees at most: a field of ISO 8608's class C leans by 0.3 degrees rms over 20 m."""
MOST_MPS2 = 0.43
"""And none that is larger, 2.5 degrees: that is no accelerometer's bias."""
DROP = 0.02
"""A body that leans otherwise by so much does not lean with the ground [rad]."""
STRAIGHT_RADPS, DRIVING_MPS = 0.03, 0.3
UNKNOWN_RAD2 = 1.0
"""A heading of a larger variance is unknown."""
GRADE_S, GROUND_S = 8.0, 8.0
"""Times over which climb and lean are averaged: a wheel may stand in a furrow for a while [s]."""


@array_law
def feel(imu: Array, dt: float, memory: Record) -> None:
    """Average the forces ahead and to the left, and how rough they are."""
    gain = min(dt / FELT_S, 1.0)
    for i in range(2):
        force = imu[3 + i]
        if not math.isfinite(force):
            continue
        if memory.felt_s == 0.0:
            memory.felt[i] = force
        memory.felt[i] += gain * (force - memory.felt[i])
        if i == 1:
            slow = min(dt / SLOW_S, 1.0)
            memory.felt_var += slow * ((force - memory.felt_slow[1]) ** 2 - memory.felt_var)
        share = dt / min(memory.stretch_s + dt, SLOW_S)
        memory.felt_slow[i] += share * (force - memory.felt_slow[i])
    memory.felt_s += dt


@array_law
def survey(turning_radps: float, dt: float, memory: Record) -> None:
    """Whether the ground is level here, and how it leans where nothing is pulled."""
    x = memory.x
    if memory.p[HEADING, HEADING] > UNKNOWN_RAD2:
        return
    straight = abs(turning_radps) < STRAIGHT_RADPS and abs(x[V_X]) > DRIVING_MPS
    if memory.pulls or not straight:
        memory.stretch_s = 0.0
        memory.level = 0
        if not memory.pulls:
            _lean(dt, memory)
        return
    memory.stretch_s += dt
    _lean(dt, memory)
    if memory.stretch_s < SETTLED_S or not memory.heard[4]:
        memory.level = 0
        return
    here = math.floor(x[HEADING] / (2.0 * math.pi) * SECTORS + 0.5) % SECTORS
    for i in range(2):
        memory.sector_felt[here, i] = memory.felt_slow[i]
    memory.sector_s[here] = memory.stretch_s
    memory.level = 0
    for beside in (-1, 0, 1):
        back = (here + SECTORS // 2 + beside) % SECTORS
        alike = memory.sector_s[back] > 0.0
        for i in range(2):
            felt = memory.felt_slow[i]
            alike = alike and abs(felt - memory.sector_felt[back, i]) < ALIKE_MPS2
            alike = alike and abs(felt) < MOST_MPS2
        if alike:
            memory.level = 1
            for i in range(2):
                memory.uneven[i] = 0.5 * (memory.felt_slow[i] - memory.sector_felt[back, i])


@array_law
def _lean(dt: float, memory: Record) -> None:
    """Average the ground's gradient, from the body's roll and the climb."""
    x = memory.x
    along, left = math.tan(memory.grade), math.tan(motion.across(x, memory))
    cos, sin = math.cos(x[HEADING]), math.sin(x[HEADING])
    across = memory.ground[1] * cos - memory.ground[0] * sin
    if memory.ground_s > SETTLED_S and abs(left - across) > DROP:
        return  # a wheel has dropped into a furrow
    gain = dt / min(memory.ground_s + dt, GROUND_S)
    memory.ground_s += dt
    for i, seen in ((0, cos * along - sin * left), (1, sin * along + cos * left)):
        memory.ground[i] += gain * (seen - memory.ground[i])
    memory.surveyed = 1


@array_law
def climb(up_mps: float, ahead_mps: float, dt: float, memory: Record) -> None:
    """Average the angle of climb, atan2(up, ahead), while the machine moves."""
    if abs(ahead_mps) < DRIVING_MPS or not math.isfinite(up_mps):
        return
    gain = dt / min(memory.grade_s + dt, GRADE_S)
    memory.grade_s += dt
    memory.grade += gain * (math.atan(up_mps / ahead_mps) - memory.grade)


@array_law
def forget(memory: Record) -> None:
    """Other ground; what was felt along each heading stays, as the biases do."""
    memory.grade = memory.grade_s = memory.ground_s = 0.0
    memory.surveyed, memory.level = 0, 0
    memory.stretch_s = memory.felt_s = 0.0

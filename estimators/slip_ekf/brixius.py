"""Gross traction over its most, as Brixius' law has it, and back to slip.

Source: Brixius 1987, ASAE paper 87-1622; ASABE D497.
"""

from __future__ import annotations

import math

from twin.compute.compiled import array_law

BRIXIUS = 7.5
"""Exponent of slip in Brixius' gross traction."""
MOST_TRACTION = 0.95
"""Beyond this, at a slip of 40 %, the law goes on straight."""


@array_law
def traction(slip: float) -> tuple[float, float]:
    """y = 1 - exp(-7.5 slip) and dy/dslip; odd, and straight where it is more than 0.95."""
    knee = -math.log(1.0 - MOST_TRACTION) / BRIXIUS
    size = abs(slip)
    gradient = BRIXIUS * math.exp(-BRIXIUS * min(size, knee))
    y = 1.0 - gradient / BRIXIUS + gradient * max(size - knee, 0.0)
    return math.copysign(y, slip), gradient


@array_law
def slip_of(y: float) -> tuple[float, float]:
    """The slip of a y, and dslip/dy."""
    size = min(abs(y), MOST_TRACTION)
    gradient = 1.0 / (BRIXIUS * (1.0 - size))
    slip = -math.log(1.0 - size) / BRIXIUS + gradient * (abs(y) - size)
    return math.copysign(slip, y), gradient

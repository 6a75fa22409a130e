"""Steps of a discrete controller: a first-order lag, a limited rate, a limited range."""

from __future__ import annotations

from twin.compute.compiled import inlined_law


@inlined_law
def within(low: float, value: float, high: float) -> float:
    """The value, held between two limits."""
    return max(low, min(high, value))


@inlined_law
def towards(now: float, wanted: float, step: float) -> float:
    """From `now` towards `wanted`, by `step` at most."""
    return now + within(-step, wanted - now, step)


@inlined_law
def lagged(now: float, value: float, time_constant_s: float, dt_s: float) -> float:
    """First-order lag, one explicit Euler step: x + (u - x) dt / T"""
    return now + (value - now) * dt_s / time_constant_s

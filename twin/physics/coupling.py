"""Clutch, differential lock, front-axle drive and brakes: one friction element."""

from __future__ import annotations

from twin.compute.compiled import law
from twin.physics.block import Coupling
from twin.physics.shapes import Array

RELEASE_S = 0.1
"""Time in which a released element unwinds [s]; assumed."""


@law
def twist(
    element: Array, applied: float, windup: float, rate_radps: float, dt_s: float
) -> tuple[float, float]:
    """Torque of an elastic-plastic friction element, and the rate of its wind-up u.

        u' = clip(u + w dt / u_max, -1, 1)        du/dt = (u' - u) / dt
        T  = applied capacity clip(u' + tau du/dt, -1, 1)

    Below capacity it is a spring, so it holds without creeping; at capacity it slides. The torque
    is taken at the end of the step, as the tyres' shear is.

    Args:
        element: part of the parameter block (`Coupling`): capacity, u_max and tau.
        applied: how far it is applied, 0 to 1.
        windup: u, twist over the twist at capacity, -1 to 1.
        rate_radps: w, relative speed of its two sides.
        dt_s: time step dt.

    Returns:
        torque_nm, positive against a positive w; du/dt [1/s].
    """
    if applied <= 0.0:
        return 0.0, -windup / RELEASE_S
    reached = min(max(windup + dt_s * rate_radps / element[Coupling.WINDUP_RAD], -1.0), 1.0)
    rate = (reached - windup) / dt_s
    held = min(max(reached + element[Coupling.DAMPING_S] * rate, -1.0), 1.0)
    return applied * element[Coupling.CAPACITY_NM] * held, rate

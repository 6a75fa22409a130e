"""Tanks that events fill and empty: bodies on the tractor whose mass changes."""

from __future__ import annotations

import mujoco

from twin.scenario import Event

LEAST_KG = 1e-3
"""Mass of an empty one: what the tractor weighs is in its file already."""
GYRATION_M2 = (0.08, 0.02, 0.08)
"""Squared radii of gyration about the body's axes: of a tank 0.9 m wide; assumed."""


def body_of(tank: str) -> str:
    """Name of the body that a tank's content is: fuel under the cab, seed and water in front."""
    return "tank.fuel" if tank == "fuel" else "tank.front"


def fit_tanks(spec: mujoco.MjSpec, events: tuple[Event, ...], numbers: dict[str, float]) -> None:
    """Add the tanks that events change: fuel before the rear axle, the others before the front."""
    wheelbase_m = float(spec.body("front_axle").pos[0])
    front_m = numbers.get("front_ballast.x_m", wheelbase_m)
    places = {"tank.fuel": (0.35 * wheelbase_m, 0.0), "tank.front": (front_m, 0.3)}
    for name in sorted({body_of(e.tank or "fuel") for e in events if e.mass_kg is not None}):
        x_m, z_m = places[name]
        spec.body("tractor").add_body(
            name=name, pos=[x_m, 0.0, z_m], ipos=[0.0] * 3, mass=LEAST_KG,
            inertia=[LEAST_KG * k for k in GYRATION_M2], explicitinertial=True,
        )  # fmt: skip

"""Tanks that events fill and empty: bodies on the tractor whose mass changes."""

from __future__ import annotations

import mujoco

from twin.errors import BadInput
from twin.scenario import Event
from twin.scenario.events import most_filled_kg

LEAST_KG = 1e-3
"""Mass of an empty tank: the tractor's mass in its file includes it."""
GYRATION_M2 = (0.08, 0.02, 0.08)
"""Squared radii of gyration of a tank's content about its axes, for a tank 0.9 m wide; assumed."""
PAYLOAD_SHARE = 0.6
"""Greatest mass filled in, over the machine's mass: permissible total masses of tractors are 1.5 to
1.8 times the unladen mass; assumed."""


def body_of(tank: str) -> str:
    """Name of the MuJoCo body of a tank's content; seed and water share the one in front."""
    return "tank.fuel" if tank == "fuel" else "tank.front"


def fit_tanks(spec: mujoco.MjSpec, events: tuple[Event, ...], numbers: dict[str, float]) -> None:
    """Add the tanks that events fill or empty: fuel ahead of the rear axle, others at the front.

    `numbers` are the <numeric> values of the machine by name.
    """
    wheelbase_m = float(spec.body("front_axle").pos[0])
    front_m = numbers.get("front_ballast.x_m", wheelbase_m)
    places = {"tank.fuel": (0.35 * wheelbase_m, 0.0), "tank.front": (front_m, 0.3)}
    for name in sorted({body_of(e.tank or "fuel") for e in events if e.mass_kg is not None}):
        x_m, z_m = places[name]
        spec.body("tractor").add_body(
            name=name, pos=[x_m, 0.0, z_m], ipos=[0.0] * 3, mass=LEAST_KG,
            inertia=[LEAST_KG * k for k in GYRATION_M2], explicitinertial=True,
        )  # fmt: skip


def refuse_overload(model: mujoco.MjModel, events: tuple[Event, ...]) -> None:
    """Raise BadInput if events fill in more than PAYLOAD_SHARE of the machine's mass."""
    own_kg, filled_kg = float(model.body_mass.sum()), most_filled_kg(events)
    if filled_kg > PAYLOAD_SHARE * own_kg:
        raise BadInput(
            f"events fill in {filled_kg:g} kg, but the machine weighs {own_kg:.0f} kg; at most "
            f"{PAYLOAD_SHARE * own_kg:.0f} kg would do"
        )

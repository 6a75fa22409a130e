"""State of the laws from step to step: activations of one actuator, by name."""

from __future__ import annotations

import mujoco

from twin.physics import block

ACTUATOR = "laws"
"""The actuator that has these activations; it has no gain and moves nothing."""


def names(shares: int) -> tuple[str, ...]:
    """Names of the activations in their order, for an implement of so many shares.

    Deflection of each tyre along and across [m] and its contact's slip [-], wind-up of each
    coupling [-], and compression of the soil before each share, ahead and towards the land [m].
    """
    return (
        *(f"{w}_{what}_{axis}" for w in block.WHEELS for what in ("tyre", "slip") for axis in "xy"),
        *(f"{c}_windup" for c in block.COUPLINGS),
        *(f"soil_{i + 1}_{axis}" for i in range(shares) for axis in "xy"),
    )


def address(model: mujoco.MjModel, name: str) -> int:
    """Index in mjData.act of the activation `name`."""
    first = int(model.actuator_actadr[model.actuator(ACTUATOR).id])
    return first + names(block.MOST_SHARES).index(name)


def name_of(model: mujoco.MjModel, k: int) -> str:
    """Name of the activation with index `k` in mjData.act."""
    for i in range(model.nu):
        first, count = int(model.actuator_actadr[i]), int(model.actuator_actnum[i])
        if first <= k < first + count:
            own = str(model.actuator(i).name)
            return names(block.MOST_SHARES)[k - first] if own == ACTUATOR else own
    return f"activation {k}"

"""A machine with its implement as one MuJoCo specification, from hand-made or generated MJCF."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import mujoco

from twin.errors import BadInput
from twin.machine.implement_mjcf import implement_spec
from twin.machine.mjcf import machine_spec
from twin.vehicle.files import mjcf_path
from twin.vehicle.implement import Implement
from twin.vehicle.machine import Machine
from twin.vehicle.numerics import PREFIX, implement_numbers, machine_facts, own_numerics

TOP_LINK_NPM, TOP_LINK_NSPM = 20e6, 200e3
"""Stiffness and damping of the top link for an implement of 1470 kg: a steel tube with the
elasticity of its pins and mounts. Both are scaled with the mass for a lighter implement, so that a
step can resolve it."""
FULL_KG = 1470.0


def joined(
    machine: Machine, part: Implement | None = None
) -> tuple[mujoco.MjSpec, dict[str, float]]:
    """mujoco.MjSpec of a machine with its implement, without ground; and its numerics by name.

    Raises:
        BadInput: a MJCF cannot be read, has no place for an implement, or carries one already.
    """
    machine_facts(machine)  # refuses a MJCF that would not drive
    spec = _read(machine) or machine_spec(machine)
    numbers = {n.name: float(n.data[0]) for n in spec.numerics} | own_numerics(machine)
    if part is not None:
        _attach(spec, machine, part)
        numbers |= {PREFIX + name: value for name, value in implement_numbers(part).items()}
    return spec, numbers


def _read(part: Machine | Implement) -> mujoco.MjSpec | None:
    """The hand-made MJCF; None where there is none."""
    path = mjcf_path(part)
    if path is None:
        return None
    stamps = tuple(p.stat().st_mtime_ns for p in sorted(path.parent.glob("*.xml")))
    return _parsed(path, stamps).copy()


@lru_cache(maxsize=8)
def _parsed(path: Path, stamps: tuple[int, ...]) -> mujoco.MjSpec:
    """A MJCF as it was at these times of it and its neighbours: parsing takes 50 ms, a copy 0.4."""
    try:
        return mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise BadInput(f"{path} is no MJCF: {' '.join(str(error).split())}") from None


def _attach(spec: mujoco.MjSpec, machine: Machine, part: Implement) -> None:
    """Hang the implement's frame on the hitch, and join it by the top link."""
    hitch = spec.frame("hitch")
    if hitch is None:
        raise BadInput(f"{machine.name} has no frame 'hitch' for an implement")
    child = _read(part) or implement_spec(part)
    frame = child.body("frame")
    if frame is None:
        raise BadInput(f"{part.name} has no body 'frame'")
    mass_kg = float(frame.mass)
    hitch.attach_body(frame, PREFIX, "")
    share = min(1.0, mass_kg / FULL_KG)
    link = spec.add_tendon(
        name="top_link", width=0.025, rgba=[0.25, 0.25, 0.25, 1.0],
        stiffness=[TOP_LINK_NPM * share, 0, 0], damping=[TOP_LINK_NSPM * share, 0, 0],
    )  # fmt: skip
    link.wrap_site("top_link_front")
    link.wrap_site(PREFIX + "top_link_rear")

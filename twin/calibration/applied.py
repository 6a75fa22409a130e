"""Values of parameters put into a machine's file and into a soil; their present values read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from twin.calibration.known import FUEL_L_PER_KWH, GRADE_SHARES, KNOWN, OF_LAW
from twin.errors import BadInput
from twin.physics.law_reads import fields_read
from twin.scenario import Soil
from twin.scenario.fields import replaced
from twin.vehicle import Machine
from twin.vehicle.derive import derive
from twin.vehicle.machine import Numeric
from twin.vehicle.numerics import machine_facts

Values = Mapping[str, float]
OWN_OF_SOIL = (
    "friction", "cone_index_kpa", "draft_scale", "k_phi_kn_per_m_n2", "shear_modulus_m",
)  # fmt: skip
"""Parameters that are fields of a soil; the others are in its preset."""


def machine_with(machine: Machine, values: Values) -> Machine:
    """The machine with other values; those of soil and log are passed over."""
    own = {n: v for n, v in values.items() if not n.startswith(("soil.", "log."))}
    if machine.mjcf is None:
        changed: Machine = replaced(machine, own)
        return changed
    numbers = dict(machine_facts(machine).numbers)
    new: dict[str, float] = {n.name: n.value for n in machine.numerics}
    for name, value in own.items():
        write = KNOWN[name].numerics
        if write is None:
            raise BadInput(
                f"{name} cannot be fitted to {machine.name}: its MJCF is made by hand and does not "
                "hold it as a numeric; a machine file without mjcf would do"
            )
        new |= write(numbers, value)
    numerics = tuple(Numeric(name=n, value=v) for n, v in new.items())
    return replace(machine, numerics=numerics)


def soil_with(soil: Soil, values: Values) -> Soil:
    """The soil with other values; those of machine and log are passed over."""
    own: dict[str, Any] = {
        n.removeprefix("soil."): v for n, v in values.items() if n.startswith("soil.")
    }
    fields = {n: v for n, v in own.items() if n in OWN_OF_SOIL}
    rest = {n: v for n, v in own.items() if n not in OWN_OF_SOIL}
    kept = soil.with_numbers()
    assert kept.numbers is not None
    return replace(kept, **fields, numbers=replace(kept.numbers, **rest))


def reads(soil: Soil, name: str) -> bool:
    """Whether a parameter of a soil changes anything under its law; others always do."""
    if not name.startswith("soil."):
        return True
    own = name.removeprefix("soil.")
    deformable = soil.resolved.deformable
    if own not in OF_LAW["brixius"] and (deformable is None or not hasattr(deformable, own)):
        return False
    if soil.law in OF_LAW:
        return own in OF_LAW[soil.law]
    return own == "draft_scale" or own in fields_read(soil.law)


def can_fit(machine: Machine, name: str) -> bool:
    """Whether a machine's file can hold a parameter."""
    known = KNOWN[name]
    return name.startswith(("soil.", "log.")) or machine.mjcf is None or known.numerics is not None


def believed(machine: Machine, soil: Soil, name: str) -> tuple[float, float, str]:
    """Value of a parameter before the log, prior sd of its logarithm, and its grade.

    A machine's number has the sd of its grade (`GRADE_SHARES` of an assumed one's). A soil's is
    always assumed.
    """
    known = KNOWN[name]
    if name.startswith("soil."):
        own = name.removeprefix("soil.")
        found = soil.resolved if hasattr(soil.resolved, own) else soil.resolved.deformable
        return float(getattr(found, own)), known.spread, "assumed"
    if name == "engine.fuel_l_per_kwh" and machine.mjcf is not None:
        return FUEL_L_PER_KWH, known.spread, "assumed"
    if machine.mjcf is not None:
        assert known.read is not None
        grade = _grade(machine, name)
        value = known.read(machine_facts(machine).numbers)
    else:
        number = derive(machine).numbers[name]
        value, grade = number.value, number.grade
    return float(value), known.spread * GRADE_SHARES[grade], grade


def _grade(machine: Machine, name: str) -> str:
    """Grade of a field by the file's sources, or that of the file."""
    return next((s.grade for s in machine.sources if s.path == name), machine.grade)

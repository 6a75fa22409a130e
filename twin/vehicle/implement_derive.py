"""All numbers of an implement from its file: a number left out is derived by its kind's rules.

The rules keep the proportions of a four-body plough of 1470 kg (models/plough_1lf435/README.md).
"""

from __future__ import annotations

from functools import lru_cache

from twin.vehicle.derive import Derived
from twin.vehicle.implement import Implement
from twin.vehicle.kinds import KINDS
from twin.vehicle.sheet import Sheet

FAILS_M = 0.0113
"""Compression at which the soil before a body fails, at half the kind's depth in fine soil [m]."""


@lru_cache(maxsize=64)
def derive_implement(part: Implement) -> Derived:
    """The numbers of an implement without a hand-made MJCF."""
    sheet, kind = Sheet(part), KINDS[part.kind]
    mass_kg = sheet.take("mass_kg", 0.0, "given", "")
    width_m = sheet.take("width_m", 0.0, "given", "")
    count = part.bodies or 1
    bodies = sheet.write("bodies", count, *sheet.origin("bodies"))
    one_m = sheet.write("body_width_m", width_m / bodies, "derived", "width over bodies")
    depths = part.depth_m or kind.depth_m
    grade, said = ("assumed", "usual of the kind") if part.depth_m is None else (
        sheet.origin("depth_m"))  # fmt: skip
    sheet.write("depth_m.least", depths[0], grade, said)
    sheet.write("depth_m.most", depths[1], grade, said)
    rows = part.rows or min(kind.rows, count)
    sheet.write("rows", rows, "assumed" if part.rows is None else "given", "usual of the kind")
    steps = (count if kind.furrow else rows) - 1
    size = min(1.0, max(0.5, one_m / 0.35)) if kind.furrow else 1.0
    length_m = sheet.take(
        "length_m", 0.65 + size * kind.spacing_m * steps, "assumed",
        "0.65 m to the first bar, and the kind's spacing",
    )  # fmt: skip
    clearance_m = sheet.take(
        "clearance_m", max(0.78, 0.38 + depths[1]) if mass_kg > 500 else max(0.62, 0.3 + depths[1]),
        "assumed", "0.78 m, 0.62 of light ones; deep ones 0.38 m above the ground at their depth",
    )  # fmt: skip
    sheet.take("mast_m", 0.69 if mass_kg > 500 else 0.5, "assumed", "category 3 and 2")
    draft = sheet.take
    a = draft("draft.a", kind.a, "published", "ASABE D497, two transcriptions")
    b = draft("draft.b", kind.b, "published", "ASABE D497, two transcriptions")
    c = draft("draft.c", kind.c, "published", "ASABE D497, two transcriptions")
    each = sheet.write(
        "draft.width", one_m if kind.per == "m" else 1.0, "derived", f"D497 counts per {kind.per}"
    )
    draft("draft.factor_medium", kind.medium, "published", kind.factors)
    draft("draft.factor_coarse", kind.coarse, "published", kind.factors)
    draft("draft.vertical_ratio", kind.vertical_ratio, "assumed", "0.1 to 0.25 of the draft")
    draft("draft.side_ratio", kind.side_ratio, "assumed", "of mould-boards 0.2 to 0.3, else none")
    draft("draft.force_depth_ratio", 0.6667, "assumed", "two thirds of the depth")
    middle_m = 0.5 * (depths[0] + depths[1])
    force_n = (a + 5.5 * b + 5.5**2 * c) * each * 100.0 * middle_m
    sheet.write(
        "soil_stiffness_npm", force_n / FAILS_M, "assumed", "draft of one body over 11 mm of way"
    )
    wheel = "gauge_wheel."
    share = mass_kg / 1470.0
    sheet.take(wheel + "radius_m", 0.30 if mass_kg > 500 else 0.22, "assumed", "usual")
    sheet.take(wheel + "x_m", -max(0.3, 0.9 * length_m), "assumed", "0.9 of the length")
    sheet.take(wheel + "stiffness_npm", max(20e3, 120e3 * share), "assumed", "82 N/m a kg")
    sheet.take(wheel + "damping_nspm", max(600.0, 4000.0 * share), "assumed", "2.7 N s/m a kg")
    sheet.take(wheel + "resistance_ratio", 0.10, "assumed", "a small wheel on stubble")
    sheet.write("cg_x_m", -0.40 * length_m - 0.1, "assumed", "0.4 of the length")
    sheet.write("sole_m", -clearance_m, "derived", "below the hitch points")
    return Derived(sheet.numbers)

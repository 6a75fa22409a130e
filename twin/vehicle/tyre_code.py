"""Sizes of an agricultural tyre from the code on its wall."""

from __future__ import annotations

import re
from dataclasses import dataclass

from twin.errors import BadInput

INCH_M = 0.0254
INCHES = re.compile(
    r"(?P<width>\d{1,2}(?:\.\d{1,2})?)\s*(?P<build>R|-|x|X)\s*(?P<rim>\d{2}(?:\.5)?)(?:\s.*)?$"
)
METRIC = re.compile(
    r"(?P<width>\d{3,4})/(?P<aspect>\d{2,3})\s*(?P<build>R|-|B)\s*(?P<rim>\d{2}(?:\.5)?)(?:\s.*)?$"
)
PROFILE = 0.85
"""Section height over width of sizes like 18.4-38, from the diameters of 18.4-38 (1.755 m) and
14.9-26 (1.31 m)."""
FULL_PROFILE = 1.05
"""The same for sizes with two decimals, from the diameters of 6.00-16 (0.735 m) and 7.50-16
(0.805 m)."""
EXAMPLES = "a code as 18.4-38, 18.4R38, 480/70R34 or IF 600/70R30"


@dataclass(frozen=True)
class TyreSize:
    """Sizes of a tyre by its code."""

    width_m: float
    """Section width."""
    diameter_m: float
    """Outer diameter, not loaded."""
    rim_m: float
    """Diameter of the rim."""
    radial: bool
    low_pressure: str
    """"", IF or VF: the class of allowed deflection."""
    aspect: str
    """How the section height is computed, for the source of derived numbers."""


def tyre_size(code: str, path: str = "tyre") -> TyreSize:
    """Sizes of a tyre by its code, as 18.4R38 or 480/70R34.

        diameter = rim + 2 aspect width

    A metric code states its aspect; for a code in inches it is 0.85, or 1.05 if its width has two
    decimals. `path` is the field for the message.

    Raises:
        BadInput: the code cannot be read, or no tyre has such sizes.
    """
    text = code.strip()
    prefix = next((p for p in ("IF", "VF") if text.upper().startswith(p)), "")
    rest = text[len(prefix) :].strip()
    if found := METRIC.match(rest):
        width_m, aspect = 1e-3 * float(found["width"]), 0.01 * float(found["aspect"])
        said = f"aspect {aspect:g} of the code"
    elif found := INCHES.match(rest):
        width_m = INCH_M * float(found["width"])
        full = len(found["width"].partition(".")[2]) == 2
        aspect = FULL_PROFILE if full else PROFILE
        said = f"section height {aspect:g} of the width"
    else:
        raise BadInput(f"{path} = '{code}' is no tyre size; {EXAMPLES} would do")
    rim_m = INCH_M * float(found["rim"])
    if not (0.05 <= width_m <= 1.3 and 0.2 <= rim_m <= 1.4 and 0.3 <= aspect <= 1.1):
        raise BadInput(
            f"{path} = '{code}' reads {width_m:.3g} m wide on a rim of {rim_m:.3g} m, which no "
            f"tractor tyre is; {EXAMPLES} would do"
        )
    return TyreSize(
        width_m, rim_m + 2.0 * aspect * width_m, rim_m, found["build"] == "R", prefix, said
    )

"""Kinds of implements: coefficients of ASABE D497's draft, and defaults for the implement's file.

Draft D = F (A + B S + C S**2) W T, with the soil factor F, the speed S in km/h and the depth T in
cm; W is the width in m or the number of tools.
"""

from __future__ import annotations

from dataclasses import dataclass

D497 = "ASABE D497, through two transcriptions of its table"


@dataclass(frozen=True, kw_only=True)
class Kind:
    """One kind of implement; a, b and c are A, B and C of D497."""

    about: str
    a: float
    b: float
    c: float
    per: str
    """What W counts: `m` of width or `tool`."""
    medium: float
    """F on medium soil; on fine soil it is 1."""
    coarse: float
    """F on coarse soil."""
    factors: str
    """Source of a, b, c, medium and coarse."""
    vertical_ratio: float
    """Downward force over draft; assumed for all kinds but the plough."""
    side_ratio: float
    furrow: bool
    """Whether the wheels of one side run in the last furrow."""
    depth_m: tuple[float, float]
    """Least and greatest working depth, where a file gives none."""
    rows: int
    """Bars of tools."""
    spacing_m: float
    """Distance between two bars, or two plough bodies, along the tractor."""
    narrowest_m: float
    """Least width of one body or tool."""
    widest_m: float
    most: int
    """Bodies or tools, at most."""


KINDS = {
    "mouldboard": Kind(
        about="mould-board plough", a=652.0, b=0.0, c=5.1, per="m", medium=0.70, coarse=0.45,
        factors=D497, vertical_ratio=0.20, side_ratio=0.25, furrow=True, depth_m=(0.05, 0.35),
        rows=1, spacing_m=0.85, narrowest_m=0.15, widest_m=0.6, most=6,
    ),
    "subsoiler": Kind(
        about="subsoiler", a=226.0, b=0.0, c=1.8, per="tool", medium=0.70, coarse=0.45,
        factors=D497, vertical_ratio=0.20, side_ratio=0.0, furrow=False, depth_m=(0.20, 0.50),
        rows=1, spacing_m=0.60, narrowest_m=0.3, widest_m=1.2, most=16,
    ),
    "chisel": Kind(
        about="chisel plough", a=91.0, b=5.4, c=0.0, per="tool", medium=0.85, coarse=0.65,
        factors=D497 + "; F from memory", vertical_ratio=0.15, side_ratio=0.0, furrow=False,
        depth_m=(0.08, 0.35), rows=3, spacing_m=0.60, narrowest_m=0.15, widest_m=0.6, most=16,
    ),
    "sweep": Kind(
        about="sweep plough", a=390.0, b=19.0, c=0.0, per="m", medium=0.85, coarse=0.65,
        factors=D497 + "; F from memory", vertical_ratio=0.15, side_ratio=0.0, furrow=False,
        depth_m=(0.05, 0.20), rows=2, spacing_m=0.60, narrowest_m=0.3, widest_m=2.5, most=16,
    ),
    "cultivator": Kind(
        about="field cultivator", a=46.0, b=2.8, c=0.0, per="tool", medium=0.85, coarse=0.65,
        factors=D497, vertical_ratio=0.10, side_ratio=0.0, furrow=False, depth_m=(0.03, 0.15),
        rows=4, spacing_m=0.45, narrowest_m=0.08, widest_m=0.5, most=16,
    ),
}  # fmt: skip
"""Kinds by name, the value of `kind` in a file."""

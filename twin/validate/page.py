"""VALIDATION.md: every check in a table, its verdict, and what is not validated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from twin.io.result_rows import Row
from twin.validate.check import GRADES, Check
from twin.validate.suite import LAYERS

HEAD = (
    "#", "test", "quantity", "ours", "reference", "tolerance, and why", "source", "grade", "verdict"
)  # fmt: skip

INTRODUCTION = """\
# Validation

Written by `twin validate --out VALIDATION.md`, which reruns every row on this page. Every row is a
figure of the twin beside its reference, with the tolerance and the reason for it. The exit status
of the command is 1 while a row fails; a row that fails stays here, with what is known of the
reason. The figures in the tables are rerun; those in the notes under them were tried once, by hand.
Where a tolerance was changed after a first result, the note says so. A figure without a unit is a
ratio.

The machine is the Taishan 1404A, with a plough where it ploughs, unless a row names another one.
PTO is the power take-off. "From memory" means that nobody compared the number with the print.

The grade is that of the *reference*:
"""

NOT_VALIDATED = """\
## What is not validated

* **Slip in the field.** No paper or log at hand gives a tractor's slip together with its draft,
  depth and soil. The published ploughing runs give four speeds; slip under them is determined only
  to about a third of itself. The twin's slip is one consistent set, not a measured one.
* **Draft.** D497's coefficients A and C are from memory, not seen in print; their own range is
  40 %. The soil's draft scale was chosen so that the four speeds come out.
* **Tyre and soil together.** No single-wheel measurement of these tyres on a known soil was
  obtainable. Field data scatter about Brixius' law by 0.05 to 0.08 in net traction, from memory;
  the twin follows the law, not the field. The fields' numbers for Bekker-Wong's law are fitted to
  Brixius.
* **Lateral forces.** Lateral stiffness, relaxation lengths and the side force of Bekker's law rest
  on figures of the literature, from memory. On soft soil the two laws differ by more than 30 % in
  side force.
* **Side force under drive slip.** The one open measurement is a rigid wheel of 58 mm radius in dry
  sand, sunk by a quarter to a half of its radius; at a slip angle of 15 degrees it keeps .77, .60
  and .40 of its side force where the rim is 1.3, 2 and 4 times as fast as the path. On the tilled
  field the rear tyre keeps .62, .25 and .09 under Brixius' law and .66, .32 and .16 under Bekker's.
  Brixius leaves out the soil pushed aside by a sunk wheel and slip sinkage: its side force is a
  share of the shear, which drive slip takes away. Bekker-Wong has both, as published (Rankine,
  Lyasko), and leaves out lugs, the soil heaped up before and beside the wheel, and what a wheel
  pushes ahead. Whether a tractor's tyre, sunk by a few per cent, has them in that measure is open:
  no constant of a tractor was fitted to the small wheel, and Lyasko's constant is taken as 1 on
  every soil.
* **Asphalt, gravel, grass and the light electric tractor's wheels** lie outside the range of
  Brixius' data: their numbers are assumed.
* **Rolling over rough ground.** Tyre damping, the spectrum's class and the tractor's pitch and
  bounce were not compared with a measurement. Tyres touch the ground at one point and
  filter nothing; in return the ground has no waves shorter than 0.8 m.
* **Headlands.** The tractor turns and the plough is lifted and turned over; soil thrown, ends of
  furrows and the time a driver takes were not compared with a field.
* **Plough.** Its side and vertical forces, the landside's friction, the depth wheel and the furrow
  wall are partitions and assumptions; the total alone follows a published law.
* **Hitch and driver.** Control of the hitch, steering and depth corrections are plausible, not
  identified from a machine. The gains of draft control, the front ballast it needs and the top
  link's holes are assumed; how far a draft varies under it was compared with no measurement.
* **Engine and brakes.** Governor droop and full-load torque are fitted or assumed; inertia was not
  compared with a test. The drag of the motored engine is a published law, from memory,
  for a displacement and stroke that are assumed; brakes, and how the driver presses them, are
  assumed. He has one gear for a run and does not shift down.
* **Fuel.** The law is a mean of many tractors, in power and speed of the engine; the rows
  compare it with tests of three other tractors and with ploughing elsewhere. PTO power over crank
  power is assumed. Engine speeds below half of the rated one are outside the law, and an idling
  engine takes less than it says.
* **Repeated passes.** Ruts and compaction under earlier wheels are not simulated. Brixius' law
  knows no sinkage, and slip sinkage only as the part of its motion resistance that grows with slip.
* **Weather, moisture, residue** have no model: a soil is a set of constants with random variation.
* **Sensors** are checked against data sheets, a receiver at rest against one real receiver. The
  correlation of their errors with the machine's vibration, multipath under trees and the true
  receivers' filters in motion were not compared with logs.
* **The catalogue's machines** rest on data sheets as far as they were at hand. Their tyres, tracks,
  ballast and the lead of the front axle are mostly assumed; the transmission's efficiency, .87,
  was chosen with the Nebraska tests in view. Of the implements only ASABE D497's numbers are
  published; a chisel plough, a subsoiler and a cultivator were compared with no measurement.
* **Taishan 1404A** itself: its tyres, gears, centre of gravity and ballast were not found; those
  of a tractor of its class replace them. No row on this page is a measurement of that machine but
  its mass, its power and four speeds.
"""


def text(checks: Mapping[str, Sequence[Check]], *, quick: bool = False) -> str:
    """VALIDATION.md: a section for each layer of checks, A to G, its rows numbered A1, A2, ...

    Args:
        checks: the rows of each layer.
        quick: say that each field run had one seed.
    """
    parts = [INTRODUCTION, "\n".join(f"* {name}: {about}." for name, about in GRADES.items())]
    parts += ["", _summary(checks)]
    if quick:
        parts += ["", "**Quick run: one seed of each field run; scatter fails rows as well.**"]
    for letter, (layer, title) in zip("ABCDEFG", LAYERS.items(), strict=True):
        parts += ["", f"## {letter}. {title}", "", _table(letter, checks[layer])]
        parts += _notes(letter, checks[layer])
    return "\n".join([*parts, "", NOT_VALIDATED])


def _summary(checks: Mapping[str, Sequence[Check]]) -> str:
    found = [c for of_layer in checks.values() for c in of_layer]
    failed, reported = sum(not c.passed for c in found), sum(not c.gated for c in found)
    grades = ", ".join(f"{sum(c.basis.grade == g for c in found)} {g}" for g in GRADES)
    passed = len(found) - failed - reported
    return (
        f"{len(found)} rows: {passed} pass, {failed} fail, {reported} are reported without a "
        f"tolerance. By grade: {grades}."
    )


def _table(letter: str, checks: Sequence[Check]) -> str:
    lines = ["| " + " | ".join(HEAD) + " |", "|" + "---|" * len(HEAD)]
    for number, check in enumerate(checks, 1):
        cells = [f"{letter}{number}", *cells_of(check)]
        lines.append("| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |")
    return "\n".join(lines)


def cells_of(check: Check) -> list[str]:
    """What the table says of a check after its number."""
    row = check.row
    unit = "" if row["unit"] == "1" else f" {row['unit']}"
    reference = row.get("published", row.get("reference"))
    return [
        row["case"],
        row["quantity"],
        _figure(row["ours"]) + unit,
        "-" if reference is None else _figure(reference) + unit,
        f"{_bounds(row)}: {check.basis.why}" if check.gated else check.basis.why,
        check.basis.source,
        check.basis.grade,
        ("pass" if check.passed else "**FAIL**") if check.gated else "reported",
    ]


def _bounds(row: Row) -> str:
    low, high = row.get("low"), row.get("high")
    if low is not None and high is not None:
        return f"{_figure(low)} to {_figure(high)}"
    return f"at most {_figure(high)}" if high is not None else f"at least {_figure(row['low'])}"


def _figure(value: float) -> str:
    """Four digits; what is smaller than a millionth of a millionth is nothing."""
    return "0" if abs(value) < 1e-12 else f"{value:.4g}"


def _notes(letter: str, checks: Sequence[Check]) -> list[str]:
    """Each note once, after the rows it belongs to."""
    rows_of: dict[str, list[str]] = {}
    for number, check in enumerate(checks, 1):
        if check.basis.note:
            rows_of.setdefault(check.basis.note, []).append(f"{letter}{number}")
    lines = [f"* {', '.join(rows)}: {note}." for note, rows in rows_of.items()]
    return ["", *lines] if lines else []

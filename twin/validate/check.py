"""One check: a row of figures, and the words that say where its reference comes from."""

from __future__ import annotations

from dataclasses import dataclass

from twin.io.result_rows import Row, row

GRADES = {
    "measured": "the reference was measured on a real machine, tyre or instrument",
    "published": "the reference is a law, data sheet or figure in print",
    "derived": "the reference follows from mechanics, or from the twin's own numbers: it tests the "
    "code and says nothing of the world",
    "assumed": "the reference or its band rests on an assumption that is stated",
}


@dataclass(frozen=True, kw_only=True)
class Basis:
    """What a reference and its tolerance rest on."""

    source: str
    """Where the reference comes from."""
    why: str
    """Why the tolerance is what it is."""
    grade: str
    """One of GRADES."""
    note: str = ""
    """What has to be said of the row, an explanation where it fails."""

    def __post_init__(self) -> None:
        if self.grade not in GRADES:
            raise ValueError(f"grade = {self.grade} is none of {', '.join(GRADES)}")


@dataclass(frozen=True, kw_only=True)
class Check:
    """One row of the page."""

    row: Row
    """As `twin.io.result_rows` writes it."""
    basis: Basis

    @property
    def name(self) -> tuple[str, str]:
        """What identifies the row: case and quantity."""
        return self.row["case"], self.row["quantity"]

    @property
    def passed(self) -> bool:
        """Whether it stands within its tolerance; what is only reported does."""
        return bool(self.row.get("passed", True))

    @property
    def gated(self) -> bool:
        """Whether it has a tolerance."""
        return "passed" in self.row


def near(
    case: str,
    quantity: str,
    ours: float,
    unit: str,
    reference: float,
    *,
    basis: Basis,
    relative: float = 0.0,
    absolute: float = 0.0,
) -> Check:
    """A figure that must come within a tolerance of its reference: relative, plus absolute."""
    margin = relative * abs(reference) + absolute
    low, high = float(reference) - margin, float(reference) + margin
    made = row(case, quantity, float(ours), unit, reference=float(reference), low=low, high=high)
    return Check(row=made, basis=basis)


def within(
    case: str,
    quantity: str,
    ours: float,
    unit: str,
    *,
    basis: Basis,
    low: float | None = None,
    high: float | None = None,
    reference: float | None = None,
) -> Check:
    """A figure that must lie in a band."""
    made = row(case, quantity, float(ours), unit, low=low, high=high, reference=reference)
    return Check(row=made, basis=basis)

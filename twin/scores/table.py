"""Scores as rows of text, for the terminal and for the report."""

from __future__ import annotations

from collections.abc import Mapping

from twin.io.plain import Plain

COVERAGE = "within ±2 sd [%]"
"""What the share of errors within two reported standard deviations is called everywhere."""
RANKS = {
    "estimator": 0, "slip RMSE [%]": 0, "MAE [%]": 6, "max [%]": 5, "bias [%]": 2, COVERAGE: 1,
    "angle RMSE [°]": 0, "sideslip [m]": 3, "true sideslip [m]": 4,
    "sideslip error [%]": 2,
}  # fmt: skip
"""Heading -> its rank: the greatest is left out first where there is no room, 0 never.

The first column names the estimator; the rest is slip, then sideslip.
"""
HEADERS = tuple(RANKS)
HIDDEN_RANKS = {
    "estimator": 0, "hidden [s]": 0, "times": 3, "speed RMS [m/s]": 0, "slip RMS [%]": 1,
    COVERAGE: 1,
}  # fmt: skip
"""The same of the table of what is foretold while GNSS is hidden."""

_DEG = 57.29577951308232


def score_rows(scores: Mapping[str, Plain]) -> list[list[str]]:
    """One row of text per estimator, in the order of HEADERS; a dash where nothing is known.

    Below them stand the causal and the offline bound (`estimators.bounds`).
    """
    rows = [_row(name, entry) for name, entry in scores.get("estimators", {}).items() if entry]
    bound = scores.get("bound") or {}
    for when in ("causal", "offline"):
        if (slip := bound.get(f"slip_{when}")) is not None:
            angle = {"rmse": bound.get(f"sideslip_{when}_rad")}
            entry = {"slip": {"rmse": slip}, "sideslip_angle_rad": angle}
            rows.append(_row(f"bound, {when}", entry))
    return rows


def zero_line(scores: Mapping[str, Plain]) -> str | None:
    """Where the slip of a run or a log is zero, as a line of text; None where there is no slip."""
    from twin.streams import ZERO_SLIPS  # late: this module answers wrong commands at once

    name = scores.get("zero_slip")
    return None if name is None else f"slip is zero at: {ZERO_SLIPS.get(name, name)}"


def hidden_rows(scores: Mapping[str, Plain]) -> list[list[str]]:
    """One row of text per hidden time and estimator, in the order of HIDDEN_RANKS."""
    return [
        [
            each["estimator"],
            f"{each['hidden_s']:g}",
            str(each["n"]),
            _text(each["speed_rms_mps"], 1.0, 3),
            _text(each["slip_rms"], 100.0, 2),
            _text(each["in_2sd"], 100.0, 1),
        ]
        for each in scores.get("hidden", [])
    ]


def end_lines(scores: Mapping[str, Plain]) -> list[str]:
    """Text lines on how a run ended, its outcome in capitals; empty if it ended as planned."""
    end, lines = scores.get("end"), []
    if end is not None and not end["as_planned"]:
        outcome, ended = end["outcome"], str(scores["ended"])
        lines.append(ended.replace(outcome, outcome.upper(), 1))
    if scores.get("unscored") is not None:
        lines.append(f"not scored: {scores['unscored']}")
    return lines


def _row(name: str, entry: Mapping[str, Plain]) -> list[str]:
    slip = entry.get("slip", {})
    angle = entry.get("sideslip_angle_rad", {})
    total = entry.get("sideslip_m", {})
    return [
        name,
        _text(slip.get("rmse"), 100.0, 3),
        _text(slip.get("mae"), 100.0, 3),
        _text(slip.get("max"), 100.0, 2),
        _text(slip.get("bias"), 100.0, 3, sign=True),
        _text(slip.get("coverage_2sd"), 100.0, 1),
        _text(angle.get("rmse"), _DEG, 3),
        _text(total.get("est_m"), 1.0, 3),
        _text(total.get("true_m"), 1.0, 3),
        _text(total.get("rel_err"), 100.0, 1),
    ]


def _text(value: float | None, scale: float, digits: int, *, sign: bool = False) -> str:
    if value is None:
        return "-"
    return f"{scale * value:{'+' if sign else ''}.{digits}f}"

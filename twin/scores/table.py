"""Scores as rows of text, for the terminal and for the report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

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
"""The same for the table of speeds predicted while GNSS is hidden."""
HIDDEN_PHASE_RANKS = {
    "estimator": 0, "hidden [s]": 0, "phase": 0, "times": 3, "speed RMS [m/s]": 0,
    "slip RMS [%]": 1, COVERAGE: 1,
}  # fmt: skip
"""The same of that table by phase."""

PHASE_RANKS = {
    "estimator": 0, "phase": 0, "samples": 3, "slip RMSE [%]": 0, "bias [%]": 2, COVERAGE: 1,
    "angle RMSE [°]": 1,
}  # fmt: skip
"""The same of the table of scores by phase."""

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


def phase_rows(scores: Mapping[str, Plain]) -> list[list[str]]:
    """One row of text per estimator and phase, in the order of PHASE_RANKS.

    None where a single phase was driven: its scores are those of the whole.
    """
    of = {n: (e or {}).get("phases") or {} for n, e in scores.get("estimators", {}).items()}
    if len({phase for phases in of.values() for phase in phases}) < 2:
        return []
    rows = []
    for name, phases in of.items():
        for phase, entry in phases.items():
            slip, angle = entry.get("slip", {}), entry.get("sideslip_angle_rad", {})
            rows.append(
                [
                    name,
                    phase,
                    str(slip.get("n", angle.get("n", 0))),
                    _text(slip.get("rmse"), 100.0, 3),
                    _text(slip.get("bias"), 100.0, 3, sign=True),
                    _text(slip.get("coverage_2sd"), 100.0, 1),
                    _text(angle.get("rmse"), _DEG, 3),
                ]
            )
    return rows


def left_out_lines(scores: Mapping[str, Plain]) -> list[str]:
    """How many slips are not in the scores, and why; empty where all are."""
    counts: dict[str, dict[str, str]] = {"n_slow": {}, "n_nan": {}}
    for name, entry in scores.get("estimators", {}).items():
        slip = (entry or {}).get("slip") or {}
        of = slip.get("n", 0) + slip.get("n_nan", 0) + slip.get("n_slow", 0)
        for key, told in counts.items():
            if slip.get(key):
                told[name] = f"{slip[key]} of {of}"
    why = {
        "n_slow": f"ground and wheels are slower than {scores.get('driving_mps', 0.0):g} m/s",
        "n_nan": "the estimate or the truth has no value",
    }
    return [f"slips left out where {why[k]}: {_listed(told)}" for k, told in counts.items() if told]


def _listed(told: Mapping[str, str]) -> str:
    """Each count once, with the estimators that have it: mostly it is the same for all."""
    names: dict[str, list[str]] = {}
    for name, count in told.items():
        names.setdefault(count, []).append(name)
    said = [
        f"{count} ({', '.join(who) if len(who) <= 3 else f'{len(who)} estimators'})"
        for count, who in names.items()
    ]
    return ", ".join(said)


def zero_line(scores: Mapping[str, Plain]) -> str | None:
    """Where the slip of a run or a log is zero, as a line of text; None where there is no slip."""
    from twin.streams import ZERO_SLIPS  # late: this module answers wrong commands at once

    name, ruled = scores.get("zero_slip"), scores.get("zero_slip_scale")
    if ruled:
        return (
            f"slip is zero in {ruled['n']} rows of the log where {ruled['rule']} ([zero_slip] in"
            f" the map): zero-slip scale {ruled['scale']:.4f} (95 % interval: {ruled['low']:.3f} to"
            f" {ruled['high']:.3f}); slip moves with it by as much"
        )
    if name is None or (name == "unknown" and scores.get("zero_slip_from")):
        return None
    return f"slip is zero at: {ZERO_SLIPS.get(name, name)}"


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


def hidden_phase_rows(scores: Mapping[str, Plain]) -> list[list[str]]:
    """The same by what was driven at the ends; none where a single phase was driven."""
    rows = [
        [
            each["estimator"],
            f"{each['hidden_s']:g}",
            phase,
            str(entry["n"]),
            _text(entry["speed_rms_mps"], 1.0, 3),
            _text(entry["slip_rms"], 100.0, 2),
            _text(entry["in_2sd"], 100.0, 1),
        ]
        for each in scores.get("hidden", [])
        for phase, entry in (each.get("phases") or {}).items()
    ]
    return rows if len({row[2] for row in rows}) > 1 else []


def hidden_notes(scores: Mapping[str, Plain]) -> list[str]:
    """What a dash in the rows of `hidden_rows` means, and which estimators ran away."""
    rows = [each for each in scores.get("hidden", []) if each["n"]]
    silent = {each["estimator"]: 0 for each in rows if each["speed_rms_mps"] is None}
    notes = []
    if silent:
        notes.append(
            f"a dash: {', '.join(silent)} gives nothing without GNSS, at the end of at least one"
            " hidden time"
        )
    if any(each["slip_rms"] is not None and each["in_2sd"] is None for each in rows):
        notes.append(f"a dash under {COVERAGE} alone: the estimator states no slip_sd")
    driven_mps = _driven_mps((scores.get("drive") or {}).get("shares") or ())
    away = {
        each["estimator"]: 0
        for each in rows
        if driven_mps is not None and (each["speed_rms_mps"] or 0.0) > driven_mps
    }
    if away:
        notes.append(
            f"{', '.join(away)}: a speed RMS above the log's own mean speed while driving,"
            f" {driven_mps:.2f} m/s, means that the estimator ran away without GNSS"
        )
    return notes


def _driven_mps(shares: Sequence[Mapping[str, Plain]]) -> float | None:
    """Mean speed of all activities but standing; None where it is unknown."""
    driven = [s for s in shares if s["activity"] not in ("standing", "all") and s["distance_m"]]
    time_s = sum(float(share["time_s"]) for share in driven)
    return sum(float(share["distance_m"]) for share in driven) / time_s if time_s else None


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

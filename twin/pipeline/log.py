"""Estimators on a recorded drive, and the statistics of the estimated slip."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from twin import logs
from twin.io import run_folder
from twin.io.plain import Plain
from twin.logs import Log, Reader
from twin.logs.protocol_parts import Part
from twin.pipeline import drive, log_check, protocol, tuned
from twin.pipeline.drive import spread
from twin.pipeline.estimating import Estimator, all_estimates
from twin.pipeline.hidden import hidden_scores
from twin.pipeline.log_check import SteadySlip
from twin.pipeline.result import Result
from twin.plugins.percent import MOVING_MPS, percent_note
from twin.scores import scores
from twin.scores.log_table import protocol_spans_ns
from twin.streams import Table


def estimate(
    paths: Path | Sequence[Path],
    column_map: Path | None,
    *,
    estimators: Mapping[str, Estimator],
    reader: Reader | None = None,
    strict: bool = False,
    offset_s: Mapping[str, float] | None = None,
    hide_s: Sequence[float] = (),
    tuning: Path | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Result:
    """Read a log and run the estimators on it.

    Args:
        paths: the log, or the files it is in.
        column_map: TOML that says which column is what; None where the format says it.
        estimators: by name.
        reader: what reads the log; None finds out by what is in it.
        strict: refuse a log with a single bad row.
        offset_s: file name -> how far its clock is ahead of the first file's [s].
        hide_s: times for which GNSS is hidden to score the predicted speed [s]; empty for none.
        tuning: file of `twin tune` with other noises for some of them.
        progress: called as progress(done, total) with numbers of estimators.

    Raises:
        BadInput: the log or the map cannot be used; says which value, and what would do.
    """
    start = time.perf_counter()
    changed: list[str] = []
    if tuning is not None:
        estimators, changed = tuned.applied(estimators, tuned.read(tuning), tuning)
    files = [paths] if isinstance(paths, Path) else list(paths)
    read = logs.read(files, column_map, reader, strict=strict, offset_s=offset_s)
    log, steady, beside = prepared(read)
    done = all_estimates(estimators, log.setup, log.streams, progress)
    hidden = {"hidden": hidden_scores(log, estimators, hide_s)} if hide_s else {}
    known = reference(log, files[0]) or {}
    found = findings(log, done.tables, steady, protocol_spans_ns(beside))
    noted = slip_warnings(log, done.tables, found.get("work_slip"))
    odd = percent_note("slip of the reference", known, log.streams)
    return Result(
        scenario=None,
        setup=log.setup,
        streams=log.streams,
        truth=known,
        estimates=done.tables,
        wall_s=time.perf_counter() - start,
        notes=(*changed, *log.notes, *done.notes, *([odd] if odd else []), *noted),
        failed=done.failed,
        name=files[0].resolve().stem,
        found=beside | hidden | found,
    )


LARGE_SLIP = 0.25
"""Median slip that no work in a field has; most often a unit or a radius is wrong."""


def slip_warnings(
    log: Log, estimates: Mapping[str, Table], work_slip: Mapping[str, Plain] | None = None
) -> list[str]:
    """Warnings: one per estimator whose median |slip| exceeds LARGE_SLIP or that has no slip.

    The median is taken while driving and at work. If an estimator gives no slip while driving, the
    median of all rows is taken.
    """
    notes = []
    for name, table in estimates.items():
        driving, work = slip_summary(table), (work_slip or {}).get(name) or {}
        rows = "while driving" if driving["n"] else "of all rows"
        slip = np.asarray(table.get("slip", np.empty(0)), np.float64)
        median = driving["median"] if driving["n"] else spread(slip)["median"]
        of_rows = {rows: median, "at work": work.get("median")}
        large = [f"{100 * m:+.1f} % {which}" for which, m in of_rows.items()
                 if m is not None and abs(m) > LARGE_SLIP]  # fmt: skip
        if large:
            notes.append(
                f"{name}: median slip {', '.join(large)} is beyond {100 * LARGE_SLIP:.0f} %: are "
                "the units, the radius and the columns right?"
            )
        if "slip" not in table:
            notes.append(f"{name}: no slip estimated")
        elif not driving["n"] and len(log.streams):
            notes.append(f"{name}: no slip while driving: {_why_none(log, table)}")
    return notes


def _why_none(log: Log, estimates: Table) -> str:
    """What kept an estimator from saying anything."""
    ground, wheel = logs.paired_speeds(log.streams)
    if "gnss" not in log.streams or not np.isfinite(logs.ground_speed_mps(log.streams)).any():
        return "the log has no ground speed"
    if "wheels" not in log.streams:
        return "the log has no wheel speed"
    if len(wheel) and not np.isfinite(ground).any():
        return "no ground speed is known at the times of the wheels; do the clocks agree?"
    fastest = float(np.nanmax(logs.ground_speed_mps(log.streams)))
    if fastest <= MOVING_MPS:
        return f"the fastest ground speed is {fastest:.2f} m/s"
    if not np.isfinite(np.asarray(estimates["slip"], np.float64)).any():
        return "its slip is NaN throughout"
    own = np.abs(np.asarray(estimates["speed_mps"], np.float64))
    if not np.isfinite(own).any():
        return "its speed is NaN throughout"
    return (
        f"its estimated speed stays at {np.nanmax(own):.2f} m/s, or is unknown where its slip is"
        f" known, while GNSS reaches {fastest:.2f} m/s; check gnss.heading and heading_mount_rad in"
        " [setup.gnss], along which the speed is taken"
    )


def findings(
    log: Log,
    estimates: Mapping[str, Table],
    steady: SteadySlip | None,
    no_work_ns: Sequence[tuple[int, int]] = (),
) -> dict[str, Plain]:
    """Slip statistics of each estimator while driving and, with a rule [steady], in steady work."""
    found: dict[str, Plain] = {"slip": {n: slip_summary(t) for n, t in estimates.items()}}
    found |= drive.findings(log.streams, estimates, log.implement, no_work_ns)
    if steady is None:
        return found
    found["steady_slip"] = {n: steady_summary(log, t) for n, t in estimates.items()}
    found["steady"] = {
        "slip_median": steady.median, "slip_low": steady.low, "slip_high": steady.high,
        "n": steady.n, "rule": steady.rule, "scale": steady.scale.scale,
        "scale_low": steady.scale.low, "scale_high": steady.scale.high,
        "scale_n": steady.scale.n, "scale_rule": steady.scale.rule,
        "lag_s": float(steady.lag_s) if np.isfinite(steady.lag_s) else None,
    }  # fmt: skip
    return found


def slip_summary(estimates: Table) -> dict[str, float | int | None]:
    """Median, 5 % and 95 % quantile of the estimated slip [-] at speeds above 0.5 m/s."""
    if "slip" not in estimates:
        return spread(np.empty(0))
    slip = np.asarray(estimates["slip"], np.float64)
    speed = np.asarray(estimates.get("speed_mps", np.full(len(slip), np.inf)), np.float64)
    return spread(slip[np.abs(speed) > MOVING_MPS])


def steady_summary(log: Log, estimates: Table) -> dict[str, float | int | None]:
    """Median, 5 % and 95 % quantile of the estimated slip [-] in steady work (rule of the map)."""
    _, wheel_mps = logs.paired_speeds(log.streams)
    epoch_ns = log.streams["wheels"]["epoch_ns"]
    chosen = logs.choose(log.rules["steady"], log.rows, epoch_ns, wheel_mps)
    if "slip" not in estimates or not len(estimates["epoch_ns"]):
        return spread(np.empty(0))
    return spread(scores.at(estimates, "slip", epoch_ns[chosen]))


def prepared(log: Log) -> tuple[Log, SteadySlip | None, dict[str, Plain]]:
    """Log with scaled wheel speeds, the steady slip, and the findings for scores.json.

    The scale makes the slip zero where the rule [zero_slip] of the map chooses rows. Without this
    rule the zero-pull passes of a recording protocol give the scale. The steady slip is None if the
    map lacks [zero_slip] or [steady].
    """
    log, beside = protocol.applied(log)
    if "zero_slip" not in log.rules:
        return log, None, beside | {"zero_slip_from": _zero_slip(log, beside)}
    scale = log_check.log_scale(log)
    scaled = log_check.scaled(log, scale.scale)
    steady = log_check.steady_slip(log) if "steady" in log.rules else None
    calibration = {"scale": scale.scale, "low": scale.low, "high": scale.high, "n": scale.n,
            "rule": scale.rule}  # fmt: skip
    return scaled, steady, beside | {"zero_slip_scale": calibration}


def _zero_slip(log: Log, beside: Mapping[str, Plain]) -> str:
    """What zero slip is in a log whose map has no rule for it."""
    parts = (beside.get("protocol") or {}).get("parts") or ()
    if any(part["part"] == Part.ZERO_PULL and part["used"].startswith("wheels") for part in parts):
        return "zero slip: the zero-pull passes of the recording protocol"
    ticks = log.setup.wheels is not None and log.setup.wheels.counts_per_turn is not None
    taken = "the set-up's nominal radii" if ticks else "wheel speed as logged"
    return (
        f"zero slip: {taken}; a radius that is wrong by 1 % is 1 point of slip. [zero_slip] in the "
        "map, or zero-pull passes of a recording protocol, give the scale"
    )


def reference(log: Log, path: Path) -> Table | None:
    """Reference table of the log, or the truth if `path` is a run folder; None without both."""
    truth = path / run_folder.TRUTH
    if log.reference is None and path.is_dir() and truth.exists():
        return run_folder.read_parquet(truth)
    return log.reference

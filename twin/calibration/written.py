"""The files of a calibration: machine, posterior beside it, soil, and what was found."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from twin.calibration.applied import OWN_OF_SOIL
from twin.calibration.verdicts import IDENTIFIED, Found
from twin.errors import BadInput
from twin.io import atomic, toml
from twin.io.plain import to_plain
from twin.scenario import Soil
from twin.vehicle import Machine
from twin.vehicle.reading import KEPT

if TYPE_CHECKING:
    from twin.calibration.calibrate import Calibration

Array = NDArray[np.float64]

SCHEMA = 1
SUFFIX, POSTERIOR = ".calibrated.toml", ".posterior.json"


def write(calibration: Calibration, folder: Path, source: str) -> Path:
    """Write the files into a folder, all or none; gives the machine's.

    Args:
        calibration: what was found.
        folder: made where it is not there.
        source: said of every value that was found.
    """
    name = f"{calibration.machine.name}{SUFFIX}"
    with atomic.renamed_when_complete(folder) as to:
        machine = machine_text(calibration.machine, calibration.parameters, source)
        (to / name).write_text(machine, encoding="utf-8")
        (to / f"{name}{POSTERIOR}").write_text(
            json.dumps(posterior(calibration), indent=2), encoding="utf-8"
        )
        (to / "soil.toml").write_text(soil_text(calibration.soil), encoding="utf-8")
        (to / "calibration.json").write_text(json.dumps(plain(calibration), indent=2),
                                             encoding="utf-8")  # fmt: skip
    return folder / name


def plain(calibration: Calibration) -> dict[str, object]:
    """What was found as JSON."""
    score = calibration.holdout
    kept = (
        "slip_rms", "slip_mae", "coverage", "line_rms", "constant_rms", "gain_low", "gain_high",
        "line_mae", "speed_rms_mps", "fuel_rms_lph", "rows", "blocks", "verdict",
    )  # fmt: skip
    return {
        "schema": SCHEMA,
        "parameters": [
            {key: getattr(f, key) for key in ("name", "value", "low", "high", "verdict", "unit")}
            for f in calibration.parameters
        ],
        "holdout": {key: _number(getattr(score, key)) for key in kept},
        "together": [str(each) for each in calibration.together],
        "gears": [to_plain(gear) for gear in calibration.gears],
        "gnss_lag_s": _number(calibration.lag_s),
        "notes": list(calibration.notes),
    }


def _number(value: object) -> object:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def posterior(calibration: Calibration) -> dict[str, object]:
    """Mean and covariance of the parameters' logarithms."""
    fit = calibration.fit
    return {
        "schema": SCHEMA, "names": list(fit.prior.names), "mean": fit.u.tolist(),
        "cov": fit.cov.tolist(), "transform": "log",
        "soil": {"preset": calibration.soil.preset, "law": calibration.soil.law},
    }  # fmt: skip


def machine_text(machine: Machine, found: Iterable[Found], source: str) -> str:
    """A machine as the TOML file that gives it again; what was found says its grade and source.

    Measured is only what the log has identified; the rest keeps the grade it had.
    """
    table = {k: v for k, v in _filled(to_plain(machine)).items() if k not in KEPT}
    said = {s.path: {"grade": s.grade, "source": s.source} for s in machine.sources}
    for each in found:
        grade = "measured" if each.verdict == IDENTIFIED else each.grade
        said[each.name] = {"grade": grade, "source": f"{source}: {each.verdict}"}
    for path, of in said.items():
        _say(table, path.split("."), {k: v for k, v in of.items() if v})
    return toml.text(table)


def _filled(table: dict[str, Any]) -> dict[str, Any]:
    """A table without its empty lists."""
    inner = {k: _filled(v) if isinstance(v, dict) else v for k, v in table.items()}
    return {k: v for k, v in inner.items() if v != []}


def _say(table: Mapping[str, object], path: list[str], said: Mapping[str, str]) -> None:
    """Put grade and source beside the value of a path, if the table has one there."""
    at: object = table
    for step in path[:-1]:
        at = at[int(step)] if isinstance(at, list) else at.get(step, {})  # type: ignore[attr-defined]
    if isinstance(at, dict) and at.get(path[-1]) is not None:
        at[path[-1]] = toml.Inline({"value": at[path[-1]], **said})


def soil_text(soil: Soil) -> str:
    """A soil's own values, and the options by which a run takes them."""
    own = {n: getattr(soil.resolved, n) for n in OWN_OF_SOIL}
    own = {n: v for n, v in own.items() if isinstance(v, float) and math.isfinite(v)}
    options = " ".join(f"--soil.{n.replace('_', '-')} {v:.6g}" for n, v in own.items())
    head = f"# twin run NAME --soil.preset {soil.preset} --soil.law {soil.law} {options}\n"
    return head + toml.text({"preset": soil.preset, "law": soil.law, **own})


def read_posterior(machine: Path) -> dict[str, object]:
    """The posterior beside a calibrated machine's file. Raises BadInput without a valid one."""
    file = machine.with_name(machine.name + POSTERIOR)
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
        names, mean, cov = found["names"], np.array(found["mean"]), np.array(found["cov"])
    except FileNotFoundError:
        raise BadInput(
            f"{machine} has no {file.name} beside it; twin calibrate writes both"
        ) from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{file} is no posterior of twin calibrate: {error}") from None
    if mean.shape != (len(names),) or cov.shape != (len(names),) * 2 or found["transform"] != "log":
        raise BadInput(f"{file} is no posterior: names, mean and cov do not fit together")
    return {**found, "mean": mean, "cov": cov}

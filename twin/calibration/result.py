"""What a calibration found: values, files, and the part held back."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from estimators.lag import Lag
from twin.calibration import files as written
from twin.calibration.fitting import Fit
from twin.calibration.gears import Gear
from twin.calibration.holdout import Holdout
from twin.calibration.posterior import Posterior
from twin.calibration.verdicts import Told
from twin.io.atomic import write_text
from twin.scenario import Soil
from twin.vehicle import Machine

Array = NDArray[np.float64]

SCHEMA = 1


@dataclass(frozen=True)
class Calibration:
    """What a log says of a machine and a soil."""

    name: str
    machine: Machine
    """With the values that were found."""
    soil: Soil | None
    """None where nothing was on the ground."""
    parameters: tuple[Told, ...]
    posterior: Posterior
    together: tuple[str, ...]
    gears: tuple[Gear, ...]
    lag: Lag
    fit: Fit
    channels: tuple[str, ...]
    time_s: Array
    foretold: Array
    """What the machine predicts of the rows that were fitted, (n, c)."""
    holdout: Holdout | None
    rule: str
    notes: tuple[str, ...]

    @property
    def scores(self) -> dict[str, object]:
        """What `--json` gives."""
        rows = [{k: getattr(p, k) for k in ("name", "value", "low", "high", "verdict")}
                for p in self.parameters]  # fmt: skip
        names = ("slip_rms", "slip_mae", "coverage", "line_rms", "constant_rms", "gain_low",
                 "gain_high")  # fmt: skip
        held: Mapping[str, float | None] = self.holdout.scores if self.holdout else {}
        return {"schema": SCHEMA, "parameters": rows, "holdout": {n: held.get(n) for n in names}}

    def save(self, folder: Path, stem: str, command: str = "") -> dict[str, Path]:
        """Write machine, posterior, soil, report and the rows held back; where each is."""
        from twin.calibration.page import page

        base = folder / f"{stem}.calibrated.toml"
        paths = {"machine": base, "posterior": base.with_suffix(".posterior.json"),
                 "soil": base.with_suffix(".soil.toml"), "report": base.with_suffix(".html"),
                 "holdout": base.with_suffix(".holdout.csv")}  # fmt: skip
        folder.mkdir(parents=True, exist_ok=True)
        source = f"twin calibrate {self.name}"
        texts = {
            "machine": written.machine_toml(self.machine, self.parameters, source),
            "report": page(self, command),
        }
        if self.soil is not None:
            texts["soil"] = written.soil_toml(self.soil, self.name)
        else:
            del paths["soil"]
        for what, text in texts.items():
            write_text(paths[what], text)
        self.posterior.write(paths["posterior"])
        if self.holdout is not None:
            write_text(paths["holdout"], _csv(self.holdout))
        else:
            del paths["holdout"]
        return paths


def _csv(holdout: Holdout) -> str:
    lines = ["time_s,slip,slip_low,slip_high,slip_measured,slip_line"]
    for row in zip(holdout.rows.time_s, holdout.slip, holdout.slip - 1.96 * holdout.slip_sd,
                   holdout.slip + 1.96 * holdout.slip_sd, holdout.measured, holdout.line,
                   strict=True):  # fmt: skip
        lines.append(",".join("" if not math.isfinite(v) else f"{v:.6g}" for v in row))
    return "\n".join(lines) + "\n"

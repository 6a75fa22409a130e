"""An engine speed that no engine has while it drives a tractor: most often a wrong unit."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from twin.logs.speeds import ground_speed_mps
from twin.logs.units import UNITS
from twin.streams import Streams, Table

TURNING_RPM = 300.0, 5000.0
"""At the median on the move; a diesel engine idles at 600 to 1000 and is governed below 3000."""
USUAL_RPM = 600.0, 3000.0
MOVING_MPS = 0.5
LEAST_ROWS = 10
_RPM = UNITS["angular rate"]["rpm"]


def engine_notes(tables: Mapping[str, Table]) -> list[str]:
    """A note where the engine's speed on the move cannot be, with the units that would explain it.

    The engine stands where it reads zero or nothing; these rows do not count.
    """
    engine = tables.get("machine", {}).get("engine_radps")
    gnss = tables.get("gnss", {})
    if engine is None or "v_east_mps" not in gnss:
        return []
    start = gnss["epoch_ns"][0]
    ground = ground_speed_mps(Streams(dict(tables)))
    known = np.isfinite(ground)
    if not known.any():
        return []
    at_s = (tables["machine"]["epoch_ns"] - start) * 1e-9
    speed = np.interp(at_s, (gnss["epoch_ns"][known] - start) * 1e-9, ground[known], 0.0, 0.0)
    with np.errstate(invalid="ignore"):
        running = (np.abs(speed) > MOVING_MPS) & (engine > 0.0)
    if running.sum() < LEAST_ROWS:
        return []
    rpm = float(np.median(engine[running])) / _RPM
    if TURNING_RPM[0] <= rpm <= TURNING_RPM[1]:
        return []
    hints = [
        f"{is_} taken for {as_} would make it {rpm * by_is / by_as:.0f} rpm"
        for is_, by_is in UNITS["angular rate"].items()
        for as_, by_as in UNITS["angular rate"].items()
        if is_ in ("rpm", "rad/s") and USUAL_RPM[0] <= rpm * by_is / by_as <= USUAL_RPM[1]
    ]
    hint = f" ({hints[0]})" if hints else ""
    return [
        f"machine: engine_speed is {rpm:.3g} rpm at the median on the move, and an engine turns"
        f" {USUAL_RPM[0]:.0f} to {USUAL_RPM[1]:.0f}; is its unit or its column wrong{hint}?"
    ]

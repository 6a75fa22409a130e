"""Where the work of engine and gravity goes, over scenarios drawn at random from their ranges."""

import itertools
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np

from tests.integration.test_random_scenarios import scenario
from twin.errors import TwinError
from twin.scenario import Field
from twin.simulation.build import build
from twin.simulation.guard import Diverged
from twin.simulation.simulate import simulate

DRIVEN_S = 6.0
EDGE_M, EDGE_SLOPE, CELL_M = 0.10, 0.499, 0.1
SMALL_J = 1e5
"""Where engine and gravity both do less than this, the balance closes within LEFT_J."""
LEFT_J = 1e3


@dataclass(frozen=True)
class Balance:
    """Work over a drive [J]."""

    engine_j: float
    gravity_j: float
    step_j: float
    """What powers taken at the start of each step leave over, as the run reports it."""
    missing_j: float

    @property
    def closes(self):
        """Within 1 % of the larger work, or 1 kJ where both are small.

        What the step leaves over is known, but may be 3 % of both works at most, 3 kJ where they
        are small: forces that chatter leave more.
        """
        larger = max(abs(self.engine_j), abs(self.gravity_j))
        both = abs(self.engine_j) + abs(self.gravity_j)
        known = abs(self.step_j) <= 0.03 * max(both, SMALL_J)
        return known and abs(self.missing_j) <= (0.01 * larger if larger > SMALL_J else LEFT_J)


def balance(chunks):
    """The power balance of a drive: engine less all losses less what is stored."""
    dt_s = 1e-9 * float(np.diff(chunks[0].epoch_ns[:2])[0])
    names = [n for n in chunks[0].columns if n.startswith("power_")]
    work = {n: dt_s * sum(float(c[n].sum()) for c in chunks) for n in names}
    last = {n: float(chunks[-1][n][-1]) * dt_s for n in names}  # of a step beyond the last state
    work = {n: work[n] - last[n] for n in names}
    engine = work.pop("power_engine_w")
    stored = {n: float(chunks[-1][n][-1] - chunks[0][n][0]) for n in ("kinetic_j", "potential_j")}
    missing = engine - sum(work.values()) - sum(stored.values())
    return Balance(engine, stored["potential_j"], work["power_step_w"], missing)


@cache
def edges():
    """A height map of steps 10 cm up and down, every 3 m, some of them askew."""
    s, t = np.meshgrid(np.arange(-10.0, 60.0, CELL_M), np.arange(-12.0, 12.0, CELL_M))
    run_m = EDGE_M / EDGE_SLOPE
    heights = np.zeros_like(s)
    for k in range(16):
        at = 2.0 + 3.0 * k + 0.3 * (k % 3) * t / 3.0
        rise = np.clip((s - at) / run_m, 0.0, 1.0) * EDGE_M / np.sqrt(1.0 + (0.1 * (k % 3)) ** 2)
        heights += rise if k % 2 == 0 else -rise
    path = Path(mkdtemp()) / "edges.npy"
    np.save(path, 0.95 * heights)
    return str(path)


def drawn(seed):
    """The scenario of a seed; every third drives over edges. Raises TwinError."""
    chosen = scenario(seed)
    if seed % 3 == 0:
        field = chosen.field
        own = {"roughness_class": "smooth", "height_map": edges(), "map_cell_m": CELL_M}
        chosen = replace(chosen, field=Field(
            cross_slope_deg=field.cross_slope_deg, grade_deg=field.grade_deg, **own,
        ))  # fmt: skip
    return chosen


def balance_of(seed):
    """The balance of a seed's drive, None where the scenario is refused."""
    try:
        machine = build(drawn(seed))
        return balance(list(itertools.islice(simulate(machine), round(DRIVEN_S))))
    except Diverged:
        raise
    except TwinError:
        return None

"""Many simulated logs whose truth is drawn from what is believed before them."""

from __future__ import annotations

import os

from joblib import delayed

from twin.calibration.simulated import table, told, trial
from twin.compute.parallel import many

LOGS = int(os.environ.get("TWIN_SIMULATED_LOGS", "200"))
"""How many: seven CPU seconds each."""


def test_posteriors_cover_the_truth_as_often_as_they_say() -> None:
    trials = many([delayed(trial)(seed) for seed in range(LOGS)], jobs=-1)
    print(f"\n{table(trials)}")
    rows = {t.name: t for t in told(trials)}
    short = [t.name for t in rows.values() if t.covered < t.covered_low]
    assert not short, table(trials)

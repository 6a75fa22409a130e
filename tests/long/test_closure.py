"""As tests/simulation/test_closure.py, over the scenarios that take longer."""

from joblib import Parallel, delayed

from tests.simulation.closure import balance_of, drawn

COUNT = 2000


def test_power_closes_in_every_one_of_2000_drives():
    found = Parallel(n_jobs=2)(delayed(balance_of)(seed) for seed in range(COUNT))
    driven = {seed: b for seed, b in enumerate(found) if b is not None}
    assert len(driven) > COUNT // 2
    open_ones = {seed: (b, drawn(seed)) for seed, b in driven.items() if not b.closes}
    assert not open_ones

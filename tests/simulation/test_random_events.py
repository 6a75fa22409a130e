"""Events at random: power closes, same seed same bits, and nothing that no driver could do."""

import numpy as np
import pytest

from tests.simulation.random_events import drive


@pytest.mark.slow
def test_random_events_close_and_no_driver_does_the_impossible():
    """As many as take some seconds; 500 stand in tests/long."""
    found = {seed: drive(seed) for seed in range(10)}
    driven = {seed: each for seed, each in found.items() if each is not None}
    assert len(driven) > 5
    assert not {seed: each.wrong for seed, each in driven.items() if each.wrong}
    assert not {seed: each.balance for seed, each in driven.items() if not each.balance.closes}


@pytest.mark.slow
def test_same_seed_same_bits():
    first, second = drive(1), drive(1)
    assert first is not None
    assert np.array_equal(first.last, second.last)
    assert first.balance == second.balance

"""The power balance of drives at random: slopes, edges, rough ground, stalls, every hitch mode."""

import pytest

from tests.simulation.closure import balance_of, drawn


@pytest.mark.slow
def test_power_closes_in_every_drive():
    """As many as take a few seconds; 2 000 stand in tests/long."""
    found = {seed: balance_of(seed) for seed in range(24)}
    driven = {seed: b for seed, b in found.items() if b is not None}
    assert len(driven) > 10
    open_ones = {seed: (b, drawn(seed)) for seed, b in driven.items() if not b.closes}
    assert not open_ones

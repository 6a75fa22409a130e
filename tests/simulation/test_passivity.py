"""The ground, the furrow, the plough and the driveline never give a machine energy."""

import pytest

from tests.simulation.kicks import worst


@pytest.mark.slow
def test_a_kicked_machine_never_gains_energy():
    """500 kicks stand in tests/long."""
    share, scenario = worst(range(24))
    assert share < 1e-3, scenario

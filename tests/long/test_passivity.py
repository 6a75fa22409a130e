"""As tests/simulation/test_passivity.py, with the kicks that take longer."""

from tests.simulation.kicks import worst


def test_500_kicked_machines_never_gain_energy():
    share, scenario = worst(range(1000, 1500))
    assert share < 1e-3, scenario

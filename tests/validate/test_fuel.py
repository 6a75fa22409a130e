"""What the rows of fuel measure, by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from twin.reproduce.passes import fuel_lpha
from twin.validate.fuel import half_load


def test_half_load_is_the_ratio_of_the_law_s_two_speeds():
    """1 / (1 - 32 (0.00877 - 0.0045 / 2)); the PTO power cancels."""
    (row,) = half_load()
    assert row.row["ours"] == pytest.approx(1.0 / (1.0 - 32.0 * (0.00877 - 0.00225)))
    assert row.passed


def test_fuel_of_a_hectare_is_that_of_its_length():
    """20 L/h at 1.5 m/s and 1.4 m: 0.756 ha/h; where the tractor slows, the hectare takes more."""
    machine = SimpleNamespace(numbers={"plough.bodies": 4.0, "plough.body_width_m": 0.35})
    steady = {"fuel_lph": np.full(100, 20.0), "speed_mps": np.full(100, 1.5)}
    assert fuel_lpha(machine, steady) == pytest.approx(20.0 / 0.756)
    slows = steady | {"speed_mps": np.repeat([1.5, 0.5], 50)}
    assert fuel_lpha(machine, slows) == pytest.approx(1.5 * 20.0 / 0.756)

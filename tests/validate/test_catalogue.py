"""Machines of the catalogue against what was measured of them; the rows themselves are slow."""

import pytest

from twin.validate import catalogue
from twin.validate.check import Check
from twin.validate.page import cells_of


def failed(checks):
    return [(*c.name, c.row["ours"]) for c in checks if not c.passed]


@pytest.mark.slow
def test_power_of_two_driven_wheels_is_that_of_the_published_tests():
    checks = catalogue.deere()
    assert len(checks) == 4
    assert not failed(checks)


@pytest.mark.slow
def test_the_published_pulls_of_a_large_tractor_foretell_speed_and_fuel():
    checks = catalogue.large()
    assert len(checks) == 7
    assert not failed(checks)


@pytest.mark.slow
def test_slip_of_a_ploughing_trial_follows_depth_and_speed():
    assert not failed(catalogue.yemen())


def test_a_wrong_lead_winds_up_and_the_rear_axle_pulls_most():
    checks = {c.name: c.row["ours"] for c in catalogue.korea()}
    share, rolling = (
        [v for (_, quantity), v in checks.items() if quantity.startswith(text)]
        for text in ("share", "pull")
    )
    assert share[0] > share[1] > share[2]
    assert share[0] > 0.55
    assert rolling[0] < rolling[1] < rolling[2]


def test_ballast_adds_the_net_traction_ratio():
    checks = catalogue.ballast()
    assert not failed(checks)
    assert 4.0 < checks[0].row["ours"] < 7.5


def test_a_row_without_a_tolerance_is_told_as_reported():
    row = {"case": "a", "quantity": "b", "ours": 1.0, "unit": "1"}
    check = Check(row=row, basis=catalogue.KOREA)
    assert check.passed
    assert not check.gated
    assert cells_of(check)[-1] == "reported"

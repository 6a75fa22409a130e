"""Segments of a log, their means and the covariance of these; what a soil law reads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from twin.calibration.applied import believed, reads, soil_with
from twin.calibration.by_rollouts import _read_off
from twin.calibration.evidence import evidence
from twin.calibration.fitting import fit
from twin.calibration.segments import Segment, segments
from twin.calibration.verdicts import far_notes
from twin.scenario import Soil
from twin.vehicle import files

from .test_fitting import model, prior


def rows(seed: int, seconds: int = 96, kept: float = 0.67) -> dict[str, np.ndarray]:
    """Draft that keeps two thirds of itself a second, as over 4 m."""
    rng, noise = np.random.default_rng(seed), np.zeros(seconds)
    for i in range(1, seconds):
        noise[i] = kept * noise[i - 1] + np.sqrt(1 - kept**2) * rng.standard_normal()
    return {"epoch_ns": np.arange(seconds) * 1_000_000_000, "draft_pin_n": 2e4 + 1e3 * noise}


def test_the_covariance_of_means_is_that_of_draft_that_lasts() -> None:
    segments = [Segment(slice(12 * i, 12 * i + 12), True) for i in range(8)]
    found = [evidence(rows(seed), segments) for seed in range(60)]
    away = np.array([e.measured.mean() - 2e4 for e in found])
    told = np.array([e.covariance.mean() / len(segments) for e in found])
    assert away.std() == pytest.approx(np.sqrt(told.mean()), rel=0.25)


@pytest.mark.parametrize(
    ("law", "read", "not_read"),
    [
        ("brixius", "soil.cone_index_kpa", "soil.k_phi_kn_per_m_n2"),
        ("bekker", "soil.shear_modulus_m", "soil.mobility_resistance"),
    ],
)
def test_a_soil_has_the_parameters_that_its_law_reads(law: str, read: str, not_read: str) -> None:
    soil = Soil(preset="tilled", law=law)
    assert reads(soil, read)
    assert not reads(soil, not_read)
    assert reads(soil, "soil.draft_scale")
    value, _, _ = believed(files.machine("tym_tx58"), soil, read)
    changed = soil_with(soil, {read: 1.1 * value})
    assert believed(files.machine("tym_tx58"), changed, read)[0] == pytest.approx(1.1 * value)


def test_slip_is_read_between_the_loads_and_not_beyond() -> None:
    force, ratio = np.array([3.0, 1.0, 2.0, 2.0]), np.array([0.8, 1.0, 0.9, 0.9])
    found = _read_off(force, ratio, np.array([0.0, 1.5, 9.0]))
    assert found == pytest.approx([1.0, 0.95, 0.8])
    assert np.isnan(_read_off(force[:1], ratio[:1], force)).all()


def test_what_is_improbable_before_the_log_is_said() -> None:
    usual, sure = (fit(model(0), p, starts=1) for p in (prior(0.3), prior(0.05)))
    assert far_notes(usual) == []
    assert any("mass_kg is" in note for note in far_notes(sure))
    named = replace(sure, prior=replace(sure.prior, names=("log.set_rpm",) * 3))
    assert far_notes(named) == []


def test_of_two_pieces_of_work_one_is_fitted_and_one_held_back() -> None:
    seconds = 60
    draft_n = np.where(np.arange(seconds) < 32, 0.0, 2e4)
    log = {"epoch_ns": np.arange(seconds) * 1_000_000_000, "duration_s": np.ones(seconds),
           "wheel_speed_mps": np.full(seconds, 2.0), "speed_mps": np.full(seconds, 1.9),
           "draft_pin_n": draft_n}  # fmt: skip
    work = [s for s in segments(log) if s.working]
    assert [s.held_back for s in work] == [False, True]

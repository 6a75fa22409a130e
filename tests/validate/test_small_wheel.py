"""The measured small wheel: its typed numbers, and other published sands than the row's."""

import csv
from dataclasses import replace
from pathlib import Path

import pytest

from twin.scenario import Soil
from twin.validate import small_wheel
from twin.validate.small_wheel import AHEAD, SIDEWAYS, side_force_kept

TABLE = Path(__file__).parents[2].parent / "shared/data/combined_slip_wheel.csv"
SANDS = {  # n, c [kPa], K [m]; k_phi so that the wheel sinks 15 mm at no slip
    "LETE sand": (0.793, 1.3, 0.012, 611.0),
    "Ishigami's dry sand": (1.0, 0.8, 0.020, 1680.0),
    "Iagnemma's dry sand": (1.1, 1.0, 0.025, 2720.0),
}


@pytest.mark.skipif(not TABLE.exists(), reason="the measured table is not beside the checkout")
def test_the_typed_numbers_are_those_of_the_measurement():
    with TABLE.open(encoding="utf-8") as file:
        rows = {
            (r["wheel"], int(r["slip_angle_deg"]), round(0.1 * float(r["rim_mm_s"]), 1)): r
            for r in csv.DictReader(file)
        }
    for angle, tests in {0: AHEAD, **SIDEWAYS}.items():
        for test in tests:
            for i, kind in enumerate(("smooth", "grouser")):
                seen = rows[kind, angle, test.rim_over_path]
                force = "pull_n" if angle == 0 else "lateral_n"
                typed = (test.load_n[i], test.force_n[i], test.sinkage_mm[i])
                assert typed == pytest.approx(
                    [float(seen[name]) for name in ("load_n", force, "sinkage_mm")]
                )


def test_the_rows_hold():
    assert not [c.name for c in small_wheel.small_wheel() if not c.passed]


@pytest.mark.parametrize("name", SANDS)
def test_other_published_sands_keep_as_much_of_the_side_force(name):
    n, c_kpa, shear_m, k_phi = SANDS[name]
    sand = Soil(
        law="bekker", preset="dry-sand", friction_angle_deg=29.0, unit_weight_knpm3=13.05,
        k_c_kn_per_m_n1=0.0, k_phi_kn_per_m_n2=k_phi, sinkage_exponent=n, cohesion_kpa=c_kpa,
        shear_modulus_m=shear_m,
    )  # fmt: skip
    assert small_wheel.run(sand, AHEAD[:1]).sinkage_m[0] == pytest.approx(0.015, rel=0.02)
    for ours, measured in side_force_kept(sand).values():
        assert ours == pytest.approx(measured, abs=0.12)


def test_without_slip_sinkage_it_would_hardly_sink_deeper():
    """What the wheel did at twice the path's speed: 1.6 times as deep."""
    without = replace(small_wheel.SAND, slip_sinkage=0.0)
    flat, deep = (small_wheel.run(s, AHEAD).sinkage_m for s in (without, small_wheel.SAND))
    assert flat[2] / flat[0] < 1.1
    assert deep[2] / deep[0] == pytest.approx(24.05 / 15.0, rel=0.05)

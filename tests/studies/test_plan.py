"""Which runs there are, and that a part's name tells a run from every other."""

import pytest

import twin
from twin.errors import BadInput, UnknownName
from twin.studies import plan

SWEEPS = {"track": ("medium", "rough"), "accel_bias_sd_mps2": (0.0, 0.1, 0.1)}


def test_every_combination_once_in_order():
    cases = plan(["ima-pkf", "ima-pkf-disturbed", "ima-pkf"], range(3), ["ratio", "pkf"], SWEEPS)
    assert len(cases) == 2 * 2 * 2 * 3
    keys = [(c.scenario, *(v for _, v in c.swept), c.run.seed) for c in cases]
    assert len(set(keys)) == len(keys)
    assert keys[:4] == [
        ("ima-pkf", "medium", 0.0, 0),
        ("ima-pkf", "medium", 0.0, 1),
        ("ima-pkf", "medium", 0.0, 2),
        ("ima-pkf", "medium", 0.1, 0),
    ]
    last = cases[-1].run
    assert (last.disturbance, last.track, last.accel_bias_sd_mps2) == ("lobe", "rough", 0.1)


def test_names_of_parts_tell_runs_apart_and_stay():
    def names(estimators=("ratio",), sweeps=SWEEPS, seeds=range(3)):
        return [c.part for c in plan(["ima-pkf"], seeds, list(estimators), sweeps)]

    assert len(set(names())) == len(names())
    assert names() == names()
    assert set(names()) < set(names(seeds=range(4)))
    assert not set(names()) & set(names(estimators=("ratio", "pkf")))
    assert not set(names(sweeps={})) & set(names(sweeps={"track": ("smooth",)}))
    one = {"track": ("medium",), "accel_bias_sd_mps2": (0.0,)}
    assert names(sweeps={}) == names(sweeps=one), "a sweep over the default is the same run"


def test_settings_of_an_estimator_are_a_part_of_the_name(monkeypatch):
    from tests.studies import brought

    def part():
        return plan(["ima-pkf"], [0], ["tests.studies.brought:SEEDED"], {})[0].part

    before = part()
    monkeypatch.setattr(brought, "SEEDED", brought.SCALED)
    assert part() != before


def test_what_cannot_be_run_is_refused_before_anything_is():
    with pytest.raises(UnknownName, match="estimator"):
        plan(["ima-pkf"], [0], ["ratoi"], {})
    with pytest.raises(UnknownName, match="scenario"):
        plan(["ima-pkf", "ima-pfk"], [0], ["ratio"], {})
    with pytest.raises(BadInput, match="seed cannot be swept"):
        plan(["ima-pkf"], [0], ["ratio"], {"seed": (1, 2)})
    with pytest.raises(BadInput, match="name cannot be swept"):
        plan(["ima-pkf"], [0], ["ratio"], {"name": ("a", "b")})


def test_a_comparison_with_an_estimator_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(BadInput, match="against = pkf"):
        twin.study(["ima-pkf"], ["ratio"], out=tmp_path / "study", against="pkf")
    assert not (tmp_path / "study").exists()

"""A run's folder repeats it to the bit, whatever has become of the preset that it named."""

import dataclasses
import json

import numpy as np
import pytest

from scenarios.ima_pkf import DISTURBED
from twin import cli
from twin.errors import BadInput, UnknownName
from twin.io import run_folder as runfolder
from twin.io.plain import from_plain
from twin.pipeline import named as registry
from twin.pipeline.run import run
from twin.pipeline.unread import complaint
from twin.scenario import Course, Field, Plough, Scenario, Soil
from twin.scenario.soils import PRESETS, Preset
from twin.scores import scores

COURSE = Course(approach_m=1.0, length_m=1.0)
MIXED = Field(other_share=0.5, other_length_m=2.0, other_soil=Soil(preset="soft"))
DRIVEN = {
    "brixius": Scenario(name="b", plough=Plough(), course=COURSE),
    "bekker": Scenario(name="k", soil=Soil(law="bekker", friction=0.7), course=COURSE),
    "no cone index": Scenario(name="n", soil=Soil(preset="lete-sand", law="bekker"), course=COURSE),
    "patches of another": Scenario(name="m", field=MIXED, plough=Plough(), course=COURSE),
}
EDITED = Preset(
    about="edited", cone_index_kpa=700.0, friction=0.5, front_grip=0.5, slip_rate=5.0,
    rolling_moment=0.1, mobility_resistance=2.0, strength_cv=0.2, draft_scale=0.3,
    deformable=dataclasses.replace(PRESETS["soft"].deformable, cohesion_kpa=10.0),
)  # fmt: skip


def written(done, folder):
    table = scores.score(done.truth, done.estimates, scenario=done.scenario.name, seed=0)
    return runfolder.write(done, table, folder)


def tables(done):
    return {"truth": done.truth, **done.streams.tables}


def equal(one, other):
    return all(
        np.array_equal(column, other[name][c], equal_nan=True)
        for name, table in one.items()
        for c, column in table.items()
    )


@pytest.mark.parametrize("kind", DRIVEN)
def test_an_edited_preset_changes_no_old_run(kind, tmp_path, monkeypatch):
    first = run(DRIVEN[kind], estimators={})
    folder = written(first, tmp_path / "run")
    for name in ("firm", "soft", "lete-sand"):
        monkeypatch.setitem(PRESETS, name, EDITED)
    assert not equal(tables(first), tables(run(DRIVEN[kind], estimators={}))), "nothing was edited"
    for spec in (folder, folder / "scenario.json"):
        kept = registry.load("scenario", str(spec))
        assert kept.soil == first.scenario.soil or kind == "no cone index"  # NaN is not NaN
        assert equal(tables(first), tables(run(kept, estimators={})))


def test_a_preset_that_is_gone_is_still_driven(tmp_path, monkeypatch):
    folder = written(run(DRIVEN["brixius"], estimators={}), tmp_path / "run")
    monkeypatch.delitem(PRESETS, "firm")
    assert registry.load("scenario", str(folder)).soil.resolved.cone_index_kpa == 1200.0
    with pytest.raises(UnknownName, match="firm"):
        Soil(preset="firm")


def test_another_preset_takes_the_place_of_the_kept_numbers():
    kept = DRIVEN["brixius"].with_numbers()
    soft = dataclasses.replace(kept.soil, preset="soft")
    assert soft.resolved == Soil(preset="soft").resolved
    assert soft.with_numbers().numbers.name == "soft"


def test_a_scenario_of_before_the_numbers_were_kept_is_read():
    old = {
        "name": "old",
        "soil": {"preset": "firm", "law": "bekker", "friction": None, "cohesion_kpa": None},
        "plough": None,
    }
    assert from_plain(Scenario, old) == Scenario(name="old", soil=Soil(law="bekker"))


def test_what_a_run_writes_is_not_refused_when_read(tmp_path):
    for name in registry.names("scenario"):
        scenario = registry.load("scenario", name)
        kept = scenario.with_numbers() if isinstance(scenario, Scenario) else scenario
        path = tmp_path / "scenario.json"
        path.write_text(runfolder._json(runfolder.to_plain(kept)))
        assert complaint(registry.load("scenario", str(path))) is None, name


def test_signals_are_repeated_too(tmp_path):
    first = run(DISTURBED, estimators={})
    assert registry.load("scenario", str(written(first, tmp_path / "run"))) == DISTURBED


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{", "is not JSON"),
        ("null", "holds no scenario"),
        ('{"machine": "tractor"}', "cannot be made"),
        ('{"name": "x", "machine": "taishan_1404a", "soil": {"frixion": 1}}', "frixion"),
        ('{"name": "x", "machine": "taishan_1404a", "soil": {"friction": 9}}', "soil.friction = 9"),
        (
            '{"name": "x", "machine": "taishan_1404a", "sensors": {"machine": {"power_w": 9}}}',
            "Bus has no field 'power_w'",
        ),
        (
            '{"name": "x", "machine": "taishan_1404a", "soil": {"numbers": {"about": "", '
            '"name": "firm", "cone_index_kpa": 900, "slip_rate": 1e9}}}',
            "soil.numbers.slip_rate",
        ),
    ],
)
def test_a_file_that_is_none_is_refused(text, says, tmp_path):
    path = tmp_path / "scenario.json"
    path.write_text(text)
    with pytest.raises(BadInput, match=says):
        registry.load("scenario", str(path))


def test_the_command_repeats_a_folder(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    asked = ["--estimators", "ratio", "--quiet"]
    assert cli.main(["run", "ima-pkf", *asked, "--seed", "3"]) == 0
    assert cli.main(["run", "runs/ima-pkf-seed3", *asked, "--out", "again"]) == 0
    for name in ("truth.parquet", "streams/gnss.parquet", "estimates.parquet", "scenario.json"):
        same = (tmp_path / "runs/ima-pkf-seed3" / name).read_bytes()
        assert (tmp_path / "again" / name).read_bytes() == same
    assert json.loads((tmp_path / "again/scenario.json").read_text())["seed"] == 3
    assert cli.main(["run", "runs/nowhere.json"]) == 2
    assert "runs/nowhere.json is missing" in capsys.readouterr().err

"""What would not be read is refused by name, wherever it is set; friction acts in every law."""

import dataclasses
import sys
from dataclasses import replace

import numpy as np
import pytest

from scenarios.plough import CM_25, ROCK
from twin import cli
from twin.errors import BadInput, OutOfRange
from twin.machine.parameters import soil_part
from twin.physics.block import Soil as Slot
from twin.physics.law_reads import SLOTS, fields_read
from twin.pipeline import named as registry
from twin.pipeline.run import run
from twin.pipeline.unread import LAW_READS, RULES, complaint
from twin.rig.tyre import Tyre
from twin.rig.wheel import wheel
from twin.scenario import Course, Drive, Driver, Field, Patch, Plough, Scenario, Soil
from twin.scenario.soils import LAWS, PRESETS
from twin.sensors import Fault, Gnss, Outage, Sensors, ideal
from twin.studies import left_out, plan

OWN = """
def icy(soil, wheel, load_n, slip, side_slip):
    return 0.1 * load_n * slip, 0.1 * load_n * side_slip, 0.0, 0.0, 0.0

def rubbed(soil, wheel, load_n, slip, side_slip):
    mu = soil[1] * load_n
    return mu * slip, mu * side_slip, 0.0, 0.0, 0.0
"""


@pytest.fixture
def own(tmp_path, monkeypatch):
    """A module of soil laws in the working directory."""
    (tmp_path / "own_laws.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield
    sys.modules.pop("own_laws", None)


def pull_n(soil):
    return wheel(Tyre(), soil, slip=0.2, load_n=2e4).net_pull_n[0]


@pytest.mark.parametrize("law", [*LAWS, "own_laws:rubbed"])
@pytest.mark.parametrize("preset", ["firm", "soft"])
def test_friction_acts_in_every_law(law, preset, own):
    usual = pull_n(Soil(preset=preset, law=law))
    pulls = [pull_n(Soil(preset=preset, law=law, friction=mu)) for mu in (0.3, 0.6, 0.88, 1.2)]
    assert all(np.diff(pulls) > 0.0)
    assert pulls[2] == usual, "the preset's own friction changes no bit"


@pytest.mark.parametrize("preset", [n for n, p in PRESETS.items() if p.deformable is not None])
def test_friction_scales_cohesion_and_tan_phi_together(preset):
    own = PRESETS[preset].friction
    usual, half = (
        soil_part(Soil(preset=preset, law="bekker", friction=mu)) for mu in (None, own / 2)
    )
    scaled = (Slot.FRICTION, Slot.COHESION_PA, Slot.TAN_PHI)
    assert half == {**usual, **{slot: 0.5 * usual[slot] for slot in scaled}}


def test_the_reference_of_friction_is_the_presets_own():
    """Grass has 0.65, and no numbers for Bekker's law until they are all given."""
    numbers = dataclasses.asdict(PRESETS["firm"].deformable)
    usual, same, more = (
        soil_part(Soil(preset="grass", law="bekker", friction=mu, **numbers))
        for mu in (None, 0.65, 0.88)
    )
    assert usual == same
    assert more[Slot.COHESION_PA] == pytest.approx(0.88 / 0.65 * usual[Slot.COHESION_PA])


def test_a_soil_that_friction_makes_too_cohesive_is_refused_by_name():
    with pytest.raises(OutOfRange, match=r"times 1\.7 by soil\.friction"):
        Soil(preset="soft", law="bekker", friction=1.5, cohesion_kpa=30.0)


def test_every_rule_is_of_a_field_there_is_and_is_broken_by_something():
    fields = {
        f"{s}.{f.name}" for s in ("soil", "field.other_soil") for f in dataclasses.fields(Soil)
    }
    fields |= {f"field.{f.name}" for f in dataclasses.fields(Field)}
    fields |= {f"plough.{f.name}" for f in dataclasses.fields(Plough)}
    fields |= {f"drive.{f.name}" for f in dataclasses.fields(Drive)}
    fields |= {f"course.{f.name}" for f in dataclasses.fields(Course)}
    fields |= {f"driver.{f.name}" for f in dataclasses.fields(Driver)}
    for name, config in Sensors().fitted().items():
        fields |= {f"sensors.{name}.{f.name}" for f in dataclasses.fields(config)}
    camera = {"sensors.camera.processing_s"}
    for rule in RULES:
        assert set(rule.fields) <= fields | camera, rule.needs


@pytest.mark.parametrize("name", registry.names("scenario"))
def test_every_scenario_that_comes_with_the_twin_is_accepted(name):
    assert complaint(registry.load("scenario", name)) is None


BARE = Scenario(name="bare")
IN_VAIN = {
    "soil.cone_index_kpa": replace(BARE, soil=Soil(law="bekker", cone_index_kpa=800.0)),
    "soil.cohesion_kpa": replace(BARE, soil=Soil(cohesion_kpa=20.0)),
    "drive.exhaust_brake": replace(
        BARE, machine="electric_tractor", drive=Drive(exhaust_brake=True), soil=Soil(preset="dry")
    ),
    "course.headland": replace(CM_25, course=Course(headland="backing")),
    "course.backings": replace(CM_25, course=Course(passes=2, backings=3)),
    "driver.headland_rpm": replace(BARE, driver=Driver(headland_rpm=1200.0)),
    "driver.headland_rpm_sd": replace(
        BARE, course=Course(passes=2), driver=Driver(headland_rpm_sd=100.0)
    ),
    "driver.road_kmh": replace(BARE, driver=Driver(road_kmh=20.0)),
    "driver.pause_s": replace(BARE, driver=Driver(pause_s=1.0)),
    "driver.shifts": replace(BARE, machine="jd_8245r", driver=Driver(shifts=True)),
    "driver.reaction_s": replace(BARE, driver=Driver(reaction_s=1.0)),
    "soil.rocks_per_100m2": replace(ROCK, plough=None),
    "soil.rock_kn": replace(CM_25, soil=Soil(rock_kn=20.0)),
    "soil.draft_cv": replace(BARE, soil=Soil(draft_cv=0.2)),
    "soil.draft_length_m": replace(CM_25, soil=Soil(draft_cv=0.0, draft_length_m=2.0)),
    "field.other_length_m": replace(BARE, field=Field(other_length_m=5.0)),
    "field.other_soil.preset": replace(BARE, field=Field(other_soil=Soil())),
    "field.map_cell_m": replace(BARE, field=Field(map_cell_m=0.5)),
    "sensors.gnss.single_sd_m": replace(
        BARE,
        sensors=Sensors(gnss=Gnss(outages=(Outage(start_s=1, duration_s=15),), single_sd_m=3.0)),
    ),
    "sensors.faults.1.kind": replace(
        BARE,
        sensors=Sensors(
            faults=tuple(
                Fault(kind=kind, start_s=1.0, duration_s=1.0)
                for kind in ("imu-bias", "camera-black")
            )
        ),
    ),
}


@pytest.mark.parametrize("path", IN_VAIN)
def test_a_run_refuses_what_is_set_in_vain(path):
    with pytest.raises(BadInput, match=rf"^{path} = .* would not be read: it needs "):
        run(IN_VAIN[path], estimators={})


def test_where_soils_meet_both_laws_read_both_soils():
    meeting = Field(other_share=0.3, other_soil=Soil(law="bekker", cone_index_kpa=500.0))
    assert complaint(replace(CM_25, soil=Soil(cohesion_kpa=20.0), field=meeting)) is None


def test_numbers_of_bekkers_law_that_are_not_all_given_are_refused(own):
    """A preset without them, under a law of one's own, drops what is given of them."""
    scenario = replace(BARE, soil=Soil(preset="asphalt", law="own_laws:rubbed", cohesion_kpa=20.0))
    assert complaint(scenario).startswith("soil.cohesion_kpa = 20.0 would not be read")


def test_a_law_of_ones_own_is_asked_what_it_reads(own):
    assert fields_read("own_laws:icy") == frozenset()
    assert fields_read("own_laws:rubbed") == {"friction"}
    assert fields_read("twin.physics.brixius:brixius") == LAW_READS["brixius"]
    assert fields_read("twin.physics.bekker:bekker") == LAW_READS["bekker"]
    assert set(SLOTS) == LAW_READS["brixius"] | LAW_READS["bekker"]
    icy = replace(CM_25, soil=Soil(law="own_laws:icy"))
    for changed, path in (
        (replace(icy, soil=Soil(law="own_laws:icy", friction=0.5)), "soil.friction"),
        (replace(icy, soil=Soil(law="own_laws:icy", strength_cv=0.2)), "soil.strength_cv"),
        (
            replace(icy, field=Field(patches=(Patch(start_m=1, length_m=2, friction_factor=0.5),))),
            "field.patches.0.friction_factor",
        ),
    ):
        assert complaint(changed).startswith(f"{path} = ")


@pytest.mark.parametrize(
    ("args", "path"),
    [
        (["--soil.law", "bekker", "--soil.cone-index-kpa", "800"], "soil.cone_index_kpa"),
        (["--soil.cohesion_kpa=20"], "soil.cohesion_kpa"),
        (["--soil.rock-kn", "15"], "soil.rock_kn"),  # its default
        (["--sensors.gnss.float-sd-m", "1"], "sensors.gnss.float_sd_m"),
        (["--field.map-cell-m", "0.25"], "field.map_cell_m"),
    ],
)
def test_the_command_line_refuses_what_is_named_in_vain(args, path, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["run", "plough-25cm", *args]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"twin: {path} = ")
    assert said.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_mask_on_the_command_line_makes_its_numbers_read():
    masked = Sensors(
        gnss=Gnss(outages=(Outage(start_s=1, duration_s=5, kind="mask"),), float_sd_m=1)
    )
    assert complaint(replace(CM_25, sensors=masked), ("sensors.gnss.float_sd_m",)) is None


@pytest.mark.parametrize(
    ("args", "path"),
    [
        (["--soil.strength-cv", "0.2"], "soil.strength_cv"),
        (["--soil.draft-scale", "0.5"], "soil.draft_scale"),
        (["--soil.law", "bekker", "--soil.cone-index-kpa", "800"], "soil.cone_index_kpa"),
        (["--soil.law", "bekker", "--radial"], "radial"),
        (["--soil.law", "bekker", "--tyre.deflection-ratio", "0.1"], "tyre.deflection_ratio"),
        (["--tyre.rigid", "--tyre.deflection-ratio", "0.1"], "tyre.deflection_ratio"),
    ],
)
def test_a_rig_refuses_what_it_would_not_read(args, path, tmp_path, capsys):
    assert cli.main(["rig", "wheel", *args, "--out", str(tmp_path / "rig")]) == 2
    assert path in capsys.readouterr().err
    assert not (tmp_path / "rig").exists()


def test_a_sweep_leaves_out_what_would_not_be_read_and_says_so():
    sweeps = {"soil.law": ("brixius", "bekker"), "soil.cone_index_kpa": (800.0, 1200.0)}
    cases = plan(["plough-25cm"], [0, 1], ["ratio"], sweeps)
    assert {case.run.soil.law for case in cases} == {"brixius"}
    assert len(cases) == 4
    said = left_out(["plough-25cm"], sweeps)
    assert len(said) == 2
    assert all("soil.law = bekker" in text and "soil.cone_index_kpa = " in text for text in said)
    both = {"soil.law": LAWS, "soil.friction": (0.6, 0.88)}
    assert len(plan(["plough-25cm"], [0], ["ratio"], both)) == 4
    assert not left_out(["plough-25cm"], both)


@pytest.mark.parametrize(
    ("name", "sweeps", "path"),
    [
        ("plough-25cm", {"soil.rock_kn": (5.0, 15.0)}, "soil.rock_kn"),
        ("ima-pkf", {"disturbed": ("gnss", "truth")}, "disturbed"),
    ],
)
def test_a_sweep_of_nothing_is_refused(name, sweeps, path):
    with pytest.raises(BadInput, match=path):
        plan([name], [0], ["ratio"], sweeps)


def test_a_sweep_over_scenarios_leaves_out_those_without_the_field():
    cases = plan(["plough-25cm", "plough-rock"], [0], ["ratio"], {"soil.rock_kn": (5.0, 20.0)})
    assert {case.scenario for case in cases} == {"plough-rock"}


def test_an_edited_preset_is_another_part_of_a_study(monkeypatch):
    before = plan(["plough-25cm"], [0], ["ratio"], {})[0].part
    monkeypatch.setitem(PRESETS, "firm", replace(PRESETS["firm"], friction=0.5))
    assert plan(["plough-25cm"], [0], ["ratio"], {})[0].part != before


@pytest.mark.parametrize("plough", [None, Plough()])
def test_sensors_without_errors_are_accepted(plough):
    assert complaint(replace(BARE, plough=plough, sensors=ideal())) is None


def test_a_scenario_can_be_put_together_in_steps():
    heavy = replace(BARE, soil=Soil(draft_cv=0.2))
    assert complaint(replace(heavy, plough=Plough())) is None


def test_kept_numbers_are_no_knobs():
    said = complaint(BARE.with_numbers(), ("soil.numbers.friction",))
    assert (
        said
        == "soil.numbers.friction is kept of soil.preset and not set; set the soil's own fields"
    )
    assert complaint(BARE.with_numbers()) is None

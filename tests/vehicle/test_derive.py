"""A machine made from its file beside the one that was made by hand; and what each field turns."""

import dataclasses
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from tests.simulation.rigs import BARE, PLOUGHING
from tests.vehicle.wrong_files import MACHINE
from twin.machine.join import joined
from twin.simulation.build import build
from twin.simulation.simulate import simulate
from twin.vehicle import Implement, Machine, files
from twin.vehicle.derive import derive
from twin.vehicle.machine import Ballast
from twin.vehicle.numerics import machine_facts
from twin.vehicle.reading import from_table


def made(name):
    return replace(files.machine(name), mjcf=None, name="made")


@pytest.mark.parametrize("name", ["taishan_1404a", "electric_tractor"])
def test_the_numerics_are_those_of_the_hand_made_model_within_a_per_cent(name):
    by_hand = machine_facts(files.machine(name)).numbers
    ours = machine_facts(made(name)).numbers
    chosen = ("windup_rad", "damping_s", "damping_nspm", "displacement", "stroke", "hull", "rise")
    for key, value in by_hand.items():
        if not key.endswith(chosen) and not key.startswith(("hull", "engine.displ")):
            assert ours[key] == pytest.approx(value, rel=0.01, abs=1e-9), key


def compiled(machine):
    model = joined(machine)[0].compile()
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    root = model.body("tractor").id
    return model, model.body_subtreemass[root], state.subtree_com[root] - model.body("tractor").pos


@pytest.mark.parametrize("name", ["taishan_1404a", "electric_tractor"])
def test_mass_balance_and_shape_are_those_of_the_hand_made_model(name):
    (own, mass, centre), (hand, wanted_mass, wanted) = (
        compiled(made(name)), compiled(files.machine(name))
    )  # fmt: skip
    assert mass == pytest.approx(wanted_mass, rel=1e-3)
    size = hand.body("front_axle").pos[0]
    np.testing.assert_allclose(centre, wanted, atol=0.01 * size)
    for body in ("front_axle", "rl_wheel", "fl_knuckle"):
        np.testing.assert_allclose(own.body(body).pos, hand.body(body).pos, atol=0.01 * size)
    assert {own.sensor(i).name for i in range(own.nsensor)} >= {
        hand.sensor(i).name for i in range(hand.nsensor)
    }


def late(scenario):
    chunks = list(simulate(build(scenario)))
    assert chunks[-1].end.as_planned
    names = ("draft_n", "slip", "velocity_w", "load_n")
    return {n: np.concatenate([c[n] for c in chunks])[-1500:] for n in names}


def test_it_ploughs_as_the_hand_made_one_does_within_a_per_cent():
    own = replace(PLOUGHING, machine="made", machine_numbers=made("taishan_1404a"))
    ours, hand = late(own), late(PLOUGHING)
    assert ours["draft_n"].mean() == pytest.approx(hand["draft_n"].mean(), rel=0.01)
    assert ours["velocity_w"][:, 0].mean() == pytest.approx(
        hand["velocity_w"][:, 0].mean(), rel=0.01
    )
    np.testing.assert_allclose(ours["load_n"].mean(axis=0), hand["load_n"].mean(axis=0), rtol=0.01)
    assert ours["slip"][:, 2:].mean() == pytest.approx(hand["slip"][:, 2:].mean(), abs=0.005)


@pytest.mark.parametrize("name", files.machine_names())
def test_every_machine_stands_on_its_axle_loads(name):
    known = files.machine(name)
    if known.linkage.fitted:
        machine = build(replace(BARE, machine=name))
        front_n = machine.start_load_n[:2].sum()
        total_n = machine.start_load_n.sum()
        wanted = derive(replace(known, mjcf=None))
        assert total_n == pytest.approx(9.81 * wanted["total_kg"], rel=2e-3)
        assert front_n / total_n == pytest.approx(wanted["front_share"], abs=0.02)


def test_every_number_has_a_grade_and_a_reason():
    for name in files.machine_names():
        numbers = derive(replace(files.machine(name), mjcf=None)).numbers
        for path, number in numbers.items():
            assert number.grade in ("measured", "published", "derived", "assumed"), (name, path)
            assert number.source, (name, path)


BASE = dataclasses.replace(
    from_table(Machine, __import__("tomllib").loads(MACHINE), folder=""),
    ballast=(Ballast(mass_kg=100.0, x_m=3.0),),
)
SAME = {
    "schema", "name", "about", "grade", "source", "mjcf", "implement", "sources", "folder",
    "numerics",  # of a hand-made MJCF alone
    "rear_axle_height_m",  # checked against the tyre
    "engine.battery_kwh",  # shown
    "engine.kind", "drive.driven", "engine.regeneration_kw", "ballast.name",
}  # fmt: skip
"""What changes no number of the model by itself."""
OTHER = {
    "front.tyre": "9.5-24", "rear.tyre": "16.9-30", "engine.droop": 0.05,
    "engine.torque_points": ((1400.0, 400.0), (2200.0, 321.0)), "engine.pto_power_kw": 60.0,
    "transmission.ratios": (60.0, 80.0), "transmission.speeds_kmh": (6.0, 9.0),
    "transmission.kind": "synchronised", "transmission.cvt_ratio": (70.0, 2000.0),
    "linkage.lower_pivot_m": (-0.1, -0.2),
    "linkage.top_pivot_m": (-0.2, 0.3), "places.gnss_main_m": (0.5, 0.5, 2.0),
    "places.gnss_aux_m": (0.5, -0.4, 2.0), "places.imu_m": (0.1, 0.0, 0.2),
    "places.camera_m": (0.9, 0.0, 0.1), "front_axle_kg": 1700.0, "rear_axle_kg": 2500.0,
}  # fmt: skip


def paths(kind, prefix=""):
    hints = __import__("typing").get_type_hints(kind)
    for field in dataclasses.fields(kind):
        hint = hints[field.name]
        if dataclasses.is_dataclass(hint):
            yield from paths(hint, f"{prefix}{field.name}.")
        elif field.name != "ballast":
            yield prefix + field.name


def changed(path):
    """The machine with another value of a field."""
    group, _, name = path.rpartition(".")
    owner = getattr(BASE, group) if group else BASE
    held = getattr(owner, name)
    if path in OTHER:
        value = OTHER[path]
    elif isinstance(held, bool) or name in ("radial", "duals", "fitted"):
        value = not (held or (name == "radial"))
    else:
        numbers = derive(BASE).numbers
        value = 0.97 * (
            held if held is not None else numbers[path].value if path in numbers else 50.0
        )
    new = replace(owner, **{name: value})
    return replace(BASE, **{group: new}) if group else new


def answer(machine):
    """All that the twin makes of a machine."""
    spec, numbers = joined(machine)
    facts = machine_facts(machine)
    return (
        spec.to_xml() if spec.compile() else "",
        numbers,
        facts.usual_ratio,
        facts.usual_rpm,
        facts,
    )


@pytest.mark.parametrize("path", sorted(set(paths(Machine)) - SAME))
def test_every_field_of_a_machine_turns_something(path):
    assert answer(changed(path)) != answer(BASE), path


def test_ballast_moves_the_centre_of_gravity():
    bare, hung = (answer(replace(BASE, ballast=b))[0] for b in ((), BASE.ballast))
    assert bare != hung


def test_an_implement_is_equal_to_what_its_file_says():
    part = files.implement("chisel_3m")
    assert isinstance(part, Implement)
    assert part.bodies == 11
    assert part.furrow is False


@pytest.mark.parametrize(
    ("peak_rpm", "most_kw"), [(1400.0, 74.0), (1800.0, 1.3 * 74.0 * 1800 / 2200)]
)
def test_peak_power_is_what_its_rule_says(peak_rpm, most_kw):
    engine = replace(BASE.engine, peak_rpm=peak_rpm, torque_rise=1.3)
    number = derive(replace(BASE, engine=engine)).numbers["engine.peak_power_kw"]
    assert number.value == pytest.approx(most_kw)
    assert number.source == "the greater of rated torque and peak torque, each times its speed"

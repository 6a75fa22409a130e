"""Events: what is refused and why, and the file that a farmer writes."""

from dataclasses import replace

import pytest

from twin.errors import BadInput, TwinError
from twin.scenario import Course, Event, Plough, Scenario
from twin.scenario.event_file import read_events, write_events

PLOUGHING = Scenario(name="test", plough=Plough(), course=Course(length_m=30.0))
REFUSED = [
    ({"do": "jump"}, "no event is called 'jump'"),
    ({"do": "shift"}, "shift needs one of gear, kmh, by; it is not given"),
    ({"do": "shift", "gear": 2, "kmh": 3.0}, "gear and kmh are given"),
    ({"do": "shift", "gear": 40}, r"events.0: shift after .*gear = 40 is outside \[1, 17\]"),
    ({"do": "shift", "gear": 2.5}, "gear = 2.5 is no whole number"),
    ({"do": "stop", "for_s": 3.0, "gear": 2}, "stop does not read gear; for_s and engine_off"),
    ({"do": "stop", "for_s": -1.0}, r"stop: for_s = -1 is outside \[0, 36000\]"),
    ({"do": "stop", "for_s": 1.0, "at_s": 1.0, "at_m": 2.0}, "at_s and at_m are two times"),
    ({"do": "stop", "for_s": 1.0, "times": 3}, "times = 3 needs a condition"),
    ({"do": "lower", "in_pass": 1}, "in_pass = 1 needs at_m"),
    ({"do": "lower", "when": "rpm < 3"}, "no quantity of a condition is called 'rpm'"),
    ({"do": "lower", "when": "slip is 3"}, "'slip is 3' is no condition; 'engine_rpm < 1300'"),
    ({"do": "lower", "at_m": 300.0}, r"at_m = 300 is outside \[0, 45\], the length of a pass"),
    ({"do": "lift", "at_m": 3.0, "in_pass": 2}, r"in_pass = 2 is outside \[1, 1\]"),
    ({"do": "depth", "depth_m": 0.5}, r"depth_m = 0.5 is outside \[0.05, 0.35\], the depths of"),
    ({"do": "throttle", "engine_rpm": 5000.0}, r"engine_rpm = 5000 is outside \[800, 2400\]"),
    ({"do": "clutch", "pedal": "down"}, "pedal = 'down' is no number"),
    ({"do": "lock", "engaged": 1}, "engaged = 1; true or false would do"),
    ({"do": "mass", "mass_kg": -4.0, "tank": "seed"}, "what is in the tank of seed: 0 kg"),
    ({"do": "mass", "mass_kg": 4.0, "tank": "beer"}, "no tank is called 'beer'"),
]


@pytest.mark.parametrize(("given", "message"), REFUSED, ids=[str(g) for g, _ in REFUSED])
def test_what_cannot_be_done_is_refused(given, message):
    with pytest.raises(TwinError, match=message):
        replace(PLOUGHING, events=(Event(**given),))


@pytest.mark.parametrize(
    ("machine", "given", "message"),
    [
        ("electric_tractor", {"do": "shift", "by": 1}, "electric_tractor has one gear; throttle"),
        ("electric_tractor", {"do": "clutch", "pedal": 1.0}, "a motor without a clutch pedal"),
        ("electric_tractor", {"do": "stop", "for_s": 1.0, "engine_off": True}, "needs a diesel"),
        ("jd_4250", {"do": "front_drive", "engaged": True}, "two driven wheels"),
        ("jd_8245r", {"do": "shift", "gear": 3}, "continuously variable .* kmh would do"),
        ("jd_8245r", {"do": "shift", "by": 1}, "jd_8245r has no gears; kmh would do"),
        ("taishan_1404a", {"do": "lower"}, "there is no implement"),
    ],
)
def test_what_a_machine_has_not_is_refused(machine, given, message):
    with pytest.raises(BadInput, match=message):
        Scenario(name="test", machine=machine, events=(Event(**given),))


@pytest.mark.parametrize(
    ("first", "then", "message"),
    [
        ({"at_s": 9.0}, {"at_s": 4.0}, "events.1: lift at 4 s stands after one at 9 s"),
        ({"at_m": 9.0}, {"at_m": 4.0}, "lift at 4 m of pass 1 stands after one at 9 m of pass 1"),
    ],
)
def test_an_order_that_goes_back_is_refused(first, then, message):
    with pytest.raises(BadInput, match=message):
        replace(PLOUGHING, events=(Event(do="lower", **first), Event(do="lift", **then)))


def test_a_file_is_read_as_it_was_written(tmp_path):
    events = (
        Event(do="throttle", at_s=4.0, engine_rpm=1900.0),
        Event(do="stop", at_m=20.0, for_s=5.0, engine_off=True),
        Event(do="mass", mass_kg=100.0, tank="water"),
        Event(do="shift", when="engine_rpm < 1300", by=-1, times=3),
        Event(do="lock", engaged=False),
    )
    path = tmp_path / "day.toml"
    write_events(path, events)
    assert read_events(path) == events
    assert 'do = "throttle"\nat_s = 4.0\nengine_rpm = 1900.0' in path.read_text()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "it holds no events"),
        ("schema = 2\n[[event]]\ndo = 'lift'", "schema = 2 is outside what is known: 1"),
        ("[[events]]\ndo = 'lift'", r"there is no 'events' in a file of events"),
        ("[[event]]\nat_s = 3", "event 1: Event cannot be made: .*'do'"),
        ("[[event]]\ndo = 'lift'\nheight = 3", r"event 1 \(lift\): Event has no field 'height'"),
        ("[[event]]\ndo = 'lift'\n[[event]]\ndo = 'stop'", r"event 2 \(stop\): stop needs for_s"),
        ("[event]\ndo = 'lift'", "it holds no events"),
        ("do = ", "is no TOML file"),
    ],
)
def test_a_bad_file_is_one_line(tmp_path, text, message):
    path = tmp_path / "day.toml"
    path.write_text(text)
    with pytest.raises(BadInput, match=message) as caught:
        read_events(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_condition_knows_its_side():
    condition = Event(do="lift", when="slip > 0.3").condition
    assert condition.holds(0.31)
    assert not condition.holds(0.3)


def test_gears_of_a_machine_without_any_are_a_ladder_through_the_one_it_drives():
    box = PLOUGHING.gearbox
    assert box.kind == "powershift"
    assert box.ratios[box.gear - 1] == PLOUGHING.gear.ratio
    steps = [slow / fast for slow, fast in zip(box.ratios, box.ratios[1:], strict=False)]
    assert steps == pytest.approx([1.2] * len(steps))


def test_a_road_back_needs_an_even_number_of_passes():
    with pytest.raises(BadInput, match=r"course.road_m = 50 leads back, but .* an even number"):
        Scenario(name="test", course=Course(road_m=50.0))

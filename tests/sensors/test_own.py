"""Sensors of one's own: the shipped example, and what is told of those that do wrong."""

import json
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import pytest

from tests.sensors.test_chunking import bumpy, run
from tests.sensors.trajectories import drive, pieces, same
from twin.commands.parse import parse
from twin.errors import BadInput, OutOfRange
from twin.io.plain import from_plain, to_plain
from twin.io.run_folder import read, write
from twin.logs import read as read_log
from twin.pipeline.estimating import estimates
from twin.sensors import Column, Geometry, Range, Sensor, Sensors, setup
from twin.streams import OwnSetup, Setup, Streams, check

EXAMPLES = Path(__file__).parents[2] / "examples"
GEOMETRY = Geometry(
    machine="m", wheelbase_m=2.7, track_front_m=1.8, track_rear_m=1.8, cg_x_m=1.1,
    wheel_radius_m=dict.fromkeys(("fl", "fr", "rl", "rr"), 0.8), antenna_main_m=(0.0, 0.5, 2.8),
    antenna_aux_m=(0.0, -0.5, 2.8), imu_m=(0.0, 0.0, 1.0),
)  # fmt: skip


@pytest.fixture
def radar(monkeypatch):
    """The example's class, found as a user who stands in its folder finds it."""
    monkeypatch.chdir(EXAMPLES)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    yield type(Sensor.by_name("radar:Radar"))
    sys.modules.pop("radar", None)


@pytest.mark.parametrize("size", [1, 7, 333])
def test_chunking_changes_no_bit_of_the_example(radar, size):
    trajectory = bumpy()
    fitted = Sensors(extra=(radar(rate_hz=70.7),))
    whole, cut = run(fitted, [trajectory]), run(fitted, pieces(trajectory, size))
    assert set(whole.tables) == {*Sensors().fitted(), "radar"}
    assert same(whole["radar"], cut["radar"])
    assert len(whole["radar"]["epoch_ns"]) > 100
    check(cut, setup(fitted, GEOMETRY).extra)


def test_it_measures_the_speed_along_the_tractor(radar):
    quiet = radar(speed_sd_mps=0.0, scale_error=0.0)
    table = run(Sensors(extra=(quiet,)), [drive(2.0, yaw_rate_radps=0.4, roll_rad=0.1)])["radar"]
    np.testing.assert_allclose(table["speed_mps"], 1.5, rtol=1e-6)
    np.testing.assert_array_equal(table["arrival_ns"] - table["epoch_ns"], 50_000_000)


def test_another_sensor_changes_no_bit_of_the_twins_own(radar):
    trajectory = bumpy()
    alone, beside = run(Sensors(), [trajectory]), run(Sensors(extra=(radar(),)), [trajectory])
    assert all(same(alone[name], beside[name]) for name in alone.tables)


def test_a_scenario_repeats_it(radar):
    fitted = Sensors(extra=(radar(rate_hz=20.0),))
    plain = json.loads(json.dumps(to_plain(fitted)))
    assert plain["extra"][0]["sensor"] == "radar:Radar"
    assert from_plain(Sensors, plain) == fitted
    with pytest.raises(BadInput, match="Radar has no field 'rate'"):
        from_plain(Sensors, plain | {"extra": [{"sensor": "radar:Radar", "rate": 3.0}]})


def test_on_the_command_line_it_is_a_name(radar):
    @dataclass(frozen=True, kw_only=True)
    class Options:
        sensors: Sensors = field(default_factory=Sensors)

    options = parse(Options, ["--sensors.extra", "radar:Radar"], prog="twin run")
    assert options.sensors.extra == (radar(),)
    with pytest.raises(BadInput, match="did you mean 'Radar'"):
        parse(Options, ["--sensors.extra", "radar:Rader"], prog="twin run")


@dataclass(frozen=True, kw_only=True)
class Saved:
    """A run as a folder holds it."""

    setup: Setup
    streams: Streams
    scenario: object = None
    truth: object = None
    estimates: object = None
    wall_s: float = 0.0


def test_its_stream_and_setup_come_back_from_a_run_folder(radar, tmp_path):
    fitted = Sensors(extra=(radar(),))
    told, streams = setup(fitted, GEOMETRY), run(fitted, [bumpy()])
    folder = write(Saved(setup=told, streams=streams, estimates={}), {}, tmp_path / "run")
    back = read(folder)
    assert back.setup == told
    assert back.setup.extra["radar"]["speed_sd_mps"] == 0.03
    assert back.setup.extra["radar"].columns["speed_mps"][0] == "m/s"
    assert "scale_error" not in back.setup.to_json()
    assert same(back.streams["radar"], streams["radar"])
    log = read_log(folder)
    assert log.setup == told
    assert same(log.streams["radar"], streams["radar"])


class Listens:
    """Slip from wheel ticks and the radar, sample by sample."""

    def init(self, told):
        return told.extra["radar"]["rate_hz"]

    def run(self, rate_hz, chunk):
        table = chunk["radar"]
        return rate_hz, {"epoch_ns": table["epoch_ns"], "speed_mps": table["speed_mps"]}


def test_an_estimator_is_given_the_stream_in_order_of_arrival(radar):
    fitted = Sensors(extra=(radar(),))
    streams, told = run(fitted, [bumpy()]), setup(fitted, GEOMETRY)
    whole = estimates("listens", Listens(), told, streams)
    parts = [chunk["radar"]["speed_mps"] for chunk in streams.chunks(50)]
    np.testing.assert_array_equal(np.concatenate(parts), whole["speed_mps"])
    sensor, _ = streams.merge_order()
    assert np.count_nonzero(sensor == 6) == len(whole["epoch_ns"])


@dataclass(frozen=True, kw_only=True)
class Odd(Sensor):
    """Gives what it is told to."""

    gain: Annotated[float, Range(0, 1)] = 0.5
    does: object = None
    stream = "odd"
    columns = (Column("level_v", "V", "a level"),)

    def init(self, seed, start_ns):
        return None

    def sample(self, state, chunk):
        return self.does(chunk)


def table(epoch_ns, arrival_ns, level_v):
    stamps = {"epoch_ns": np.array(epoch_ns), "arrival_ns": np.array(arrival_ns)}
    return None, stamps | {"level_v": np.array(level_v)}


@pytest.mark.parametrize(
    ("does", "says"),
    [
        (lambda chunk: chunk["wheelz"], r"Odd' fails: KeyError: 'wheelz' \(test_own.py, line"),
        (lambda chunk: chunk["velocity_w"].sort(), r"test_own.py, line .*x.copy\(\)"),
        (lambda chunk: {}, r"sample gives dict, not \(state, table\)"),
        (lambda chunk: (None, table([1], [1], [0.0])[1] | {"levl": [1]}), "did you mean 'level_v'"),
        (lambda chunk: (None, {"epoch_ns": [1]}), "gives no arrival_ns, no level_v"),
        (lambda chunk: table([1, 2], [2, 2], [0.0]), r"level_v has shape \(1,\)"),
        (lambda chunk: table([1.0], [1], [0.0]), "epoch_ns is float64"),
        (lambda chunk: table([1, 2], [3, 2], [0.0, 0.0]), "arrival_ns falls"),
        (lambda chunk: table([2], [1], [0.0]), "before the instant it describes"),
    ],
)
def test_what_a_sensor_does_wrong_is_told_in_one_line(does, says):
    with pytest.raises(BadInput, match=says) as caught:
        run(Sensors(extra=(Odd(does=does),)), [drive(0.1)])
    assert "\n" not in str(caught.value)
    assert "tests.sensors.test_own:Odd" in str(caught.value)


def test_a_range_stands_on_the_field_and_names_are_checked():
    with pytest.raises(OutOfRange, match=r"odd.gain = 2 is outside \[0, 1\]"):
        Odd(gain=2.0)
    with pytest.raises(OutOfRange, match="nan"):
        replace(Odd(), gain=float("nan"))
    with pytest.raises(BadInput, match="two of the streams odd, odd"):
        Sensors(extra=(Odd(), Odd()))
    with pytest.raises(BadInput, match="none of gnss"):
        type("Gnss2", (Odd,), {"stream": "gnss"})()
    with pytest.raises(BadInput, match=r"it must be a twin.sensors.Sensor"):
        Sensor.by_name("twin.sensors:Imu")
    with pytest.raises(BadInput, match="must be module:Name"):
        Sensor.by_name("radar")


def test_a_stream_that_no_setup_declares_is_refused():
    odd = {"epoch_ns": np.array([1]), "arrival_ns": np.array([1]), "level_v": np.array([1.0])}
    with pytest.raises(BadInput, match="'odd' is not one of gnss"):
        check(Streams({"odd": odd}))
    with pytest.raises(BadInput, match="unknown column 'level_v'"):
        check(Streams({"odd": odd}), {"odd": OwnSetup(columns={"other_v": ("V", "another")})})

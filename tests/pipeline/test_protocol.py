from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.pipeline.protocol_drive import RADIUS_M, Truth, drive
from twin.errors import BadInput
from twin.logs import Log, Rule, read
from twin.logs.column_map import column_map_from
from twin.logs.protocol_parts import Part, written_from
from twin.pipeline.protocol import applied
from twin.streams import Streams

ROOT = Path(__file__).parents[2]
FIELD_LOG = ROOT.parent / "shared" / "data" / "t7165s_field.csv"
TRUTH = Truth()


def parts(log: Log) -> dict[str, dict]:
    _, found = applied(log)
    return {part["part"]: part for part in found["protocol"]["parts"]}


@pytest.fixture(scope="module")
def found() -> dict[str, dict]:
    return parts(drive())


def test_every_part_is_found_and_gives_its_value(found: dict[str, dict]) -> None:
    assert all(part["found"] for part in found.values()), found
    assert found["zero-pull passes"]["number"] == pytest.approx(TRUTH.scale, abs=1e-3)
    assert found["towed-wheel run"]["number"] == pytest.approx(TRUTH.towed_scale, abs=1e-3)
    assert found["clock check"]["number"] == pytest.approx(TRUTH.lag_s, abs=0.03)
    assert found["standing"]["number"] == pytest.approx(TRUTH.gyro_bias_radps, abs=1e-4)
    assert found["coast-down"]["number"] == pytest.approx(TRUTH.rolling, rel=0.05)


def test_they_are_put_to_use() -> None:
    raw = drive()
    log, _ = applied(raw)
    assert np.mean(log.streams["imu"]["gyro_z_radps"][:2500]) == pytest.approx(0.0, abs=1e-4)
    ratio = np.max(log.streams["wheels"]["speed_rl_mps"]) / np.max(
        raw.streams["wheels"]["speed_rl_mps"]
    )
    assert ratio == pytest.approx(TRUTH.scale, abs=1e-3)
    moved_s = (raw.streams["gnss"]["epoch_ns"] - log.streams["gnss"]["epoch_ns"])[0] * 1e-9
    assert moved_s == pytest.approx(TRUTH.lag_s, abs=0.03)
    assert np.all(log.streams["gnss"]["arrival_ns"] >= log.streams["gnss"]["epoch_ns"])


def test_of_ticks_the_nominal_radius_of_the_driven_wheels_is_scaled() -> None:
    log, _ = applied(drive(ticks=True))
    assert log.setup.wheels is not None
    assert log.setup.wheels.radius_m["rl"] == pytest.approx(TRUTH.scale * RADIUS_M, abs=1e-3)
    assert log.setup.wheels.radius_m["fl"] == RADIUS_M


def test_without_the_clock_check_nothing_changes() -> None:
    raw = drive(leave_out=("pulse",))
    log, found = applied(raw)
    assert log is raw
    assert found == {"protocol": None}


@pytest.mark.parametrize(
    ("left_out", "part"), [("coast", "coast-down"), ("towed", "towed-wheel run")]
)
def test_under_power_it_does_not_roll_free(left_out: str, part: str) -> None:
    found = parts(drive(leave_out=(left_out,)))
    assert not found[part]["found"]
    assert found["zero-pull passes"]["number"] == pytest.approx(TRUTH.scale, abs=1e-3)


def test_without_engine_speed_a_towed_run_is_not_told() -> None:
    assert not parts(drive(engine=False))["towed-wheel run"]["found"]


def test_a_pass_under_draft_is_no_zero_pull_pass() -> None:
    log = drive()
    machine = dict(log.streams["machine"])
    engine = machine["engine_radps"]
    pulling = {**machine, "draft_pin_n": np.where(engine > 100.0, 20e3, 0.0)}
    tables = {**log.streams.tables, "machine": pulling}
    assert not parts(replace(log, streams=Streams(tables)))["zero-pull passes"]["found"]
    free = {**machine, "draft_pin_n": 50.0 * np.ones(len(engine))}
    tables = {**log.streams.tables, "machine": free}
    used = parts(replace(log, streams=Streams(tables)))["zero-pull passes"]["used"]
    assert used.startswith("wheels times")
    assert "no pull is measured" not in used


def test_the_maps_zero_slip_rule_is_used_instead() -> None:
    log = replace(drive(), rules={"zero_slip": Rule(min_speed_kmh=5.0)})
    scaled, found = applied(log)
    part = next(p for p in found["protocol"]["parts"] if p["part"] == Part.ZERO_PULL)
    assert part["used"] == "no, the map's [zero_slip] is"
    assert scaled.streams["wheels"]["speed_rl_mps"] is not None
    np.testing.assert_array_equal(
        scaled.streams["wheels"]["speed_rl_mps"], log.streams["wheels"]["speed_rl_mps"]
    )


def test_ways_that_differ_are_not_used() -> None:
    log = drive()
    wheels = dict(log.streams["wheels"])
    back = np.arange(len(wheels["epoch_ns"])) * 0.02 > 185.0
    wheels |= {k: np.where(back, 1.06 * wheels[k], wheels[k]) for k in wheels if "speed" in k}
    found = parts(replace(log, streams=Streams({**log.streams.tables, "wheels": wheels})))
    assert found["zero-pull passes"]["used"].startswith("no, the ways differ by")


def test_what_was_written_down_counts_alone() -> None:
    log = drive(leave_out=("pulse",))
    written = written_from({"zero_pull_passes_s": [[78.0, 134.0], [160.0, 216.0]]})
    found = parts(replace(log, protocol=written))
    assert found["zero-pull passes"]["number"] == pytest.approx(TRUTH.scale, abs=1e-3)
    assert not found["standing"]["found"]


@pytest.mark.parametrize("times", [[], [[5]], [[9, 3]], [["a", "b"]], "60", [[True, 4]]])
def test_times_that_are_none_are_refused(times: object) -> None:
    with pytest.raises(
        BadInput, match=r"protocol.standing_s = .* must be a list of \[start, end\]"
    ):
        column_map_from({"protocol": {"standing_s": times}})


def test_another_key_is_refused_by_name() -> None:
    with pytest.raises(BadInput, match="key of \\[protocol\\] is called 'coast_s'"):
        column_map_from({"protocol": {"coast_s": [[1, 2]]}})


@pytest.mark.skipif(not FIELD_LOG.exists(), reason="the field log is not beside the checkout")
def test_field_work_is_no_protocol() -> None:
    log = read(FIELD_LOG, ROOT / "examples" / "t7165s.toml")
    same, found = applied(log)
    assert same is log
    assert found == {"protocol": None}

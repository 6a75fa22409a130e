from pathlib import Path

import numpy as np
import pytest

from twin.errors import BadInput
from twin.logs import Log, Rule, read
from twin.pipeline.log_check import log_lag, log_scale, scaled, slip_from_ratio, steady_slip
from twin.streams import Setup, Streams

ROOT = Path(__file__).parents[2]
FIELD_LOG = ROOT.parent / "shared" / "data" / "t7165s_field.csv"
SETUP = Setup(machine="m", wheelbase_m=2.5, track_front_m=1.8, track_rear_m=1.8, cg_x_m=1.0)
RULES = {
    "zero_slip": Rule(where={"state": ("M",)}, min_speed_kmh=5.0),
    "steady": Rule(where={"state": ("W",)}, min_speed_kmh=2.5, max_speed_change_kmhps=0.15),
}


def made_log(*, true_scale=0.95, slip=0.12, n=600):
    """Half the rows on the move without slip, half at work with slip, GNSS 0.02 m/s noisy."""
    generator = np.random.default_rng(0)
    epoch_ns = np.arange(n) * 10**9
    work = np.arange(n) >= n // 2
    wheel = np.full(n, 2.2)
    ground = wheel * true_scale * np.where(work, 1.0 - slip, 1.0)
    ground = ground + 0.02 * generator.normal(size=n)
    stamps = {"epoch_ns": epoch_ns, "arrival_ns": epoch_ns}
    streams = Streams(
        {
            "gnss": {**stamps, "v_east_mps": 0.6 * ground, "v_north_mps": -0.8 * ground},
            "wheels": {**stamps, "speed_rl_mps": wheel, "speed_rr_mps": wheel},
        }
    )
    rows = {"state": np.where(work, "W", "M")}
    return Log(streams=streams, setup=SETUP, rows=rows, rules=RULES)


def test_a_known_scale_and_slip_are_found():
    found = steady_slip(made_log())
    assert found.scale.scale == pytest.approx(0.95, abs=0.003)
    assert found.median == pytest.approx(0.12, abs=0.005)
    assert found.low < 0.12 < found.high
    assert found.n == 300


def test_the_interval_holds_the_scale_of_few_rows():
    log = made_log()
    few = {**RULES, "zero_slip": Rule(where={"state": ("M",)}, min_speed_kmh=7.0)}
    state = np.where(np.arange(600) < 580, "W", "M")[::-1].copy()
    thin = Log(streams=log.streams, setup=SETUP, rows={"state": state}, rules=few)
    assert log_scale(thin).n == 20
    wide, narrow = steady_slip(thin), steady_slip(log)
    assert wide.high - wide.low > narrow.high - narrow.low


def test_slip_has_the_sign_and_bounds_of_its_definition():
    ratio = np.array([0.0, 0.9, 1.0, 1.25])
    np.testing.assert_allclose(slip_from_ratio(ratio), [1.0, 0.1, 0.0, -0.2])


def test_scaled_wheels_have_scale_one():
    log = made_log()
    assert log_scale(scaled(log, log_scale(log).scale)).scale == pytest.approx(1.0)


def test_a_log_without_rules_or_rows_is_refused():
    log = made_log()
    with pytest.raises(BadInput, match=r"no \[zero_slip\] rule"):
        log_scale(Log(streams=log.streams, setup=SETUP))
    fast = {"zero_slip": Rule(min_speed_kmh=30.0)}
    with pytest.raises(BadInput, match="no row"):
        log_scale(Log(streams=log.streams, setup=SETUP, rules=fast))
    with pytest.raises(BadInput, match="no gnss and wheels"):
        log_lag(Log(streams=Streams({"gnss": log.streams["gnss"]}), setup=SETUP))


@pytest.mark.skipif(not FIELD_LOG.exists(), reason="the field log is not beside the checkout")
def test_steady_work_of_a_real_tractor():
    log = read(FIELD_LOG, ROOT / "examples" / "t7165s.toml")
    found = steady_slip(log)
    assert found.median == pytest.approx(0.070, abs=0.015)
    assert found.low < 0.070 < found.high
    assert found.scale.scale == pytest.approx(0.993, abs=0.002)
    assert (found.scale.n, found.n) == (217, 1792)
    # few moving rows: the scale is known to a percent or two and no better
    assert 0.97 < found.scale.low < 0.993 < found.scale.high < 1.02
    assert 0.1 < found.lag_s < 0.5

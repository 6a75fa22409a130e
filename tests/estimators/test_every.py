"""What holds for every registered estimator, whatever it does inside."""

import copy
import dataclasses
import itertools
import pickle

import numpy as np
import pytest
import synthetic
from synthetic import Drive

from estimators import REGISTRY
from estimators.layout import OUT_OF_ORDER
from twin.pipeline import named as registry
from twin.streams import ESTIMATES, Streams, check, concatenate

SETUP = synthetic.setup()
DRIVE = Drive(duration_s=6.0, gnss_delay_s=0.07, pitch=lambda t: 0.01 * np.sin(9 * t))
STREAMS = synthetic.streams(DRIVE, SETUP)


@pytest.fixture(params=REGISTRY)
def estimator(request):
    return registry.load("estimator", request.param)


@pytest.fixture
def causal(estimator):
    """One that runs as samples arrive; offline smoothers are marked and see the whole log."""
    if getattr(estimator, "offline", False):
        pytest.skip("a smoother needs the whole log")
    return estimator


def run(estimator, chunks, setup=SETUP):
    """The table of all estimates, and the states between the chunks."""
    states, tables = [estimator.init(setup)], []
    for chunk in chunks:
        state, table = estimator.run(states[-1], chunk)
        states.append(state)
        tables.append(table)
    return {k: np.concatenate([t[k] for t in tables]) for k in tables[0]}, states


def bits(table):
    return {name: column.tobytes() for name, column in table.items()}


def test_streams_obey_the_contract():
    check(STREAMS)
    assert len(STREAMS) == 6 * (20 + 50 + 50)


def test_estimates_have_known_columns_of_equal_length(estimator):
    table, _ = run(estimator, [STREAMS])
    assert set(table) <= set(ESTIMATES)
    assert {"epoch_ns", "slip"} <= set(table)
    assert len({len(c) for c in table.values()}) == 1
    assert len(table["slip"]) > 50
    assert np.all(np.diff(table["epoch_ns"]) > 0)


@pytest.mark.parametrize("size", [1, 7, 1000])
def test_chunking_changes_no_bit(causal, size):
    whole, _ = run(causal, [STREAMS])
    parts, _ = run(causal, STREAMS.chunks(size))
    assert bits(parts) == bits(whole)


def test_causal(causal):
    whole, _ = run(causal, [STREAMS])
    for cut in (1, 100, 333, 500):
        head, _ = run(causal, [STREAMS.samples(0, cut)])
        n = len(head["epoch_ns"])
        assert bits(head) == bits({k: v[:n] for k, v in whole.items()})
    assert n > 10


def test_deterministic(estimator):
    assert bits(run(estimator, [STREAMS])[0]) == bits(run(estimator, [STREAMS])[0])


def test_states_are_values(estimator):
    """A kept state is not changed by going on from it, and survives pickling."""
    half = len(STREAMS) // 2
    _, states = run(estimator, [STREAMS.samples(0, half)])
    before = pickle.dumps(states[-1])
    chunk = STREAMS.samples(half, len(STREAMS))
    kept = copy.deepcopy(chunk.tables)
    _, on = estimator.run(states[-1], chunk)
    assert pickle.dumps(states[-1]) == before
    assert all(bits(kept[s]) == bits(chunk.tables[s]) for s in kept)
    _, again = estimator.run(pickle.loads(before), chunk)
    assert bits(again) == bits(on)


@pytest.mark.parametrize(
    "present",
    [s for n in range(4) for s in itertools.combinations(("gnss", "imu", "wheels"), n)],
    ids="-".join,
)
def test_any_sensor_may_be_absent(estimator, present):
    streams = Streams({s: STREAMS[s] for s in present})
    blocks = {s: None for s in ("gnss", "imu") if s not in present}
    for setup in (SETUP, dataclasses.replace(SETUP, **blocks)):
        table, _ = run(estimator, [streams], setup)
        if "wheels" in present:
            assert len(table["slip"]) > 50
        else:
            assert not np.isfinite(table["slip"]).any()


def test_any_column_may_be_absent(estimator):
    for sensor, table in STREAMS.tables.items():
        for column in sorted(table.keys() - {"epoch_ns", "arrival_ns"}):
            rest = {k: v for k, v in table.items() if k != column}
            run(estimator, [Streams({**STREAMS.tables, sensor: rest})])


def holed(seed):
    """The streams with a fifth of every column's values missing."""
    rng = np.random.default_rng(seed)
    tables = {}
    for sensor, table in STREAMS.tables.items():
        tables[sensor] = dict(table)
        for column in sorted(table.keys() - {"epoch_ns", "arrival_ns"}):
            values = table[column].astype(float)
            values[rng.random(len(values)) < 0.2] = np.nan
            tables[sensor][column] = values
    return Streams(tables)


def test_nan_is_a_measurement_not_made(estimator):
    """Over seven patterns of holes: a search over four seconds may lose its way in one."""
    medians = []
    for seed in range(7):
        table, _ = run(estimator, [holed(seed)])
        slip = table["slip"]
        assert not np.isinf(slip).any()
        late = synthetic.seconds(table["epoch_ns"]) > 2
        error = (slip - DRIVE.slip(synthetic.seconds(table["epoch_ns"])))[late]
        assert np.isfinite(error).mean() > 0.5
        medians.append(np.nanmedian(np.abs(error)))
    assert np.median(medians) < 0.06


def test_time_going_backwards_is_left_out_and_flagged(estimator):
    """A repeated block of old samples, handed on anew, changes the flags and nothing else."""
    old = {
        s: {
            k: (np.full_like(v, 4_000_000_000) if k == "arrival_ns" else v)[10:20]
            for k, v in t.items()
        }
        for s, t in STREAMS.tables.items()
    }
    at = int(np.searchsorted(np.sort(_arrivals(STREAMS)), 4_000_000_000, side="right"))
    head, tail = STREAMS.samples(0, at), STREAMS.samples(at, len(STREAMS))
    clean, _ = run(estimator, [head, tail])
    disturbed, _ = run(estimator, [concatenate([head, Streams(old)]), tail])
    clean_flags, flags = clean.pop("flags"), disturbed.pop("flags")
    assert bits(clean) == bits(disturbed)
    changed = flags != clean_flags
    assert 1 <= np.count_nonzero(changed) <= 2
    assert np.all(flags[changed] & OUT_OF_ORDER)


def _arrivals(streams):
    return np.concatenate([t["arrival_ns"] for t in streams.tables.values()])


def test_gap_in_time_is_got_over(estimator):
    """Twenty seconds without a sample; two seconds after it slip is right again."""
    later = {
        s: {
            k: np.where(t["epoch_ns"] > 3_000_000_000, v + 20_000_000_000, v)
            if k in ("epoch_ns", "arrival_ns")
            else v
            for k, v in t.items()
        }
        for s, t in STREAMS.tables.items()
    }
    table, _ = run(estimator, [Streams(later)])
    t = synthetic.seconds(table["epoch_ns"])
    after = t > 24
    assert after.sum() > 15
    assert np.nanmedian(np.abs(table["slip"] - DRIVE.slip(t - 20))[after]) < 0.06


def test_one_hertz_log_with_a_single_wheel_speed(estimator):
    """A bus log: horizontal speed as east, one wheel-based speed, no IMU, no heading."""
    t = np.arange(200.0)
    setup = dataclasses.replace(synthetic.setup(), gnss=None, imu=None, wheels=None)
    wheel = np.full(t.shape, 2.0)
    streams = Streams(
        {
            "gnss": synthetic.stamps(t)
            | {"v_east_mps": np.full(t.shape, 1.8), "v_north_mps": np.zeros(t.shape)},
            "wheels": synthetic.stamps(t) | {"speed_rl_mps": wheel, "speed_rr_mps": wheel.copy()},
        }
    )
    table, _ = run(estimator, [streams], setup)
    if np.isfinite(table["slip"]).any():
        assert table["slip"][-50:] == pytest.approx(0.1, abs=1e-6)

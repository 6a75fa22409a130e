"""The bounds against closed forms, and through a time without GNSS."""

import dataclasses

import numpy as np
import pytest

from estimators.bounds import bound
from estimators.bounds.across import across_body
from estimators.bounds.along import along_body
from estimators.bounds.motion import drives_at, first_order, motion_of
from estimators.riccati import System, steady, through
from estimators.slip_ekf import SLIP_EKF
from twin.streams import Streams
from twin.testing import drives as synthetic

Q, R = 1e-4, 0.04
WALK = System(
    transition=np.eye(1), process=np.array([[Q]]), rows=np.eye(1), variances=np.array([R])
)
SETUP = synthetic.setup()
DRIVE = synthetic.Drive(
    duration_s=60.0,
    speed=lambda t: 1.6 + 0.05 * np.sin(0.9 * t) + 0.02 * np.sin(2.3 * t),
    slip=lambda t: 0.12 - 0.03 * np.sin(0.9 * t) - 0.012 * np.sin(2.3 * t),
)


def test_a_random_walk():
    """P = (sqrt(q^2 + 4 q r) - q) / 2;  the smoother's, for q << r, sqrt(q r) / 2."""
    causal, offline = steady(WALK)
    assert causal[0, 0] == pytest.approx((np.sqrt(Q**2 + 4 * Q * R) - Q) / 2, rel=1e-4)
    assert offline[0, 0] == pytest.approx(np.sqrt(Q * R) / 2, rel=0.01)


def test_nothing_measured_is_nothing_known():
    blind = dataclasses.replace(WALK, rows=np.zeros((0, 1)), variances=np.zeros(0))
    assert np.isnan(steady(blind)[0]).all()


def test_through_a_gap_a_walk_grows_by_q_a_step_and_forgets_the_gap():
    causal, offline = steady(WALK)
    seen = np.ones((2000, 1), bool)
    seen[900:1000] = False
    by_filter, by_smoother = through(WALK, seen, 0)
    steps = np.arange(1, 101)
    assert by_filter[900:1000] == pytest.approx(causal[0, 0] + Q * steps, rel=1e-4)
    assert by_filter[[0, 800, 1999]] == pytest.approx(causal[0, 0], rel=1e-4)
    assert by_smoother[[0, 1999]] == pytest.approx(offline[0, 0], rel=1e-3)
    # between two ends that are known by P: P / 2 + q n / 4 in the middle of n steps
    assert by_smoother[949] == pytest.approx(causal[0, 0] / 2 + Q * 101 / 4, rel=0.05)
    assert (by_smoother <= by_filter * (1 + 1e-9)).all()


def seen_until(streams, first_s, last_s, without=()):
    """The drive's streams without GNSS for a time, and without some columns of the wheels."""
    at = synthetic.seconds(streams["gnss"]["epoch_ns"])
    kept = (at < first_s) | (at > last_s)
    gnss = {name: column[kept] for name, column in streams["gnss"].items()}
    wheels = {name: c for name, c in streams["wheels"].items() if name not in without}
    return Streams({**streams.tables, "gnss": gnss, "wheels": wheels})


def test_blind_the_bound_grows_unless_the_front_wheels_are_counted():
    streams = synthetic.streams(DRIVE, SETUP)
    t = synthetic.times(DRIVE, 50.0)
    truth = synthetic.stamps(t) | {
        "speed_mps": DRIVE.speed(t),
        "slip": DRIVE.slip(t),
        "wheel_speed_mps": DRIVE.speed(t) / (1.0 - DRIVE.slip(t)),
    }
    window, within = (6.0, 60.0), (31.0, 41.0)
    hidden = seen_until(streams, 30.0, 40.0)
    blind = seen_until(streams, 30.0, 40.0, ("ticks_fl", "ticks_fr"))
    open_sky = bound(SETUP, streams, truth, window)
    counted = bound(SETUP, hidden, truth, window, within)
    uncounted = bound(SETUP, blind, truth, window, within)
    assert counted.slip_causal == pytest.approx(open_sky.slip_causal, rel=0.3)
    assert uncounted.slip_causal > 2.0 * open_sky.slip_causal
    assert uncounted.slip_causal < np.std(DRIVE.slip(t))
    assert uncounted.slip_offline < uncounted.slip_causal

    _, table = SLIP_EKF.run(SLIP_EKF.init(SETUP), hidden)
    at = synthetic.seconds(table["epoch_ns"])
    inside = (at > 30.0) & (at < 40.0)
    error = (table["slip"] - DRIVE.slip(at))[inside]
    assert error.std() > 0.7 * counted.slip_causal  # none is better than the bound, by chance a bit


def by_brute_force(system, first, seen, state):
    """Variances of a state at each step, given all that is measured up to it, and all there is.

    The trajectory as one Gaussian vector, conditioned on the measurements: no recursion.
    """
    n, size = len(seen), len(first)
    marginal = [first]
    for _ in range(n - 1):
        marginal.append(system.transition @ marginal[-1] @ system.transition.T + system.process)
    joint = np.zeros((n * size, n * size))
    for j in range(n):
        block = marginal[j]
        for i in range(j, n):
            rows, columns = slice(i * size, (i + 1) * size), slice(j * size, (j + 1) * size)
            joint[rows, columns], joint[columns, rows] = block, block.T
            block = system.transition @ block
    step, row = np.nonzero(seen)
    h = np.zeros((len(step), n * size))
    for k in range(len(step)):
        h[k, step[k] * size : (step[k] + 1) * size] = system.rows[row[k]]
    noise = system.variances[row]

    def left(at, used):
        some = h[used] @ joint
        gain = np.linalg.solve(some @ h[used].T + np.diag(noise[used]), some[:, at])
        return joint[at, at] - some[:, at] @ gain

    at = np.arange(n) * size + state
    causal = [left(at[k], step <= k) for k in range(n)]
    return np.array(causal), np.array([left(each, step >= 0) for each in at])


def moving():
    """Streams of every kind, and the truth, of a straight drive that slides a little."""
    setup = synthetic.setup(gnss=dataclasses.replace(SETUP.gnss, velocity_sd_mps=0.03))
    made = synthetic.streams(dataclasses.replace(DRIVE, gnss_delay_s=0.06), setup)
    rng, t = np.random.default_rng(4), synthetic.times(DRIVE, 50.0)
    frames, loads = synthetic.times(DRIVE, 30.0), synthetic.times(DRIVE, 10.0)
    camera = synthetic.stamps(frames, 0.05) | {
        "v_x_mps": DRIVE.speed(frames), "v_y_mps": 0.0 * frames,
        "var_x_m2ps2": np.full_like(frames, 0.01**2), "var_y_m2ps2": np.full_like(frames, 0.01**2),
        "interval_s": np.full_like(frames, 1.0 / 30.0), "used": np.ones_like(frames),
    }  # fmt: skip
    draft_n = 1e5 * DRIVE.slip(loads) + 500.0 * rng.standard_normal(len(loads))
    machine = synthetic.stamps(loads) | {"draft_pin_n": draft_n}
    v_y = np.convolve(rng.standard_normal(len(t)), np.exp(-np.arange(100) / 20.0), "same") * 0.004
    truth = synthetic.stamps(t) | {
        "speed_mps": DRIVE.speed(t) + 0.0005 * np.cumsum(rng.standard_normal(len(t))),
        "slip": DRIVE.slip(t) + 0.0005 * rng.standard_normal(len(t)),
        "wheel_speed_mps": DRIVE.speed(t) / (1.0 - DRIVE.slip(t)),
        "v_y_rear_mps": v_y,
    }
    return setup, Streams({**made.tables, "camera": camera, "machine": machine}), truth


def test_standing_and_backing_up_change_no_bound():
    """11 s at a stand without GNSS, and 5 s backwards, among 60 s of driving."""
    setup, streams, truth = moving()
    streams = without(streams, "imu")  # it goes on driving
    plain = bound(setup, streams, truth, (1.0, 61.0))
    at = synthetic.seconds(truth["epoch_ns"])
    back = (at > 40.0) & (at < 45.0)
    stands = (at > 30.0) & (at < 46.0) & ~back
    way = np.where(stands, 0.0, np.where(back, -1.0, 1.0))
    noise = 1e-4 * np.random.default_rng(1).standard_normal(len(at))
    day = truth | {n: way * truth[n] + noise * stands for n in ("speed_mps", "wheel_speed_mps")}
    day["slip"] = np.where(stands, 1.0 - noise / 1e-4, truth["slip"])
    seen = seen_until(streams, 30.0, 40.0)
    found = bound(setup, seen, day, (1.0, 61.0))
    for name, value in dataclasses.asdict(plain).items():
        assert dataclasses.asdict(found)[name] == pytest.approx(value, rel=0.15), name


def without(streams, *names):
    return Streams({name: table for name, table in streams.tables.items() if name not in names})


def first_order_noise(transition, process, n, seed=1):
    """A path of x' = A x + w, w ~ Q, less its mean."""
    rng, x = np.random.default_rng(seed), np.zeros((n, len(transition)))
    steps = rng.multivariate_normal(np.zeros(len(transition)), process, n)
    for k in range(1, n):
        x[k] = transition @ x[k - 1] + steps[k]
    return x - x.mean(axis=0)


def with_errors(motion, correlation):
    """A motion whose wheels err: skid and the load's effect on the radius, correlated so far."""
    cross = np.array([[1.0, correlation], [correlation, 1.0]])
    errors = first_order_noise(0.9 * np.eye(2), 2e-7 * cross, len(motion.slip))
    if correlation == 0.0:  # to the last digit
        half = len(errors) // 2
        errors[: half + 1, 0] = errors[half:, 1] = 0.0
    return dataclasses.replace(motion, skid=errors[:, 0], unseen=errors[:, 1])


def test_a_first_order_process_is_found_again():
    transition = np.array([[0.9, 0.05], [0.0, 0.8]])
    process = np.array([[1.0, 0.6], [0.6, 0.5]])
    path = first_order_noise(transition, process, 200_000)
    found, noise = first_order(path, np.ones(len(path), bool))
    assert found == pytest.approx(transition, abs=0.01)
    assert noise == pytest.approx(process, abs=0.02)
    cov = path.T @ path / len(path)
    assert found @ cov @ found.T + noise == pytest.approx(cov, rel=1e-9)


def test_errors_without_correlation_are_processes_of_their_own():
    motion = with_errors(motion_of(moving()[2], SETUP, 0.02, drives_at(moving()[2])), 0.0)
    both = np.stack([motion.skid, motion.unseen, np.zeros_like(motion.skid)], 1)
    found, noise = first_order(both, motion.counted)
    for i in range(2):
        alone, of_it = first_order(both[:, i : i + 1], motion.counted)
        assert found[i, i] == pytest.approx(alone[0, 0], rel=1e-9)
        assert noise[i, i] == pytest.approx(of_it[0, 0], rel=1e-9)
    assert (found - np.diag(np.diag(found)) == 0.0).all()
    assert (found[2] == 0.0).all()
    assert noise - np.diag(np.diag(noise)) == pytest.approx(np.zeros((3, 3)), abs=1e-20)


@pytest.mark.parametrize(("correlation", "least", "most"), [(0.0, 1.0, 1.0), (0.9, 1.02, 2.0)])
def test_what_no_counter_shows_adds_to_the_bound(correlation, least, most):
    """Without correlation the variances add. A skid that goes with it hides it in the counts."""
    setup, streams, truth = moving()
    streams = without(streams, "machine")  # whose error may go with those two by chance
    plain = motion_of(truth, setup, 0.02, drives_at(truth))
    errs = with_errors(plain, correlation)
    skids = dataclasses.replace(errs, unseen=np.zeros_like(errs.unseen))
    found, apart = (
        steady(model.system)[0][model.at["slip"], model.at["slip"]]
        for model in (along_body(setup, streams, truth, m, 0.02, truth) for m in (errs, skids))
    )
    ratio = found / (apart + np.mean(errs.unseen[errs.counted] ** 2))
    assert least - 1e-6 <= ratio <= most + 1e-6


@pytest.mark.parametrize("kind", ["across", "along", "along, errors alike", "along, errors one"])
@pytest.mark.parametrize("gap", [True, False])
def test_every_stream_counts_as_in_a_posterior_by_brute_force(kind, gap):
    setup, streams, truth = moving()
    drives, across = drives_at(truth), kind == "across"
    if across:
        model, name = across_body(setup, streams, truth, 0.02, drives), "v_y"
    else:
        motion = motion_of(truth, setup, 0.02, drives)
        if kind != "along":
            motion = with_errors(motion, 0.8 if "alike" in kind else 1.0)
        model, name = along_body(setup, streams, truth, motion, 0.02, truth), "slip"
    assert {"gnss", "camera"} <= set(model.of)
    assert across or {"wheels", "imu", "machine"} <= set(model.of)
    seen = np.ones((30, len(model.of)), bool)
    if gap:
        seen[5:20, [sensor == "gnss" for sensor in model.of]] = False
    after, _ = steady(model.system)
    first = model.system.transition @ after @ model.system.transition.T + model.system.process
    causal, offline = by_brute_force(model.system, first, seen, model.at[name])
    longer = np.ones((800, len(model.of)), bool)
    longer[400:430] = seen
    by_filter, by_smoother = through(model.system, longer, model.at[name])
    assert by_filter[400:430] == pytest.approx(causal, rel=1e-3)
    assert (by_smoother[400:430] <= offline * 1.001).all()  # it knows what comes after, too
    assert by_smoother[400] == pytest.approx(offline[0], rel=0.05)


@pytest.mark.parametrize(
    ("names", "of", "worse"),
    [
        (("camera",), "sideslip_causal_rad", 1.5),
        (("camera", "imu"), "sideslip_causal_rad", 1.6),
        (("camera",), "speed_causal_mps", 1.0),
        (("machine",), "slip_causal", 1.0),
    ],
)
def test_a_stream_less_is_a_larger_bound(names, of, worse):
    setup, streams, truth = moving()
    all_of_them = bound(setup, streams, truth, (1.0, 61.0))
    fewer = bound(setup, without(streams, *names), truth, (1.0, 61.0))
    assert getattr(fewer, of) > worse * getattr(all_of_them, of)


def test_a_gyro_averages_the_noise_of_a_heading():
    """Without it every heading stands for itself."""
    setup, streams, truth = moving()
    streams = without(streams, "camera")
    setup = dataclasses.replace(
        setup, gnss=dataclasses.replace(setup.gnss, heading_sd_rad=0.05, velocity_sd_mps=0.002)
    )
    with_gyro = bound(setup, streams, truth, (1.0, 61.0)).sideslip_causal_rad
    alone = bound(setup, without(streams, "imu"), truth, (1.0, 61.0)).sideslip_causal_rad
    assert with_gyro < 0.5 * alone

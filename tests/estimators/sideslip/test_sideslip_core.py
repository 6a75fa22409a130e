"""The filter's Jacobians against finite differences, its kinematics against a rotation matrix."""

import numpy as np
import pytest
from slides import SETUP

from estimators.sideslip_ekf import SideslipEkf, layout, motion, rows, update
from estimators.sideslip_ekf.layout import ENTRIES, SIZE

IMU = np.array([0.03, -0.02, 0.21, 0.4, 1.3])
LEAN, DT, SHORT, STEP = 0.12, 0.02, 1e-5, 1e-6


@pytest.fixture(params=[False, True], ids=["felt", "seen"])
def parts(request):
    """Nominal, memory with everything felt, and a state far from zero in all its parts.

    How the body stands is felt, or seen by a camera.
    """
    memory = layout.first_memory()[0]
    memory["heard"] = 1
    memory["grade"] = 0.05
    memory["tilted"], memory["tilt"] = request.param, (0.1, 0.15)
    x = np.random.default_rng(3).uniform(0.05, 0.2, SIZE)
    x[layout.V_X], x[layout.HEADING] = 1.7, 2.3
    return layout.nominal(SETUP)[0], memory, x


def slope(f, x):
    """df/dx by central differences."""
    columns = []
    for i in range(SIZE):
        ends = []
        for sign in (1.0, -1.0):
            moved = x.copy()
            moved[i] += sign * STEP
            ends.append(np.asarray(f(moved)))
        columns.append((ends[0] - ends[1]) / (2 * STEP))
    return np.array(columns).T


def test_the_transition_is_the_derivative_of_the_motion(parts):
    nominal, memory, x = parts
    nominal["camera_m"] = 0.98, 0.1, 0.3

    def moved(x):
        after = x.copy()
        motion.step(after, IMU, LEAN, SHORT, nominal, memory)
        return after

    at, value = np.zeros((ENTRIES, 2), np.int64), np.zeros(ENTRIES)
    n = motion.entries(x, IMU, LEAN, SHORT, nominal, memory, at, value)
    assert n <= ENTRIES
    f = np.eye(SIZE)
    np.add.at(f, (at[:n, 0], at[:n, 1]), value[:n])
    # of a short step: what the step's square adds is left out
    np.testing.assert_allclose((f - slope(moved, x)) / SHORT, 0.0, atol=2e-4)


MEASURED = {
    "azimuth": lambda x, o, m, h: rows.azimuth(x, -1.2, h),
    "ahead": lambda x, o, m, h: rows.velocity(x, IMU, LEAN, False, o, m, h),
    "left": lambda x, o, m, h: rows.velocity(x, IMU, LEAN, True, o, m, h),
    "east": lambda x, o, m, h: rows.place(x, False, o, h),
    "north": lambda x, o, m, h: rows.place(x, True, o, h),
    "slide": lambda x, o, m, h: rows.slide(x, IMU, o, h),
    "camera ahead": lambda x, o, m, h: rows.camera_ahead(x, IMU, LEAN, o, m, h),
    "camera aside": lambda x, o, m, h: rows.camera_aside(
        x, np.array([1.5, 0.2, 0.033]), True, 0.0, LEAN, o, m, h
    ),
    "first frame": lambda x, o, m, h: rows.camera_aside(
        x, np.array([1.5, 0.2, 0.033]), False, rows.camera_left(x, IMU, LEAN, o, m), LEAN, o, m, h
    ),
}


@pytest.mark.parametrize("name", MEASURED)
def test_each_row_is_the_derivative_of_what_is_measured(parts, name):
    nominal, memory, x = parts
    h, scrap = np.zeros(SIZE), np.zeros(SIZE)
    MEASURED[name](x, nominal, memory, h)
    exact = slope(lambda x: MEASURED[name](x, nominal, memory, scrap), x)
    if name == "ahead" or name == "left":  # the axes turn with the heading; the row knows it
        other = MEASURED["left" if name == "ahead" else "ahead"](x, nominal, memory, scrap)
        exact[layout.HEADING] += -other if name == "ahead" else other
    if "camera" in name or name == "first frame":  # left out on purpose
        h[layout.GYRO_SCALE] = exact[layout.GYRO_SCALE] = 0.0
    np.testing.assert_allclose(h, exact, atol=1e-6)


def test_the_baseline_is_turned_as_a_rotation_turns_it(parts):
    *_, x = parts
    yaw, roll, pitch = x[layout.HEADING], x[layout.ROLL], x[layout.PITCH]
    cos, sin = np.cos, np.sin
    rx = np.array([[1, 0, 0], [0, cos(roll), -sin(roll)], [0, sin(roll), cos(roll)]])
    ry = np.array([[cos(pitch), 0, sin(pitch)], [0, 1, 0], [-sin(pitch), 0, cos(pitch)]])
    rz = np.array([[cos(yaw), -sin(yaw), 0], [sin(yaw), cos(yaw), 0], [0, 0, 1]])
    direction = rz @ ry @ rx @ (cos(-1.2), sin(-1.2), 0.0)
    due = np.arctan2(direction[1], direction[0]) + x[layout.MISALIGNED]
    seen = rows.azimuth(x, -1.2, np.zeros(SIZE))
    assert np.exp(1j * seen) == pytest.approx(np.exp(1j * due), abs=1e-12)


def test_a_camera_tells_how_the_body_stands_on_the_ground(parts):
    _, memory, x = parts
    if not memory["tilted"]:
        return
    turned, up, sunk, nose = 0.03, 0.01, 0.16, 0.02
    x[layout.CAMERA_YAW], x[layout.CAMERA_PITCH] = turned, up
    cos, sin = np.cos, np.sin
    rolled = np.array([[1, 0, 0], [0, cos(sunk), -sin(sunk)], [0, sin(sunk), cos(sunk)]])
    nosed = np.array([[cos(nose), 0, sin(nose)], [0, 1, 0], [-sin(nose), 0, cos(nose)]])
    yawed = np.array([[cos(turned), -sin(turned), 0], [sin(turned), cos(turned), 0], [0, 0, 1]])
    raised = np.array([[cos(up), 0, -sin(up)], [0, 1, 0], [sin(up), 0, cos(up)]])
    ahead, left, above = raised.T @ yawed.T @ (nosed @ rolled).T @ (0.0, 0.0, 1.0)
    memory["tilt"] = ahead / above, left / above
    assert motion.stance(x, 0.0, memory) == pytest.approx((sunk, nose), abs=3e-4)


def test_the_covariance_is_carried_as_the_product_is(parts):
    nominal, memory, x = parts
    at, value = np.zeros((ENTRIES, 2), np.int64), np.zeros(ENTRIES)
    n = motion.entries(x, IMU, LEAN, DT, nominal, memory, at, value)
    f = np.eye(SIZE)
    np.add.at(f, (at[:n, 0], at[:n, 1]), value[:n])
    root = np.random.default_rng(0).standard_normal((SIZE, SIZE))
    p = root @ root.T
    due = f @ p @ f.T
    motion.carry(p, at, value, n, np.empty((SIZE, SIZE)))
    np.testing.assert_allclose(p, due, rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(p, p.T)


def test_an_update_is_kalmans_within_the_gate_and_bounded_beyond():
    root = np.random.default_rng(1).standard_normal((SIZE, SIZE))
    p, x = root @ root.T, np.zeros(SIZE)
    h = np.random.default_rng(2).standard_normal(SIZE)
    total = h @ p @ h + 0.5
    after, cov = x.copy(), p.copy()
    update.take(after, cov, h, 1.0, 0.5, 3.0)
    np.testing.assert_allclose(after, p @ h / total, rtol=1e-12)
    np.testing.assert_allclose(cov, p - np.outer(p @ h, p @ h) / total, rtol=1e-9, atol=1e-12)
    far = []
    for error in (3.0, 30.0, 300.0):
        moved, cov = x.copy(), p.copy()
        update.take(moved, cov, h, error * np.sqrt(total), 0.5, 3.0)
        far.append(h @ moved / np.sqrt(total))
        assert np.linalg.eigvalsh(cov).min() > -1e-9
    assert far[0] > 0.0
    assert max(far) <= 3.0


def test_at_rest_on_a_slope_nothing_moves(parts):
    nominal, memory, x = parts
    x[:] = 0.0
    x[layout.ROLL] = LEAN
    felt = np.array([0.0, 0.0, 0.0, 0.0, 9.81 * np.sin(LEAN)])
    for _ in range(50):
        motion.step(x, felt, LEAN, DT, nominal, memory)
    np.testing.assert_allclose(x[[layout.V_X, layout.V_Y, layout.SLIDE]], 0.0, atol=1e-12)


def test_the_values_it_can_be_tuned_by_are_told_to_the_compiled_code():
    state = SideslipEkf(push_sd=0.07).init(SETUP)
    assert state.tuning["push_sd"][0] == 0.07

import numpy as np
import pytest
from scipy.linalg import expm

from estimators.four_state import white_jerk
from estimators.fusion import fuse
from estimators.kalman import predict, slip_and_sd, update

RNG = np.random.default_rng(5)


def covariance(n):
    root = RNG.standard_normal((n, n))
    return root @ root.T + np.eye(n)


def test_predict_and_update_are_the_matrix_formulas():
    x, p, f, q = RNG.standard_normal(4), covariance(4), RNG.standard_normal((4, 4)), covariance(4)
    x_is, p_is = x.copy(), p.copy()
    predict(x_is, p_is, f, q)
    x, p = f @ x, f @ p @ f.T + q
    assert x_is == pytest.approx(x)
    assert p_is == pytest.approx(p)

    h, r = RNG.standard_normal((3, 4)), np.array([0.5, 1.0, 2.0])
    z = RNG.standard_normal(3)
    for row in range(3):
        update(x_is, p_is, h[row], z[row], r[row])
    gain = p @ h.T @ np.linalg.inv(h @ p @ h.T + np.diag(r))
    assert x_is == pytest.approx(x + gain @ (z - h @ x))
    assert p_is == pytest.approx(p - gain @ h @ p)


@pytest.mark.parametrize(("z", "r"), [(np.nan, 1.0), (1.0, np.nan), (np.inf, 1.0)])
def test_update_skips_what_was_not_measured(z, r):
    x, p = np.ones(2), np.eye(2)
    assert np.isnan(update(x, p, np.ones(2), z, r))
    assert (x == 1).all()
    assert (p == np.eye(2)).all()


def test_white_jerk_is_the_exact_discretisation():
    """Van Loan (1978): Q = F G with [[-A, L psd L'], [0, A']] exponentiated."""
    a, dt, psd = np.array([[0.0, 1.0], [0.0, 0.0]]), 0.3, 0.7
    block = np.block([[-a, np.diag([0.0, psd])], [np.zeros((2, 2)), a.T]]) * dt
    exponential = expm(block)
    f, q = white_jerk(dt, psd, 2)
    assert f == pytest.approx(exponential[2:, 2:].T)
    assert q == pytest.approx(exponential[2:, 2:].T @ exponential[:2, 2:])


@pytest.mark.parametrize(
    ("wheel", "ground"), [(2.0, 1.6), (1.6, 2.0), (-2.0, -1.6), (-1.6, -2.0), (0.03, 0.01), (2, -1)]
)
def test_slip_sd_follows_from_the_slope_of_slip(wheel, ground):
    p = np.array([[4e-4, 1e-4], [1e-4, 9e-4]])

    def slip(w, v):
        return (w - v) / max(abs(w), abs(v), 0.05)

    d = 1e-6
    slope = np.array(
        [
            slip(wheel + d, ground) - slip(wheel - d, ground),
            slip(wheel, ground + d) - slip(wheel, ground - d),
        ]
    ) / (2 * d)
    value, sd = slip_and_sd(wheel, ground, p[0, 0], p[1, 1], p[0, 1])
    assert value == pytest.approx(slip(wheel, ground))
    assert sd == pytest.approx(np.sqrt(slope @ p @ slope), rel=1e-6)


def test_slip_that_saturates_has_the_sd_of_the_speeds_apart():
    """Wheels that stand under a ground speed of 0.1 m/s that is as well 0: slip is -1, or 0."""
    value, sd = slip_and_sd(0.0, 0.1, 1e-6, 0.05**2, 0.0)
    assert value == -1.0
    assert sd == pytest.approx(0.5, rel=1e-3)
    _, sure = slip_and_sd(0.0, 1.5, 1e-6, 0.05**2, 0.0)
    assert sure < 1e-3


def test_fusion_is_the_inverse_covariance_mean():
    x1, x2, p1, p2 = *RNG.standard_normal((2, 3)), covariance(3), covariance(3)
    information = np.linalg.inv(p1), np.linalg.inv(p2)
    p = np.linalg.inv(information[0] + information[1])
    x, p_is = fuse(x1, p1, x2, p2)
    assert p_is == pytest.approx(p)
    assert x == pytest.approx(p @ (information[0] @ x1 + information[1] @ x2))

"""The IMU's anti-alias filter: a digital Butterworth low-pass with an explicit state.

It is written out here because importing scipy.signal takes longer than a short run; the tests
compare it with scipy's.
"""

from __future__ import annotations

import math

import numpy as np

from twin.sensors.noise import Array


def low_pass(order: int, cut_hz: float, rate_hz: float) -> Array:
    """Second-order sections of a Butterworth low-pass, shape (sections, 6).

        w = 4 tan(pi f / rate),  p_m = -w exp(i pi m / 2 N),  m = -N + 1, -N + 3, ... N - 1
        z_m = (4 + p_m) / (4 - p_m),  gain = w**N / prod(4 - p_m)

    by the bilinear transform, with f = `cut_hz` (-3 dB), rate = `rate_hz` and N = `order`. Poles
    near the unit circle come last, and the first section has the gain. Source: Oppenheim and
    Schafer, Discrete-Time Signal Processing, 7.1.
    """
    warped = 4.0 * math.tan(math.pi * (cut_hz / (0.5 * rate_hz)) / 2.0)
    m = np.arange(-order + 1, order, 2)
    poles = warped * -np.exp(1j * np.pi * m / (2 * order))
    gain = warped**order * np.real(1.0 / np.prod(4.0 - poles))
    placed = (4.0 + poles) / (4.0 - poles)
    upper = placed[placed.imag > 1e-12]
    sections = [[1.0, 1.0, 0.0, 1.0, -p.real, 0.0] for p in placed[np.abs(placed.imag) <= 1e-12]]
    for pole in upper[np.argsort(np.abs(upper))]:
        squared = (pole * pole.conjugate()).real
        sections.append([1.0, 2.0, 1.0, 1.0, -2.0 * pole.real, squared])
    out = np.array(sections)
    out[0, :3] *= gain
    return out


def group_delay_s(sections: Array, rate_hz: float) -> float:
    """Delay of a slow signal: the filter's group delay at zero frequency [s].

        d = sum over sections of (sum k b_k / sum b_k - sum k a_k / sum a_k) / rate

    A Butterworth filter's delay grows towards its cut-off; by 6 % at a third of it for order 4.
    """
    k = np.arange(3.0)
    samples = 0.0
    for section in sections:
        b, a = section[:3], section[3:]
        samples += float(np.sum(k * b) / np.sum(b) - np.sum(k * a) / np.sum(a))
    return samples / rate_hz


def settled(sections: Array, value: Array) -> Array:
    """Filter state after a constant input `value` (m,) of infinite length. Shape (sections, 2, m).

    z = A z + B with A the transposed companion matrix of a, and B_k = b_k - a_k b_0.
    """
    scale, state = 1.0, np.empty((len(sections), 2))
    for i, (b0, b1, b2, _, a1, a2) in enumerate(sections):
        matrix = np.array([[1.0 + a1, -1.0], [a2, 1.0]])
        state[i] = scale * np.linalg.solve(matrix, np.array([b1 - a1 * b0, b2 - a2 * b0]))
        scale *= (b0 + b1 + b2) / (1.0 + a1 + a2)
    return np.asarray(state[:, :, None] * value)


def filtered(sections: Array, state: Array, x: Array) -> tuple[Array, Array]:
    """State of the filter after the input x (n, m), and its output (n, m).

    It works sample by sample, so the output is the same bit for bit however x is cut (tested).
    """
    from twin.sensors.sections import run_sections  # late: numba is slow to import

    x = np.ascontiguousarray(x)  # one layout, compiled once
    after, y = state.copy(), np.empty(x.shape)
    run_sections(sections, after, x, y)
    return after, y

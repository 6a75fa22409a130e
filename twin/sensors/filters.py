"""The IMU's anti-alias filter: a digital Butterworth low-pass that carries its state."""

from __future__ import annotations

import numpy as np

from twin.sensors.noise import Array


def low_pass(order: int, cut_hz: float, rate_hz: float) -> Array:
    """Second-order sections of a Butterworth low-pass, shape (sections, 6)."""
    from scipy.signal import butter  # late: importing it takes longer than the rest together

    return np.asarray(butter(order, cut_hz, fs=rate_hz, output="sos"), float)


def group_delay_s(sections: Array, rate_hz: float) -> float:
    """Delay of a slow signal, the group delay at zero frequency.

        d = sum over sections of (sum k b_k / sum b_k - sum k a_k / sum a_k) / rate

    A Butterworth's delay grows towards its cut; by 6 % at a third of it for order 4.
    """
    k = np.arange(3.0)
    samples = 0.0
    for section in sections:
        b, a = section[:3], section[3:]
        samples += float(np.sum(k * b) / np.sum(b) - np.sum(k * a) / np.sum(a))
    return samples / rate_hz


def settled(sections: Array, value: Array) -> Array:
    """Filter state after an endless constant input, shape (sections, 2, m)."""
    from scipy.signal import sosfilt_zi

    state: Array = np.asarray(sosfilt_zi(sections))[:, :, None] * value
    return state


def filtered(sections: Array, state: Array, x: Array) -> tuple[Array, Array]:
    """The filter's state after x and its output; x and output of shape (n, m).

    scipy's sosfilt works sample by sample, so cutting x anywhere changes no bit (tested).
    """
    from scipy.signal import sosfilt

    y, after = sosfilt(sections, x, axis=0, zi=state)
    return after, y

"""The anti-alias filter against scipy's."""

import numpy as np
import pytest
from scipy.signal import butter, sosfilt, sosfilt_zi, sosfreqz

from twin.sensors.filters import filtered, low_pass, settled


@pytest.mark.parametrize(("order", "cut_hz", "rate_hz"), [(4, 15.0, 200.0), (6, 30.0, 400.0)])
def test_it_is_scipys_to_the_bit(order: int, cut_hz: float, rate_hz: float) -> None:
    sections = butter(order, cut_hz, fs=rate_hz, output="sos")
    np.testing.assert_array_equal(low_pass(order, cut_hz, rate_hz), sections)
    x = np.random.default_rng(1).standard_normal((500, 6))
    start = settled(sections, x[0])
    np.testing.assert_array_equal(start, sosfilt_zi(sections)[:, :, None] * x[0])
    after, y = filtered(sections, start, x)
    due, due_after = sosfilt(sections, x, axis=0, zi=start)
    np.testing.assert_array_equal(y, due)
    np.testing.assert_array_equal(after, due_after)


@pytest.mark.parametrize("order", [5, 7, 9, 10])
def test_other_orders_have_the_same_response(order: int) -> None:
    sections = low_pass(order, 20.0, 200.0)
    _, ours = sosfreqz(sections, 256)
    _, due = sosfreqz(butter(order, 20.0, fs=200.0, output="sos"), 256)
    np.testing.assert_allclose(ours, due, rtol=1e-9, atol=1e-12)
    x = np.ones((50, 1))
    _, y = filtered(sections, settled(sections, x[0]), x)
    np.testing.assert_allclose(y, 1.0, rtol=1e-9)

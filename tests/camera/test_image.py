import numpy as np
import pytest

from tests.camera.views import LENS
from twin.camera.image import DAYLIGHT_S, Sensitivity, develop

SHAPE = (LENS.height_px, LENS.width_px)
QUIET = Sensitivity(full_well_e=1e9, read_noise_e=0.0)


def flat(brightness):
    return np.full(SHAPE, brightness, np.float32)


def test_light_falls_off_as_cos4():
    image = develop(flat(200.0), LENS, QUIET, 1, 0)
    angle = np.arctan(np.hypot(639.5, 399.5) / LENS.focal_px)
    assert image[399, 639] == 200
    assert abs(int(image[0, 0]) - 200 * np.cos(angle) ** 4) <= 1.0
    even = develop(flat(200.0), LENS, Sensitivity(full_well_e=1e9, vignetting=0.0), 1, 0)
    assert np.all(even == 200)


@pytest.mark.parametrize("brightness", [20.0, 120.0])
def test_noise_is_shot_and_read(brightness):
    pixel = Sensitivity(full_well_e=2000.0, read_noise_e=10.0, vignetting=0.0)
    image = develop(flat(brightness), LENS, pixel, 1, 0).astype(float)
    electrons = brightness * 2000.0 / 255.0
    expected = (electrons + 10.0**2) * (255.0 / 2000.0) ** 2 + 1 / 12  # and rounding
    assert image.mean() == pytest.approx(brightness, abs=0.05)
    assert image.var() == pytest.approx(expected, rel=0.02)
    assert abs(np.mean(((image - image.mean()) / image.std()) ** 3)) < 0.05
    neighbours = np.corrcoef(image[:, :-1].ravel(), image[:, 1:].ravel())[0, 1]
    assert abs(neighbours) < 0.005


def test_noise_is_keyed_by_seed_and_frame():
    frames = [develop(flat(100.0), LENS, Sensitivity(), s, k) for s, k in ((1, 0), (1, 1), (2, 0))]
    np.testing.assert_array_equal(frames[0], develop(flat(100.0), LENS, Sensitivity(), 1, 0))
    for other in frames[1:]:
        both = np.corrcoef(frames[0].ravel(), other.ravel())[0, 1]
        vignetting = develop(flat(100.0), LENS, QUIET, 1, 0).var() / frames[0].var()
        assert both == pytest.approx(vignetting, abs=0.01)  # only the shade is shared


def test_exposure_and_gain_brighten_until_it_saturates():
    even = {"full_well_e": 1e9, "read_noise_e": 0.0, "vignetting": 0.0}
    double = develop(flat(60.0), LENS, Sensitivity(exposure_s=2 * DAYLIGHT_S, **even), 1, 0)
    assert np.all(double == 120)
    assert np.all(develop(flat(60.0), LENS, Sensitivity(gain=10.0, **even), 1, 0) == 255)
    assert np.all(develop(flat(60.0), LENS, Sensitivity(gain=0.0, **even), 1, 0) == 0)

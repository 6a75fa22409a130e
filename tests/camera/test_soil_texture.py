import numpy as np
import pytest

from twin.camera.chance import keys
from twin.camera.ground import ground, patch
from twin.camera.soil_texture import TEXEL_M, TILE, add_noise, texture_keys, tile

KEY = texture_keys(3)


@pytest.mark.parametrize("level", [0, 1])
def test_tiles_meet_without_a_seam(level):
    here, right, below = (tile(KEY, i, j, level) for i, j in ((-1, 4), (0, 4), (-1, 5)))
    np.testing.assert_array_equal(here[:TILE, TILE], right[:TILE, 0])
    np.testing.assert_array_equal(here[TILE, :TILE], below[0, :TILE])


def test_a_tile_is_the_same_in_whatever_order_it_is_made():
    before = tile(KEY, 7, -2, 0)
    tile(KEY, 8, -2, 0)
    np.testing.assert_array_equal(tile(KEY, 7, -2, 0), before)
    assert np.any(tile(texture_keys(4), 7, -2, 0) != before)


def test_it_has_contrast_at_every_scale_that_odometry_can_use():
    soil = patch(ground(3), 0, 0, 16 * TILE).astype(float)
    assert 15.0 < soil.std() < 50.0
    for texels in (4, 16, 64, 256):  # 1 mm to 64 mm
        side = len(soil) // texels
        coarse = soil.reshape(side, texels, side, texels).mean(axis=(1, 3))
        assert np.diff(coarse, axis=0).std() > 3.0, f"nothing to see at {texels * TEXEL_M} m"


def test_nothing_repeats():
    soil = patch(ground(3), 0, 0, 16 * TILE).astype(float)
    spectrum = np.abs(np.fft.rfft2(soil - soil.mean())) ** 2
    spectrum[:4, :4] = spectrum[-4:, :4] = 0.0  # slow shades, correlated over any distance
    alike = np.fft.irfft2(spectrum)
    alike /= alike[0, 0]
    near = round(0.03 / TEXEL_M)
    alike[:near, :near] = alike[-near:, :near] = alike[:near, -near:] = alike[-near:, -near:] = 0.0
    assert np.abs(alike).max() < 0.1  # a tile that came again would correlate with itself


@pytest.mark.parametrize("shift", [1, 3, 5])
def test_noise_has_the_sd_it_is_asked_for(shift):
    field = np.zeros((1500, 1500), np.float32)
    add_noise(field, np.uint32(99), -70, 1234, shift, np.float32(2.0))
    cells = (1500 / 2**shift) ** 2
    assert field.std() == pytest.approx(2.0, rel=max(0.01, 4.0 / np.sqrt(cells)))
    assert abs(field.mean()) < 10.0 / np.sqrt(cells)


def test_keys_of_seeds_terms_and_numbers_are_their_own():
    made = [keys(1, "a", 0, 2), keys(2, "a", 0, 2), keys(1, "b", 0, 2), keys(1, "a", 1, 2)]
    assert len({tuple(k) for k in made}) == 4

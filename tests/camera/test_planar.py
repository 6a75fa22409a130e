import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from tests.camera.views import LENS, SMALL, view
from twin.camera.ground import SIDE, ground, patch
from twin.camera.pinhole import ground_from_pixel
from twin.camera.planar import planar
from twin.errors import OutOfRange


@pytest.mark.parametrize("place", [(0.0, 0.0), (-0.4, 70.3)])
def test_a_pixel_is_the_texture_where_its_ray_meets_the_ground(place):
    tilted = view(*place, turn_rad=(0.03, -0.02, 0.8))
    image = planar(SMALL, 5, 0.5).radiance(tilted)

    soil = ground(5)
    corner = [128 * int(np.floor((c / soil.texel_m - SIDE / 2) / 128)) for c in place]
    texels = patch(soil, *corner, SIDE).astype(float)
    v, u = np.mgrid[0 : SMALL.height_px, 0 : SMALL.width_px].astype(float)
    x, y, w = np.einsum(
        "ij,jvu->ivu", ground_from_pixel(SMALL, tilted), np.stack([u, v, np.ones_like(u)])
    )
    row = y / w / soil.texel_m - corner[1] - 0.5
    column = x / w / soil.texel_m - corner[0] - 0.5
    expected = map_coordinates(texels, [row, column], order=1)
    np.testing.assert_allclose(image, expected, atol=0.3)  # float32 places, on slopes of 100
    assert np.sqrt(np.mean((image - expected) ** 2)) < 0.02


def test_the_ground_is_the_same_after_driving_away_and_back():
    renderer = planar(SMALL, 5, 0.5)
    before = renderer.radiance(view(1.0, 2.0))
    for x in (1.5, 2.1, 3.0, -40.0):
        renderer.radiance(view(x, 2.3))
    np.testing.assert_array_equal(renderer.radiance(view(1.0, 2.0)), before)


def test_motion_blur_is_the_mean_of_what_is_seen_during_the_exposure():
    renderer = planar(SMALL, 5, 0.5)
    blurred = renderer.radiance(view(velocity_mps=(1.0, 0.5, 0), exposure_s=0.004))
    times_s = ((np.arange(64) + 0.5) / 64 - 0.5) * 0.004
    mean = np.mean([renderer.radiance(view(t, 0.5 * t)) for t in times_s], axis=0)
    sharp = renderer.radiance(view())
    assert np.std(sharp - mean) > 5.0  # there is blur to get right
    assert np.std(blurred - mean) < 0.1 * np.std(sharp - mean)


def test_a_higher_camera_gets_coarser_texels():
    near, far = planar(LENS, 5, 0.5), planar(LENS, 5, 1.2)
    assert near.soil.texel_m == 0.25e-3
    assert far.soil.texel_m == 0.5e-3
    assert far.radiance(view(height_m=1.2)).std() > 10.0


def test_more_ground_than_the_window_holds_is_refused():
    with pytest.raises(OutOfRange, match=r"ground in view = 3\.\d+ m is outside the 1\.02 m"):
        planar(LENS, 5, 0.5).radiance(view(height_m=4.0))

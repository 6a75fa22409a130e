import numpy as np
import pytest

from twin.logs.geodesy import ecef_m, enu_m, geodetic_rad


def test_ecef_of_known_places():
    # the semi-major axis at the equator, the semi-minor axis 6356752.3142 m at the pole (WGS 84)
    np.testing.assert_allclose(ecef_m(*np.zeros(3)), [6378137.0, 0.0, 0.0])
    pole = ecef_m(np.array(np.pi / 2), np.array(0.0), np.array(0.0))
    np.testing.assert_allclose(pole, [0.0, 0.0, 6356752.3142], atol=1e-4)


@pytest.mark.parametrize("latitude_deg", [-60.0, 0.0, 45.35])
def test_near_the_origin_it_is_the_radii_of_curvature(latitude_deg):
    a, f, h = 6378137.0, 1 / 298.257223563, 80.0
    e2 = f * (2 - f)
    lat, lon = np.radians(latitude_deg), np.radians(11.95)
    w2 = 1 - e2 * np.sin(lat) ** 2
    prime_m, meridian_m = a / np.sqrt(w2), a * (1 - e2) / w2**1.5
    d = 1e-6
    east, north, up = enu_m(
        lat + np.array([0.0, d]), lon + np.array([d, 0.0]), np.array([h, h + 1.0]), (lat, lon, h)
    )
    assert east[0] == pytest.approx((prime_m + h) * np.cos(lat) * d, rel=1e-6)
    assert north[1] == pytest.approx((meridian_m + h) * d, rel=1e-6)
    assert up[1] == pytest.approx(1.0, abs=1e-5)


def test_distance_is_that_of_ecef():
    generator = np.random.default_rng(0)
    lat, lon = (
        np.radians(45 + generator.normal(0, 0.05, 50)),
        np.radians(generator.normal(0, 0.05, 50)),
    )
    h = generator.normal(100, 50, 50)
    enu = np.stack(enu_m(lat, lon, h, (lat[0], lon[0], h[0])), axis=-1)
    xyz = ecef_m(lat, lon, h)
    apart = np.linalg.norm(xyz - xyz[0], axis=1)
    np.testing.assert_allclose(np.linalg.norm(enu, axis=1), apart, rtol=1e-9, atol=1e-8)


@pytest.mark.parametrize("place_m", [(0.0, 0.0, 0.0), (300.0, -200.0, 5.0), (-9e3, 4e3, -20.0)])
def test_geodetic_undoes_the_tangent_plane(place_m):
    origin = (*np.radians((45.35, 11.95)), 20.0)
    again = enu_m(*geodetic_rad(*map(np.asarray, place_m), origin), origin)
    np.testing.assert_allclose(again, place_m, atol=1e-5)

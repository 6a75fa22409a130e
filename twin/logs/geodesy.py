"""Latitude, longitude and height to local east, north, up on the WGS 84 ellipsoid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.streams import Array

SEMI_MAJOR_M = 6378137.0
"""Equatorial radius, WGS 84 (NIMA TR8350.2)."""
FLATTENING = 1.0 / 298.257223563
"""WGS 84 (NIMA TR8350.2)."""
ECCENTRICITY_SQ = FLATTENING * (2.0 - FLATTENING)


def ecef_m(latitude_rad: Array, longitude_rad: Array, height_m: Array) -> NDArray[np.float64]:
    """Earth-centred, earth-fixed position x, y, z [m]. Shape (..., 3).

    N = a / sqrt(1 - e2 sin(lat)^2)
    x = (N + h) cos(lat) cos(lon),  y = (N + h) cos(lat) sin(lon),  z = (N (1 - e2) + h) sin(lat)

    lat, lon: latitude and longitude [rad]. h: height above the ellipsoid [m]. a: semi-major axis
    [m], e2: squared eccentricity [-] of WGS 84.
    """
    normal_m = SEMI_MAJOR_M / np.sqrt(1.0 - ECCENTRICITY_SQ * np.sin(latitude_rad) ** 2)
    equatorial_m = (normal_m + height_m) * np.cos(latitude_rad)
    x = equatorial_m * np.cos(longitude_rad)
    y = equatorial_m * np.sin(longitude_rad)
    z = (normal_m * (1.0 - ECCENTRICITY_SQ) + height_m) * np.sin(latitude_rad)
    return np.stack([x, y, z], axis=-1)


def enu_m(
    latitude_rad: Array,
    longitude_rad: Array,
    height_m: Array,
    origin: tuple[float, float, float],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """East, north and up [m] of the tangent plane at `origin` (latitude, longitude [rad], height).

    [e n u] = R(lat0, lon0) (ecef - ecef0), exact; the radii of curvature alone would be
    16 cm off 1 km away.
    """
    lat, lon, _ = origin
    d = ecef_m(latitude_rad, longitude_rad, height_m) - ecef_m(*map(np.asarray, origin))
    x, y, z = d[..., 0], d[..., 1], d[..., 2]
    outward = np.cos(lon) * x + np.sin(lon) * y
    east = np.cos(lon) * y - np.sin(lon) * x
    north = np.cos(lat) * z - np.sin(lat) * outward
    up = np.cos(lat) * outward + np.sin(lat) * z
    return east, north, up


def geodetic_rad(
    east_m: Array, north_m: Array, up_m: Array, origin: tuple[float, float, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Latitude, longitude [rad] and height [m] of points of the tangent plane: undoes `enu_m`.

    tan(lat) = (z + e2 N sin(lat)) / p, iterated: five steps are exact to 1e-12 rad near the ground.
    """
    lat0, lon0, _ = origin
    x0, y0, z0 = ecef_m(*map(np.asarray, origin))
    outward = np.cos(lat0) * up_m - np.sin(lat0) * north_m
    x = x0 + np.cos(lon0) * outward - np.sin(lon0) * east_m
    y = y0 + np.sin(lon0) * outward + np.cos(lon0) * east_m
    z = z0 + np.cos(lat0) * north_m + np.sin(lat0) * up_m
    across = np.hypot(x, y)
    latitude = np.full_like(across, lat0)
    for _ in range(5):
        normal = SEMI_MAJOR_M / np.sqrt(1.0 - ECCENTRICITY_SQ * np.sin(latitude) ** 2)
        latitude = np.arctan2(z + ECCENTRICITY_SQ * normal * np.sin(latitude), across)
    normal = SEMI_MAJOR_M / np.sqrt(1.0 - ECCENTRICITY_SQ * np.sin(latitude) ** 2)
    height = across * np.cos(latitude) + z * np.sin(latitude) - (
        normal * (1.0 - ECCENTRICITY_SQ * np.sin(latitude) ** 2)
    )  # fmt: skip
    return latitude, np.arctan2(y, x), height

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
    """Earth-centred, earth-fixed position, shape (..., 3).

    N = a / sqrt(1 - e2 sin(lat)^2)
    x = (N + h) cos(lat) cos(lon),  y = (N + h) cos(lat) sin(lon),  z = (N (1 - e2) + h) sin(lat)
    """
    normal_m = SEMI_MAJOR_M / np.sqrt(1.0 - ECCENTRICITY_SQ * np.sin(latitude_rad) ** 2)
    equatorial_m = (normal_m + height_m) * np.cos(latitude_rad)
    x = equatorial_m * np.cos(longitude_rad)
    y = equatorial_m * np.sin(longitude_rad)
    z = (normal_m * (1.0 - ECCENTRICITY_SQ) + height_m) * np.sin(latitude_rad)
    return np.stack([x, y, z], axis=-1)


def near_deg(
    east_m: float, north_m: float, origin_deg: tuple[float, float, float]
) -> tuple[float, float]:
    """Latitude and longitude [deg] of a place near an origin (latitude, longitude [deg], height).

    lat = lat0 + n / M,  lon = lon0 + e / (N cos(lat0)),  M, N the radii of curvature: 16 cm off
    1 km away, and more with its square.
    """
    lat, lon, _ = origin_deg
    sine = np.sin(np.radians(lat))
    normal_m = SEMI_MAJOR_M / np.sqrt(1.0 - ECCENTRICITY_SQ * sine**2)
    meridian_m = normal_m * (1.0 - ECCENTRICITY_SQ) / (1.0 - ECCENTRICITY_SQ * sine**2)
    per_lon_m = normal_m * np.cos(np.radians(lat))
    north_deg, east_deg = np.degrees((north_m / meridian_m, east_m / per_lon_m))
    return lat + float(north_deg), lon + float(east_deg)


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

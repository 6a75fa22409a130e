"""Set-up of the sensors for estimators: values of data sheets and tape measure, no true errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import atan2, dist, sqrt

from twin.sensors import camera, own
from twin.sensors.suite import Sensors
from twin.streams import WHEELS, DepthSetup, GnssSetup, ImuSetup, Setup, WheelsSetup

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Geometry:
    """Nominal dimensions of a machine; positions are body axes from the rear-axle centre, m."""

    machine: str
    """Name of the machine."""
    wheelbase_m: float
    """Distance from front to rear axle, m."""
    track_front_m: float
    """Distance between the front wheels' centres, m."""
    track_rear_m: float
    """Distance between the rear wheels' centres, m."""
    cg_x_m: float
    """Distance of the centre of gravity, without implement, ahead of the rear axle, m."""
    wheel_radius_m: Mapping[str, float]
    """Nominal rolling radius by wheel (fl, fr, rl, rr), m."""
    antenna_main_m: Vector
    """Main GNSS antenna."""
    antenna_aux_m: Vector
    """Auxiliary GNSS antenna."""
    imu_m: Vector
    """Inertial unit."""
    zero_slip: str = "law"
    """State in which slip by these radii is zero, one of `twin.streams.ZERO_SLIPS`."""
    depth_zero_m: float = 0.0
    """Laser range times cos(inclination) at zero working depth, m."""
    driven: tuple[str, ...] = ("rl", "rr")
    """Driven wheels."""
    origin: Vector | None = None
    """Latitude [deg], longitude [deg], height [m] of the world's origin."""


def setup(sensors: Sensors, geometry: Geometry) -> Setup:
    """The set-up of a machine and its sensors for estimators, from nominal values alone."""
    return Setup(
        machine=geometry.machine,
        wheelbase_m=geometry.wheelbase_m,
        track_front_m=geometry.track_front_m,
        track_rear_m=geometry.track_rear_m,
        cg_x_m=geometry.cg_x_m,
        driven=geometry.driven,
        origin=geometry.origin,
        wheels=_wheels(sensors, geometry),
        gnss=_gnss(sensors, geometry),
        imu=_imu(sensors, geometry),
        depth=_depth(sensors, geometry),
        camera=None if sensors.camera is None else camera.setup(sensors.camera),
        extra={sensor.stream: own.setup(sensor, geometry) for sensor in sensors.extra},
    )


def _wheels(sensors: Sensors, geometry: Geometry) -> WheelsSetup | None:
    if sensors.wheels is None:
        return None
    return WheelsSetup(
        rate_hz=sensors.wheels.rate_hz,
        radius_m={wheel: geometry.wheel_radius_m[wheel] for wheel in WHEELS},
        counts_per_turn=sensors.wheels.counts_per_turn,
        zero_slip=geometry.zero_slip,
        radius_sd=sensors.wheels.radius_error_sd / sqrt(2.0),
    )


def _gnss(sensors: Sensors, geometry: Geometry) -> GnssSetup | None:
    if sensors.gnss is None:
        return None
    main, aux = geometry.antenna_main_m, geometry.antenna_aux_m
    return GnssSetup(
        rate_hz=sensors.gnss.rate_hz,
        lever_arm_m=main,
        position_sd_m=sensors.gnss.position_sd_m,
        velocity_sd_mps=sensors.gnss.velocity_sd_mps,
        heading_sd_rad=sensors.gnss.heading_sd_rad_m / max(dist(main, aux), 1e-3),
        heading_mount_rad=atan2(aux[1] - main[1], aux[0] - main[0]),
    )


def _imu(sensors: Sensors, geometry: Geometry) -> ImuSetup | None:
    if sensors.imu is None:
        return None
    return ImuSetup(
        rate_hz=sensors.imu.rate_hz,
        lever_arm_m=geometry.imu_m,
        gyro_noise_radps_rthz=sensors.imu.gyro_noise_radps_rthz,
        accel_noise_mps2_rthz=sensors.imu.accel_noise_mps2_rthz,
        gyro_bias_sd_radps=sensors.imu.gyro_bias_sd_radps,
        accel_bias_sd_mps2=sensors.imu.accel_bias_sd_mps2,
    )


def _depth(sensors: Sensors, geometry: Geometry) -> DepthSetup | None:
    if sensors.depth is None:
        return None
    return DepthSetup(
        rate_hz=sensors.depth.rate_hz,
        zero_m=geometry.depth_zero_m,
        laser_sd_m=sensors.depth.laser_sd_m,
    )

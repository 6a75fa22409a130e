"""Driving along a cross-slope.

The electric tractor drives on the tilting platform of Liu et al. (2023), 12 m x 2 m: its rear
axle starts 0.3 m above the middle line, the wheels point straight ahead, the heading is free, and
the run ends when a corner of the vehicle comes to the platform's edge. The paper says neither where
the runs start nor how fast they are; both are declared here.
"""

from __future__ import annotations

from math import radians

from twin.scenario import Course, Drive, Field, Plough, Scenario, Soil
from twin.sensors import Camera, Gnss, Imu, Outage, Sensors

TAISHAN_8 = Scenario(
    name="slope-8-taishan",
    about="the tractor alone along an 8 degree cross-slope, 100 m, line held",
    field=Field(cross_slope_deg=8.0),
    course=Course(approach_m=15.0, length_m=100.0),
)

HEADING_BIAS_SD_RAD = radians(0.2)
UNDER_TRACTOR = Camera(position_m=(1.25, 0.0, -0.33), binning=4)
"""Under the tractor's belly, 0.5 m above ground."""


def _field(cross_slope_deg: float, *, ploughs: bool) -> Scenario:
    what, how = ("plough", "ploughs") if ploughs else ("taishan", "drives")
    return Scenario(
        name=f"slope-{cross_slope_deg:.0f}-{what}",
        about=f"the tractor {how} 60 m along a {cross_slope_deg:.0f} degree cross-slope",
        field=Field(cross_slope_deg=cross_slope_deg),
        plough=Plough() if ploughs else None,
        course=Course(approach_m=15.0, length_m=60.0, calibration_m=20.0),
        sensors=Sensors(gnss=Gnss(heading_bias_sd_rad=HEADING_BIAS_SD_RAD), camera=UNDER_TRACTOR),
    )


TAISHAN_5, TAISHAN_10 = (_field(slope, ploughs=False) for slope in (5.0, 10.0))
PLOUGH_5, PLOUGH_10 = (_field(slope, ploughs=True) for slope in (5.0, 10.0))

PLATFORM = Course(approach_m=0.0, length_m=11.0, start_left_m=0.3, hold_line=False, edge_m=1.0,
                  calibration_m=20.0)  # fmt: skip
"""From 0.1 m behind the platform's start to where a corner reaches its side or its end."""
ELECTRIC = Drive(gear_ratio=50.0, engine_set_rpm=2400.0, differential_lock=False)
"""About 1 m/s."""

CAMERA = Camera(position_m=(0.98, 0.0, 0.305), binning=4)
"""0.18 m ahead of the front axle, 0.5 m above ground; binned as the odometry would do itself."""


def _platform(cross_slope_deg: float, soil: str, *, masked: bool = False) -> Scenario:
    how = ", antennas masked" if masked else ""
    masks = (Outage(start_s=1.0, duration_s=60.0, kind="mask"),) if masked else ()
    return Scenario(
        name=f"slope-{cross_slope_deg:.0f}-{soil}{'-masked' if masked else ''}",
        about=f"electric tractor on a {cross_slope_deg:.0f} degree platform, {soil} soil{how}",
        machine="electric_tractor",
        soil=Soil(preset=soil),
        field=Field(cross_slope_deg=cross_slope_deg),
        drive=ELECTRIC,
        course=PLATFORM,
        sensors=Sensors(
            gnss=Gnss(outages=masks, heading_bias_sd_rad=HEADING_BIAS_SD_RAD),
            imu=Imu(vibration_rms_mps2=0.05),
            depth=None,
            machine=None,
            camera=CAMERA,
        ),
    )


DRY_6, DRY_9, DRY_12, DRY_18 = (_platform(slope, "dry") for slope in (6.0, 9.0, 12.0, 18.0))
WET_9, WET_18 = _platform(9.0, "wet"), _platform(18.0, "wet")
DRY_9_MASKED, DRY_18_MASKED = (_platform(slope, "dry", masked=True) for slope in (9.0, 18.0))
WET_9_MASKED, WET_18_MASKED = (_platform(slope, "wet", masked=True) for slope in (9.0, 18.0))

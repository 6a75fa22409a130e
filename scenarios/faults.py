"""Driving with one thing wrong at a time, and with all of it; what a good estimator answers.

While ploughing the fault begins 40 s into the run, at full depth and steady slip; along the slope,
for what a camera has, 3 s into its 9. What is expected is in each scenario's `about` and is
tested for `slip-ekf` and `sideslip-ekf`.
"""

from __future__ import annotations

from dataclasses import replace

from scenarios.plough import CM_25
from scenarios.slope import DRY_9
from twin.scenario import Course, Scenario
from twin.sensors import Fault, Sensors

START_S = 40.0
EXPECTED: dict[str, tuple[float, float, str]] = {
    "gnss-dropout": (10.0, 0.015, "slip goes on from the front wheels"),
    "gnss-spike": (0.4, 0.015, "the spike is refused and flagged"),
    "gnss-frozen": (10.0, 0.03, "a speed that no longer moves is refused when it does not fit"),
    "gnss-late": (10.0, 0.015, "late samples are taken at their own epoch"),
    "wheels-stuck": (10.0, 0.10, "slip goes on as it was, its sd grows tenfold"),
    "wheel-stuck": (10.0, 0.015, "the other rear wheel stands for the axle, flagged"),
    "wheel-missed": (10.0, 0.08, "half of the missed ticks passes for slip: nothing tells it"),
    "imu-saturated": (10.0, 0.015, "a little more noise"),
    "imu-bias": (
        10.0,
        0.12,
        "taken for a motion at first, up to half a second of it with too small an sd, then learnt "
        "as a bias",
    ),
    "imu-back": (2.0, 0.015, "samples older than the newest are put aside, flagged"),
}
"""Fault -> how long it lasts [s], the largest error of slip in its ten seconds, and the answer."""
TOGETHER = ("gnss-spike", "gnss-late", "wheel-stuck", "imu-saturated", "imu-bias", "imu-back")
TOGETHER_LARGEST = 0.12
AFTER_S, AFTER_LARGEST = 20.0, 0.02
"""From so long after the fault's beginning slip is right again, within so much."""


def _failing(name: str, faults: tuple[Fault, ...], about: str) -> Scenario:
    return replace(
        CM_25,
        name=name,
        about=f"25 cm, from 40 s on {about}",
        course=Course(length_m=120.0),
        sensors=Sensors(faults=faults),
    )


def _one(kind: str) -> Scenario:
    duration_s, largest, answer = EXPECTED[kind]
    fault = Fault(kind=kind, start_s=START_S, duration_s=duration_s)
    about = f"{kind} for {duration_s:g} s: {answer}; slip within {100.0 * largest:g} points"
    return _failing(f"fault-{kind}", (fault,), about)


GNSS_DROPOUT, GNSS_SPIKE, GNSS_FROZEN, GNSS_LATE = (
    _one(kind) for kind in ("gnss-dropout", "gnss-spike", "gnss-frozen", "gnss-late")
)
WHEELS_STUCK, WHEEL_STUCK, WHEEL_MISSED = (
    _one(kind) for kind in ("wheels-stuck", "wheel-stuck", "wheel-missed")
)
IMU_SATURATED, IMU_BIAS, IMU_BACK = (
    _one(kind) for kind in ("imu-saturated", "imu-bias", "imu-back")
)
ALL = _failing(
    "fault-all",
    tuple(Fault(kind=k, start_s=START_S, duration_s=EXPECTED[k][0]) for k in TOGETHER),
    f"{', '.join(TOGETHER)} at once: slip within {100.0 * TOGETHER_LARGEST:g} points",
)

SLOPE_START_S, SLOPE_S = 3.0, 2.0
ON_SLOPE: dict[str, tuple[float, str]] = {
    "camera-black": (0.004, "no frame is used; the slide goes on as it was, its sd grows"),
    "camera-frozen": (0.004, "a frame that repeats itself is no standstill, and is not used"),
    "camera-dropout": (0.004, "the slide goes on as it was, its sd grows"),
    "camera-half": (0.002, "the first frame of each size is not used, the others are"),
}
"""Fault -> the largest error of the slide since its beginning [m], and the answer."""


def _blind(kind: str) -> Scenario:
    largest_m, answer = ON_SLOPE[kind]
    fault = Fault(kind=kind, start_s=SLOPE_START_S, duration_s=SLOPE_S)
    return replace(
        DRY_9,
        name=f"fault-{kind}",
        about=f"9 degree platform, {kind} for {SLOPE_S:g} s: {answer}; "
        f"slide within {1e3 * largest_m:g} mm",
        sensors=replace(DRY_9.sensors, faults=(fault,)),
    )


CAMERA_BLACK, CAMERA_FROZEN, CAMERA_DROPOUT, CAMERA_HALF = (_blind(kind) for kind in ON_SLOPE)

"""Unit, frame and meaning of every column of streams, truth and estimates.

The names of streams and estimates are in `twin.streams`, those of the truth in `twin.truth`; a
test compares all of them with these tables. `docs/columns.md` is written from here.

Frames: `world` is east, north, up; `body` is forward, left, up from the rear-axle centre; `ground`
is the plane of the ground under the wheels, its x axis the body's projected on it, y to the left.
`-` marks a number without a direction.

The module is longer than 300 lines because it is one table, with one row for each column.
"""

from __future__ import annotations

from typing import NamedTuple

from twin.streams import WHEELS


class Column(NamedTuple):
    """What one column holds."""

    unit: str
    """SI, or `-` for a pure number, `count`, `code`, `true/false`."""
    frame: str
    meaning: str


Columns = dict[str, Column]

WHEEL_NAMES = dict(
    zip(WHEELS, ("front left", "front right", "rear left", "rear right"), strict=True)
)

STAMPS: Columns = {
    "epoch_ns": Column("ns", "-", "instant that the sample describes, int64"),
    "arrival_ns": Column("ns", "-", "instant at which the sample reaches the estimator, int64"),
}
"""The first columns of every stream."""


def _each_wheel(name: str, unit: str, frame: str, meaning: str) -> Columns:
    """One column for each wheel; `{}` is the wheel in the name and in the meaning."""
    return {
        name.format(short): Column(unit, frame, meaning.format(long))
        for short, long in WHEEL_NAMES.items()
    }


STREAMS: dict[str, Columns] = {
    "gnss": {
        "east_m": Column("m", "world", "position of the main antenna, to the east"),
        "north_m": Column("m", "world", "position of the main antenna, to the north"),
        "up_m": Column("m", "world", "position of the main antenna, upwards"),
        "v_east_mps": Column("m/s", "world", "velocity of the main antenna, to the east"),
        "v_north_mps": Column("m/s", "world", "velocity of the main antenna, to the north"),
        "v_up_mps": Column("m/s", "world", "velocity of the main antenna, upwards"),
        "heading_rad": Column(
            "rad", "world", "heading of the antenna baseline, counter-clockwise from east"
        ),
        "quality": Column(
            "code", "-",
            "NMEA GGA: 4 fixed, 5 float, 1 single, 0 no solution; int64"
        ),
        "satellites_main": Column("count", "-", "satellites that the main antenna uses, int64"),
        "satellites_aux": Column("count", "-", "satellites that the second antenna uses, int64"),
        "position_sd_m": Column(
            "m", "world", "standard deviation that the receiver reports for its position, each "
            "horizontal axis"
        ),
        "velocity_sd_mps": Column(
            "m/s", "world", "standard deviation that the receiver reports for its velocity, each "
            "horizontal axis"
        ),
        "heading_sd_rad": Column(
            "rad", "world", "standard deviation that the receiver reports for its heading"
        ),
    },
    "imu": {
        "gyro_x_radps": Column(
            "rad/s", "body",
            "angular rate about the forward axis; positive lowers the right side"
        ),
        "gyro_y_radps": Column(
            "rad/s", "body",
            "angular rate about the left axis; positive lowers the front"
        ),
        "gyro_z_radps": Column(
            "rad/s", "body",
            "angular rate about the upward axis; positive turns to the left"
        ),
        "accel_x_mps2": Column(
            "m/s2", "body",
            "specific force forward; includes gravity unless the set-up's `imu.gravity` is false"
        ),
        "accel_y_mps2": Column("m/s2", "body", "specific force to the left; gravity as for x"),
        "accel_z_mps2": Column(
            "m/s2", "body",
            "specific force upwards; gravity as for x: then 9.81 at rest on level ground"
        ),
    },
    "wheels": {
        **_each_wheel(
            "ticks_{}", "count", "-",
            "encoder counts of the {} wheel since the start, int64"
        ),
        **_each_wheel(
            "speed_{}_mps", "m/s", "-",
            "rolling speed w R of the {} wheel with its nominal radius, where a source gives no "
            "ticks",
        ),
        "speed_sd_mps": Column("m/s", "-", "standard deviation of each of these rolling speeds"),
        **_each_wheel(
            "accel_{}_mps2", "m/s2", "-",
            "rate of change of the rolling speed of the {} wheel, where a source has it",
        ),
    },
    "depth": {
        "laser_m": Column(
            "m", "-",
            "distance from the laser on the plough frame to the ground, along the beam"
        ),
        "inclination_rad": Column(
            "rad", "world", "pitch of the plough frame from the horizontal, front up positive"
        ),
    },
    "machine": {
        "steer_rad": Column(
            "rad", "body", "mean steering angle of the front wheels, to the left positive"
        ),
        "hitch_m": Column(
            "m", "body",
            "height of the lower hitch points above the pivots of the lower links"
        ),
        "draft_pin_n": Column("N", "body", "draft at the pins of the lower links"),
        "axle_torque_nm": Column("N m", "-", "torque of the driven axle, both wheels together"),
        "engine_radps": Column("rad/s", "-", "speed of the engine's crankshaft"),
        "engine_load": Column(
            "-", "-",
            "engine torque over `sensors.machine.reference_torque_nm`; 0 to 1.25 in a simulation"
        ),
        "engine_torque": Column(
            "-", "-", "engine torque over the engine's reference torque (SPN 513), from logs alone"
        ),
        "fuel_lph": Column("L/h", "-", "fuel rate"),
    },
    "camera": {
        "frame": Column("count", "-", "number of the frame, the key of `Streams.frames`, int64"),
        "interval_s": Column("s", "-", "time between the two frames that were compared"),
        "v_x_mps": Column("m/s", "ground", "velocity of the optical centre, forward"),
        "v_y_mps": Column("m/s", "ground", "velocity of the optical centre, to the left"),
        "var_x_m2ps2": Column("m2/s2", "ground", "variance of `v_x_mps`"),
        "var_y_m2ps2": Column("m2/s2", "ground", "variance of `v_y_mps`"),
        "cov_xy_m2ps2": Column("m2/s2", "ground", "covariance of `v_x_mps` and `v_y_mps`"),
        "yaw_rad": Column(
            "rad", "ground",
            "yaw of the camera over the interval, positive to the left"
        ),
        "scale": Column(
            "-", "-",
            "height above the ground at this frame over that at the one before"
        ),
        "tilt_ahead_rad": Column(
            "rad", "-",
            "how far the ground's normal leans forward in the camera's axes, over some seconds"
        ),
        "tilt_left_rad": Column("rad", "-", "the same to the left"),
        "quality": Column("-", "-", "how well the two pictures match, 0 to 1"),
        "used": Column("true/false", "-", "whether the frame gave a velocity"),
        "reason": Column(
            "code",
            "-",
            "why no velocity, int8: 0 there is one, 1 first frame or after a gap, 2 no frame, "
            "3 one colour, 4 same frame again, 5 other size, 6 no match",
        ),
    },
}  # fmt: skip
"""Streams: sensor -> its columns beside the stamps. A sensor, or a column of it, may be absent."""

_POWERS = {
    "engine": "power of the crankshaft",
    "parasitic": "power taken by the engine's auxiliaries",
    "transmission": "power lost in the gearbox",
    "driveline": "power lost or stored in clutch, differential lock and front drive",
    "brake": "power taken by the brakes",
    "slip_long": "power lost by slip of the tyres along their rolling direction",
    "slip_lat": "power lost by slip of the tyres across it",
    "rolling": "power lost to motion resistance",
    "tyre": "power lost or stored in the tyres' springs and dampers",
    "wall": "power lost or stored at the furrow wall",
    "drawbar": "power lost to the soil at the shares and to the depth wheel's drag",
    "depth_wheel": "power lost or stored in the depth wheel's spring and damper",
    "joint": "power lost in the damping of joints",
    "lift": "power that the lift takes from the linkage",
    "steer": "power that the steering takes from the front wheels",
    "mass": "energy flow of added mass: negative while a tank is filled, positive while it is "
    "emptied",
    "contact": "power lost at MuJoCo's own contacts and joint limits",
    "step": "energy error of the time integration, which halves with the step",
}

_JOINTS = {
    **{
        f"{short}_spin": f"rotation of the {long} wheel, forward positive"
        for short, long in WHEEL_NAMES.items()
    },
    "fl_steer": "steering angle of the front left wheel, to the left positive",
    "fr_steer": "steering angle of the front right wheel, to the left positive",
    "front_swing": "swing of the front axle about the forward axis, right side down positive",
    "lift": "angle of the lower links, hitch points up positive",
    "plough_pitch": "pitch of the plough relative to the links, front down positive",
}

TRUTH: Columns = {
    "epoch_ns": Column("ns", "-", "instant of the row, int64; a row each 20 ms"),
    "east_m": Column("m", "world", "position of the rear-axle centre, to the east"),
    "north_m": Column("m", "world", "position of the rear-axle centre, to the north"),
    "up_m": Column("m", "world", "position of the rear-axle centre, upwards"),
    "qw": Column("-", "world", "rotation from body to world, scalar part of the quaternion"),
    "qx": Column("-", "world", "the same, x"),
    "qy": Column("-", "world", "the same, y"),
    "qz": Column("-", "world", "the same, z"),
    "v_x_mps": Column("m/s", "ground", "velocity of the centre of gravity, forward"),
    "v_y_mps": Column("m/s", "ground", "velocity of the centre of gravity, to the left"),
    "sideslip_rad": Column(
        "rad", "ground", "sideslip angle at the centre of gravity, NaN below 0.05 m/s"
    ),
    "sideslip_m": Column(
        "m", "ground", "sideslip amount at the centre of gravity: integral of `v_y_mps` since the "
        "start of the run"
    ),
    "v_x_rear_mps": Column("m/s", "ground", "velocity of the rear-axle centre, forward"),
    "v_y_rear_mps": Column("m/s", "ground", "velocity of the rear-axle centre, to the left"),
    "sideslip_rear_rad": Column(
        "rad", "ground", "sideslip angle at the rear-axle centre, NaN below 0.05 m/s"
    ),
    "sideslip_rear_m": Column(
        "m", "ground", "sideslip amount at the rear-axle centre: integral of `v_y_rear_mps` since "
        "the start of the run"
    ),
    "yaw_rate_radps": Column("rad/s", "ground", "yaw rate about the ground's normal"),
    "speed_mps": Column("m/s", "ground", "forward speed, the same as `v_x_rear_mps`"),
    "wheel_speed_mps": Column("m/s", "-", "mean of w R over the driven wheels, zero-slip R"),
    "slip": Column("-", "ground", "slip of the driven axle"),
    **_each_wheel("slip_{}", "-", "ground", "slip of the {} wheel"),
    **_each_wheel("load_{}_n", "N", "ground", "load on the {} wheel, normal to the ground"),
    **_each_wheel(
        "shear_{}_n", "N", "ground",
        "thrust by slip of the {} wheel, along its rolling direction, forward positive; motion "
        "resistance is not subtracted"
    ),
    "draft_n": Column(
        "N", "ground",
        "draft: soil force on the plough against the direction of travel"
    ),
    "depth_m": Column(
        "m", "ground",
        "working depth of the plough; 0 or negative out of the ground"
    ),
    "depth_wheel_n": Column("N", "ground", "load on the plough's depth wheel"),
    "plough_side_n": Column("N", "ground", "soil force on the plough, to the left"),
    "ploughing": Column(
        "true/false", "-",
        "from full depth until the plough is out of the ground; full depth is 95 % of the set "
        "depth, 50 % with `plough.hitch` draft or mix",
    ),
    "phase": Column(
        "code", "-",
        "what the driver is doing, int64: 0 stop, standing on purpose; 1 road, driven with the "
        "implement raised or without one; 2 turn, on a headland; 3 work, the implement lowered",
    ),
    "gear_ratio": Column(
        "-", "-", "engine turns per turn of the rear axle; negative in a reverse gear"
    ),
    "engine_radps": Column("rad/s", "-", "speed of the engine's crankshaft"),
    "engine_torque_nm": Column("N m", "-", "torque of the crankshaft"),
    "axle_torque_nm": Column("N m", "-", "torque of the driven axle, both wheels together"),
    "fuel_lph": Column("L/h", "-", "fuel rate"),
    **{f"joint_{name}_rad": Column("rad", "body", text) for name, text in _JOINTS.items()},
    **{
        f"power_{name}_w": Column("W", "-", f"{text}; mean until the next row")
        for name, text in _POWERS.items()
    },
    "kinetic_j": Column("J", "world", "kinetic energy"),
    "potential_j": Column("J", "world", "potential energy of gravity and of the model's springs"),
}  # fmt: skip
"""The truth of a simulated run. A scenario without a machine has some of these columns."""

ESTIMATES: Columns = {
    "epoch_ns": Column("ns", "-", "instant that the estimate describes, int64"),
    "speed_mps": Column("m/s", "ground", "forward speed of the rear-axle centre"),
    "wheel_speed_mps": Column("m/s", "-", "mean of w R over the driven wheels, R by the estimator"),
    "slip": Column("-", "ground", "slip of the driven axle"),
    "slip_sd": Column("-", "ground", "standard deviation of `slip`"),
    "slip_rl": Column("-", "ground", "slip of the rear left wheel"),
    "slip_rr": Column("-", "ground", "slip of the rear right wheel"),
    "sideslip_rad": Column("rad", "ground", "sideslip angle at the centre of gravity"),
    "sideslip_sd_rad": Column("rad", "ground", "standard deviation of `sideslip_rad`"),
    "v_y_mps": Column("m/s", "ground", "velocity of the centre of gravity, to the left"),
    "sideslip_m": Column("m", "ground", "sideslip amount at the centre of gravity"),
    "sideslip_sd_m": Column("m", "ground", "standard deviation of `sideslip_m`"),
    "sideslip_rear_rad": Column("rad", "ground", "sideslip angle at the rear-axle centre"),
    "sideslip_rear_m": Column("m", "ground", "sideslip amount at the rear-axle centre"),
    "flags": Column(
        "code", "-", "sum of the flags raised since the last estimate, int64; see below"
    ),
}
"""The columns of an estimate. An estimator gives `epoch_ns` and the columns it knows; an unknown
value is NaN."""

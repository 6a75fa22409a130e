"""A bag of ROS 2 in MCAP: fixes, velocities, IMU and joints, and a topic for each of the rest."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from twin.errors import BadInput
from twin.io.plain import Plain
from twin.logs.export import maps
from twin.plugins.extras import needed
from twin.streams import WHEELS, Array, Setup, Streams

JOINTS = {"fl": "front_left", "fr": "front_right", "rl": "rear_left", "rr": "rear_right"}
_HELD = {
    "gnss": {"east_m", "north_m", "up_m", "v_east_mps", "v_north_mps", "v_up_mps", "heading_rad"},
    "imu": {f"{kind}_{axis}_{unit}" for kind, unit in (("gyro", "radps"), ("accel", "mps2"))
            for axis in "xyz"},
    "wheels": {f"ticks_{w}" for w in WHEELS} | {f"speed_{w}_mps" for w in WHEELS},
}  # fmt: skip
_SCALARS = {
    "steer_rad": ("steer", "rad"), "hitch_m": ("hitch", "m"), "draft_pin_n": ("draft_pin", "N"),
    "axle_torque_nm": ("axle_torque", "Nm"), "engine_radps": ("engine_speed", "rad/s"),
    "engine_load": ("engine_load", "1"), "fuel_lph": ("fuel_rate", "L/h"),
    "laser_m": ("laser", "m"), "inclination_rad": ("inclination", "rad"),
}  # fmt: skip
"""Column -> key of a map and unit, of what has a topic of its own."""


def write_mcap(streams: Streams, setup: Setup, directory: Path) -> list[str]:
    """The bag `bag/` and `map.toml`; what is not in them. Raises BadInput."""
    rosbag2 = needed("rosbags.rosbag2", "ros", "bags", "rosbags")
    typesys = needed("rosbags.typesys", "ros", "bags", "rosbags")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    sections: dict[str, dict[str, dict[str, object]]] = {}
    plugin = rosbag2.StoragePlugin.MCAP
    with rosbag2.Writer(directory / "bag", version=9, storage_plugin=plugin) as writer:
        bag = _Bag(writer, store)
        if "gnss" in streams:
            sections["gnss"] = _gnss(bag, streams, setup)
        if "imu" in streams:
            sections["imu"] = _imu(bag, streams)
        if "wheels" in streams:
            sections["wheels"] = _wheels(bag, streams, setup)
        for sensor in ("machine", "depth"):
            if sensor in streams:
                sections[sensor] = _scalars(bag, streams, sensor)
    if not any(sections.values()):
        raise BadInput("the streams hold nothing that a bag can")
    (directory / "map.toml").write_text(maps.map_text(sections, setup), encoding="utf-8")
    held = _HELD | {s: set(_SCALARS) for s in ("machine", "depth")}
    return maps.left_out(streams, held)


class _Bag:
    """Messages into a bag."""

    def __init__(self, writer: Plain, store: Plain) -> None:
        self._writer, self._store = writer, store

    def make(self, kind: str, **fields: object) -> Plain:
        """A message of a type, `package/Name`."""
        package, _, name = kind.partition("/")
        return self._store.types[f"{package}/msg/{name}"](**fields)

    def header(self, epoch_ns: int, frame: str) -> Plain:
        """A header with its stamp."""
        stamp = self._store.types["builtin_interfaces/msg/Time"](
            sec=epoch_ns // 10**9, nanosec=epoch_ns % 10**9
        )
        return self.make("std_msgs/Header", stamp=stamp, frame_id=frame)

    def vector(self, x: float, y: float, z: float) -> Plain:
        """Three numbers."""
        return self.make("geometry_msgs/Vector3", x=float(x), y=float(y), z=float(z))

    def topic(
        self, name: str, kind: str, epochs: list[int], message: Callable[[int, int], Plain]
    ) -> None:
        """All messages of a topic: message(row, epoch_ns)."""
        package, _, short = kind.partition("/")
        full = f"{package}/msg/{short}"
        connection = self._writer.add_connection(name, full, typestore=self._store)
        for row, epoch_ns in enumerate(epochs):
            raw = self._store.serialize_cdr(message(row, epoch_ns), full)
            self._writer.write(connection, epoch_ns, raw)


def _source(column: str, unit: str, **more: object) -> dict[str, object]:
    return {"column": column, "unit": unit, **more}


def _gnss(bag: _Bag, streams: Streams, setup: Setup) -> dict[str, dict[str, object]]:
    table, sources = streams["gnss"], {}
    epochs = table["epoch_ns"].tolist()
    velocity = [streams.column("gnss", f"v_{axis}_mps") for axis in ("east", "north", "up")]
    zero = bag.vector(0.0, 0.0, 0.0)
    if np.isfinite(velocity[0]).any():
        bag.topic("/gnss/velocity", "geometry_msgs/TwistStamped", epochs, lambda i, t: bag.make(
            "geometry_msgs/TwistStamped", header=bag.header(t, "enu"), twist=bag.make(
                "geometry_msgs/Twist", linear=bag.vector(*(v[i] for v in velocity)), angular=zero,
            )))  # fmt: skip
        for axis, key in (("x", "v_east"), ("y", "v_north"), ("z", "v_up")):
            sources[key] = _source(f"/gnss/velocity.twist.linear.{axis}", "m/s")
    latitude, longitude, height = maps.geodetic(streams, setup)
    if np.isfinite(latitude).any():
        status = streams.column("gnss", "quality")
        bag.topic("/gnss/fix", "sensor_msgs/NavSatFix", epochs, lambda i, t: bag.make(
            "sensor_msgs/NavSatFix", header=bag.header(t, "antenna"),
            status=bag.make("sensor_msgs/NavSatStatus", status=_status(status[i]), service=1),
            latitude=float(latitude[i]), longitude=float(longitude[i]), altitude=float(height[i]),
            position_covariance=np.zeros(9), position_covariance_type=0,
        ))  # fmt: skip
        sources |= {
            "latitude": _source("/gnss/fix.latitude", "deg"),
            "longitude": _source("/gnss/fix.longitude", "deg"),
            "height": _source("/gnss/fix.altitude", "m"),
        }
    heading = streams.column("gnss", "heading_rad")
    if np.isfinite(heading).any():
        bag.topic("/gnss/heading", "geometry_msgs/QuaternionStamped", epochs, lambda i, t: bag.make(
            "geometry_msgs/QuaternionStamped", header=bag.header(t, "enu"), quaternion=bag.make(
                "geometry_msgs/Quaternion", x=0.0, y=0.0, z=math.sin(0.5 * heading[i]),
                w=math.cos(0.5 * heading[i]),
            )))  # fmt: skip
        sources["heading"] = _source("/gnss/heading.quaternion.yaw", "rad", convention="east")
    return sources


def _status(quality: float) -> int:
    """GGA quality -> NavSatStatus."""
    return {0: -1, 1: 0, 2: 1, 4: 2, 5: 2}.get(int(quality) if np.isfinite(quality) else 1, 0)


def _imu(bag: _Bag, streams: Streams) -> dict[str, dict[str, object]]:
    gyro = [streams.column("imu", f"gyro_{a}_radps") for a in "xyz"]
    accel = [streams.column("imu", f"accel_{a}_mps2") for a in "xyz"]
    unknown = np.zeros(9)
    unknown[0] = -1.0  # REP 145: no orientation
    still = bag.make("geometry_msgs/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
    bag.topic("/imu", "sensor_msgs/Imu", streams["imu"]["epoch_ns"].tolist(), lambda i, t: bag.make(
        "sensor_msgs/Imu", header=bag.header(t, "base_link"), orientation=still,
        orientation_covariance=unknown, angular_velocity=bag.vector(*(g[i] for g in gyro)),
        angular_velocity_covariance=np.zeros(9),
        linear_acceleration=bag.vector(*(a[i] for a in accel)),
        linear_acceleration_covariance=np.zeros(9),
    ))  # fmt: skip
    sources = {}
    for axis, turn, push in zip("xyz", gyro, accel, strict=True):
        if np.isfinite(turn).any():
            sources[f"gyro_{axis}"] = _source(f"/imu.angular_velocity.{axis}", "rad/s")
        if np.isfinite(push).any():
            sources[f"accel_{axis}"] = _source(f"/imu.linear_acceleration.{axis}", "m/s2")
    return sources


def _wheels(bag: _Bag, streams: Streams, setup: Setup) -> dict[str, dict[str, object]]:
    """Joints: angles of the wheels from their counts, or their rates from their speeds."""
    table, sources = streams["wheels"], {}
    counts = setup.wheels.counts_per_turn if setup.wheels else None
    wheels = [w for w in WHEELS if f"ticks_{w}" in table or f"speed_{w}_mps" in table]
    angle: dict[str, Array] = {}
    rate: dict[str, Array] = {}
    for wheel in wheels:
        label = JOINTS[wheel]
        if f"ticks_{wheel}" in table and counts:
            angle[label] = 2.0 * math.pi * table[f"ticks_{wheel}"] / counts
            sources[f"ticks_{wheel}"] = _source(f"/wheels.position[{label}]", "rad")
        elif setup.wheels and f"speed_{wheel}_mps" in table:
            rate[label] = table[f"speed_{wheel}_mps"] / setup.wheels.radius_m[wheel]
            sources[f"speed_{wheel}"] = _source(f"/wheels.velocity[{label}]", "rad/s")
    names = [*(angle or rate)]
    if names:
        bag.topic("/wheels", "sensor_msgs/JointState", table["epoch_ns"].tolist(), lambda i, t:
            bag.make("sensor_msgs/JointState", header=bag.header(t, "base_link"), name=names,
                     position=np.array([a[i] for a in angle.values()], np.float64),
                     velocity=np.array([r[i] for r in rate.values()], np.float64),
                     effort=np.empty(0)))  # fmt: skip
    return sources


def _scalars(bag: _Bag, streams: Streams, sensor: str) -> dict[str, dict[str, object]]:
    sources = {}
    for column, values in streams[sensor].items():
        if column in _SCALARS and np.isfinite(values).any():
            key, unit = _SCALARS[column]
            topic, epochs = f"/{sensor}/{key}", streams[sensor]["epoch_ns"].tolist()
            messages = [bag.make("std_msgs/Float64", data=float(v)) for v in values]
            bag.topic(topic, "std_msgs/Float64", epochs, lambda i, t: messages[i])  # noqa: B023
            sources[key] = _source(f"{topic}.data", unit)
    return sources

"""Bags of ROS 1 and ROS 2, and MCAP, by rosbags: every numeric field as a signal, by its path.

A signal is called `/topic.field.of.field`, an item of a list `/topic.list[3]`, or by its name where
the message has names, as `/joint_states.velocity[rear_left]`. A quaternion also gives its yaw.
Frames after REP 103: east, north, up for the world, forward, left, up for the body.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from twin.errors import BadInput
from twin.io.plain import Plain
from twin.logs.reader import Reader
from twin.logs.readers.reading import Reading
from twin.logs.signals import Found, Signal
from twin.plugins.extras import needed, refused_if_damaged

MOST_ITEMS = 16
"""Longer lists are pictures, clouds and scans."""
_MAGIC = {".bag": b"#ROSBAG", ".mcap": b"\x89MCAP0", ".db3": b"SQLite format 3"}
_VELOCITY_OF_GNSS = ("fix", "gps", "gnss", "ublox", "nav")
"""In the name of a topic: a twist there is a velocity in east, north, up."""
_QUALITY = {-1: 0.0, 0: 1.0, 1: 2.0, 2: 4.0}
"""NavSatStatus -> GGA quality: none, fix, with satellite and with ground based augmentation."""


class Bag(Reader):
    """A bag of ROS, which names its own quantities as far as its message types do."""

    name = "bag"

    def fits(self, path: Path, head: bytes) -> bool:
        """By its first bytes, or as a folder with metadata.yaml."""
        if path.is_dir():
            return (path / "metadata.yaml").is_file()
        return head.startswith(tuple(_MAGIC.values())) or path.suffix.lower() in _MAGIC

    def found(self, path: Path, reading: Reading) -> Found:
        """The signals of its topics. Raises BadInput."""
        highlevel = needed("rosbags.highlevel", "ros", "bags", "rosbags")
        typesys = needed("rosbags.typesys", "ros", "bags", "rosbags")
        store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
        with (
            refused_if_damaged("a bag"),
            highlevel.AnyReader([path], default_typestore=store) as bag,
        ):
            topics, lost = _topics(bag)
        if not topics:
            raise BadInput("a bag without a message that holds a number")
        notes = [f"{topic}: {why}" for topic, why in lost.items()]
        signals = {n: s for topic in topics.values() for n, s in topic.signals().items()}
        return Found(signals=signals, own_map=_own_map(topics, signals), notes=tuple(notes))


class _Topic:
    """Messages of one topic so far."""

    def __init__(self, name: str, kind: str) -> None:
        self.name, self.kind = name, kind
        self._times: list[int] = []
        self._rows: list[dict[str, float]] = []

    def take(self, time_ns: int, message: Plain) -> None:
        """Add a message."""
        self._times.append(_stamp_ns(message) or time_ns)
        self._rows.append(dict(_numbers(message, "")))

    def items(self, field: str) -> list[str]:
        """Names of the items of a list in its first message."""
        paths = self._rows[0] if self._rows else {}
        return [p[len(field) + 1 : -1] for p in paths if p.startswith(f"{field}[")]

    def signals(self) -> dict[str, Signal]:
        """Its fields as signals, in order of time; of one stamp the last counts."""
        times = np.array(self._times, np.int64)
        order = np.argsort(times, kind="stable")
        order = order[np.append(np.diff(times[order]) != 0, True)]
        paths = dict.fromkeys(path for row in self._rows for path in row)
        return {
            f"{self.name}{path}": Signal(
                np.array([self._rows[i].get(path, np.nan) for i in order]), times[order]
            )
            for path in paths
        }


def _wheel(joint: str) -> str:
    """Short name of the wheel that a joint's name says, or nothing."""
    name = joint.lower()
    front, rear = "front" in name, "rear" in name or "back" in name
    left, right = "left" in name, "right" in name
    if front == rear or left == right or "steer" in name:
        return ""
    return ("f" if front else "r") + ("l" if left else "r")


def _topics(bag: Plain) -> tuple[dict[str, _Topic], dict[str, str]]:
    """Topics by name, and those that cannot be read with the reason."""
    topics: dict[str, _Topic] = {}
    lost: dict[str, str] = {}
    for connection, time_ns, raw in bag.messages():
        if connection.topic in lost:
            continue
        try:
            message = bag.deserialize(raw, connection.msgtype)
        except Exception as error:
            lost[connection.topic] = f"{connection.msgtype} cannot be read ({type(error).__name__})"
            continue
        known = topics.setdefault(connection.topic, _Topic(connection.topic, connection.msgtype))
        known.take(int(time_ns), message)
    return {n: t for n, t in topics.items() if t.signals()}, lost


def _stamp_ns(message: Plain) -> int:
    """Time of the header; 0 where there is none, or it is not set."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    return 0 if stamp is None else int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _numbers(value: Plain, path: str, names: Sequence[str] = ()) -> Iterator[tuple[str, float]]:
    """Every number in a message with its path."""
    if isinstance(value, bool | int | float | np.number):
        yield path, float(value)
    elif isinstance(value, np.ndarray | list | tuple):
        if len(value) <= MOST_ITEMS:
            for i, item in enumerate(value):
                label = names[i] if len(names) == len(value) else str(i)
                yield from _numbers(item, f"{path}[{label}]")
    elif hasattr(value, "__dataclass_fields__"):
        own = getattr(value, "name", ())
        own = own if isinstance(own, list) and all(isinstance(n, str) for n in own) else ()
        for field in value.__dataclass_fields__:
            if field not in ("header", "__msgtype__") and not field.isupper():
                yield from _numbers(getattr(value, field), f"{path}.{field}", own)
        if {"x", "y", "z", "w"} <= set(value.__dataclass_fields__):
            yield f"{path}.yaw", _yaw_rad(value.x, value.y, value.z, value.w)


def _yaw_rad(x: float, y: float, z: float, w: float) -> float:
    """Heading of a quaternion, counter-clockwise from east; NaN where it is not set."""
    if x == y == z == 0.0 and w in (0.0, 1.0):
        return math.nan
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def _own_map(
    topics: Mapping[str, _Topic], signals: Mapping[str, Signal]
) -> dict[str, dict[str, object]]:
    """What message types say of their fields; the first topic of a kind counts."""
    own: dict[str, dict[str, object]] = {}
    for name, topic in topics.items():
        for section, key, path, unit, more in _meanings(topic):
            if f"{name}{path}" in signals:
                told = {"column": f"{name}{path}", "unit": unit, **more}
                own.setdefault(section, {}).setdefault(key, told)
    if "gnss" in own and {"v_east", "v_forward"} <= set(own["gnss"]):
        for key in ("v_forward", "v_left"):
            own["gnss"].pop(key, None)
    if "gnss" in own and "latitude" in own["gnss"]:
        for key in ("east", "north", "up"):
            own["gnss"].pop(key, None)
    return own


_Meaning = tuple[str, str, str, str, dict[str, object]]


def _meanings(topic: _Topic) -> Iterator[_Meaning]:
    """Section, key, field, unit and more of a map for what a message type says of itself."""
    kind = topic.kind.rpartition("/")[2]
    if kind == "NavSatFix":
        yield "gnss", "latitude", ".latitude", "deg", {}
        yield "gnss", "longitude", ".longitude", "deg", {}
        yield "gnss", "height", ".altitude", "m", {}
    elif kind in ("TwistStamped", "TwistWithCovarianceStamped"):
        path = ".twist.twist" if "Covariance" in kind else ".twist"
        world = any(word in topic.name.lower() for word in _VELOCITY_OF_GNSS)
        for axis, east, body in (("x", "v_east", "v_forward"), ("y", "v_north", "v_left")):
            yield "gnss", east if world else body, f"{path}.linear.{axis}", "m/s", {}
    elif kind == "Odometry":
        yield "gnss", "v_forward", ".twist.twist.linear.x", "m/s", {}
        yield "gnss", "v_left", ".twist.twist.linear.y", "m/s", {}
        yield "gnss", "east", ".pose.pose.position.x", "m", {}
        yield "gnss", "north", ".pose.pose.position.y", "m", {}
        yield "gnss", "heading", ".pose.pose.orientation.yaw", "rad", {"convention": "east"}
    elif kind == "QuaternionStamped" and ("head" in topic.name or "gnss" in topic.name):
        yield "gnss", "heading", ".quaternion.yaw", "rad", {"convention": "east"}
    elif kind == "JointState":
        for joint in topic.items(".velocity"):
            if wheel := _wheel(joint):
                yield "wheels", f"speed_{wheel}", f".velocity[{joint}]", "rad/s", {}
        for joint in topic.items(".position"):
            if (wheel := _wheel(joint)) and not topic.items(".velocity"):
                yield "wheels", f"ticks_{wheel}", f".position[{joint}]", "rad", {}
    elif kind == "Imu":
        for axis in "xyz":
            yield "imu", f"gyro_{axis}", f".angular_velocity.{axis}", "rad/s", {}
            yield "imu", f"accel_{axis}", f".linear_acceleration.{axis}", "m/s2", {}

"""Bags of ROS 1 and 2 and MATLAB files as signals by the path of their fields."""

import math

import numpy as np
import pytest

from twin.errors import BadInput
from twin.logs import found_in, read

pytest.importorskip("rosbags")
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore


def vector(types, x, y, z):
    return types["geometry_msgs/msg/Vector3"](x=x, y=y, z=z)


def write_bag(folder, ros):
    """Odometry and joints of a drive at 2 m/s to the north-east, and a topic of one's own."""
    store = get_typestore(Stores.ROS1_NOETIC if ros == 1 else Stores.ROS2_HUMBLE)
    types = store.types
    if ros == 1:
        writer = Writer1(folder / "drive.bag")
    else:
        writer = Writer2(
            folder / "drive", version=9,
            storage_plugin=StoragePlugin.MCAP if ros == "mcap" else StoragePlugin.SQLITE3,
        )  # fmt: skip
    with writer as bag:
        serialize = store.serialize_ros1 if ros == 1 else store.serialize_cdr
        topics = {
            "/odom": "nav_msgs/msg/Odometry", "/joint_states": "sensor_msgs/msg/JointState",
            "/draft": "geometry_msgs/msg/PointStamped",
        }  # fmt: skip
        connections = {t: bag.add_connection(t, k, typestore=store) for t, k in topics.items()}
        for i in range(40):
            t = 1_700_000_000_000_000_000 + i * 100_000_000
            stamp = types["builtin_interfaces/msg/Time"](sec=t // 10**9, nanosec=t % 10**9)
            seq = {"seq": i} if ros == 1 else {}
            header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="odom", **seq)
            zero = vector(types, 0.0, 0.0, 0.0)
            half = math.pi / 8
            messages = {
                "/odom": types["nav_msgs/msg/Odometry"](
                    header=header, child_frame_id="base_link",
                    pose=types["geometry_msgs/msg/PoseWithCovariance"](
                        pose=types["geometry_msgs/msg/Pose"](
                            position=types["geometry_msgs/msg/Point"](
                                x=0.1 * math.sqrt(2) * i, y=0.1 * math.sqrt(2) * i, z=0.0),
                            orientation=types["geometry_msgs/msg/Quaternion"](
                                x=0.0, y=0.0, z=math.sin(half), w=math.cos(half))),
                        covariance=np.zeros(36)),
                    twist=types["geometry_msgs/msg/TwistWithCovariance"](
                        twist=types["geometry_msgs/msg/Twist"](
                            linear=vector(types, 2.0, 0.0, 0.0), angular=zero),
                        covariance=np.zeros(36))),
                "/joint_states": types["sensor_msgs/msg/JointState"](
                    header=header, name=["rear_left_wheel", "rear_right_wheel"],
                    position=np.array([0.25 * i, 0.25 * i]), velocity=np.array([2.5, 2.6]),
                    effort=np.empty(0)),
                "/draft": types["geometry_msgs/msg/PointStamped"](
                    header=header, point=types["geometry_msgs/msg/Point"](x=1e4 + i, y=0.0, z=0.0)),
            }  # fmt: skip
            for topic, message in messages.items():
                raw = serialize(message, topics[topic])
                bag.write(connections[topic], t + 7_000_000, raw)
    return folder / ("drive.bag" if ros == 1 else "drive")


@pytest.mark.parametrize("ros", [1, 2, "mcap"])
def test_a_bag_says_what_it_is(tmp_path, ros):
    path = write_bag(tmp_path, ros)
    (tmp_path / "m.toml").write_text(
        '[machine]\ndraft_pin = {column = "/draft.point.x", unit = "N"}\n'
        "[setup.wheels]\nradius_m = {rl = 0.85, rr = 0.85}\n"
    )
    log = read(path, tmp_path / "m.toml")
    gnss, wheels = log.streams["gnss"], log.streams["wheels"]
    assert gnss["epoch_ns"][1] == 1_700_000_000_100_000_000
    np.testing.assert_allclose(gnss["v_east_mps"], math.sqrt(2.0))
    np.testing.assert_allclose(gnss["v_north_mps"], math.sqrt(2.0))
    np.testing.assert_allclose(gnss["heading_rad"], math.pi / 4)
    np.testing.assert_allclose(wheels["speed_rr_mps"], 2.6 * 0.85)
    assert log.streams["machine"]["draft_pin_n"][3] == 1e4 + 3
    assert not any("disagree" in note for note in log.notes)


def test_a_file_of_mcap_alone_and_one_that_is_cut(tmp_path):
    path = next(write_bag(tmp_path, "mcap").glob("*.mcap"))
    alone = tmp_path / "alone.mcap"
    alone.write_bytes(path.read_bytes())
    assert "/odom.twist.twist.linear.x" in found_in(alone).signals
    alone.write_bytes(path.read_bytes()[:300])
    with pytest.raises(BadInput, match="not a bag that can be read"):
        found_in(alone)


@pytest.mark.parametrize("hdf", [False, True])
def test_structs_of_matlab(tmp_path, hdf):
    path = tmp_path / "drive.mat"
    t = np.arange(50) * 0.2
    if hdf:
        h5py = pytest.importorskip("h5py")
        with h5py.File(path, "w", userblock_size=512) as file:
            file["t"] = t[None, :]
            file["gps/v"] = np.full((1, 50), 2.0)
            file["wheels"] = np.stack([t, np.full(50, 7.5)])
    else:
        from scipy.io import savemat

        content = {"t": t[:, None], "gps": {"v": np.full(50, 2.0)}, "note": "text"}
        savemat(path, {**content, "wheels": np.stack([t, np.full(50, 7.5)], axis=1)})
    (tmp_path / "m.toml").write_text(
        '[log]\ntime = {column = "t", unit = "s"}\n'
        '[gnss]\nspeed = {column = "gps.v", unit = "m/s"}\n'
        '[wheels]\ndriven_speed = {column = "wheels(:,2)", unit = "km/h"}\n'
    )
    log = read(path, tmp_path / "m.toml")
    np.testing.assert_allclose(log.streams["wheels"]["speed_rl_mps"], 7.5 / 3.6)
    np.testing.assert_allclose(log.streams["gnss"]["v_east_mps"], 2.0)
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(BadInput, match=r"not a \.mat file that can be read"):
        read(path, tmp_path / "m.toml")

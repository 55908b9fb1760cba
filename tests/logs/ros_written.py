"""The same flight in bags of ROS."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mcap_ros2.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from hotlap.reference.attitude import rotate
from logs.written import Flown

TARGET = "std_msgs/Header header\nuint8 type_mask\ngeometry_msgs/Quaternion orientation\ngeometry_msgs/Vector3 body_rate\nfloat32 thrust"
EPOCH = 1_700_000_000
KINDS = {"/odom": "nav_msgs/msg/Odometry", "/imu": "sensor_msgs/msg/Imu", "/target": "mavros_msgs/msg/AttitudeTarget"}
TRACKED = {  # as a motion capture system and a power module write it
    "/pose": "geometry_msgs/msg/PoseStamped",
    "/twist": "geometry_msgs/msg/TwistStamped",
    "/battery": "sensor_msgs/msg/BatteryState",
    "/target": "mavros_msgs/msg/AttitudeTarget",
}


def _store(ros: Stores):
    store = get_typestore(ros)
    store.register(get_types_from_msg(TARGET, "mavros_msgs/msg/AttitudeTarget"))
    return store


def _messages(store, flight: Flown):
    """(topic, time in ns, message) of each sample."""
    own = {name.rpartition("/")[2]: kind for name, kind in store.types.items()}
    own["Time"] = store.types["builtin_interfaces/msg/Time"]
    vector, point, quaternion = own["Vector3"], own["Point"], own["Quaternion"]
    still = np.zeros(36)
    back = flight.attitude * [1, -1, -1, -1]
    body_velocity = rotate(back, flight.velocity)
    for k, time in enumerate(flight.times):
        stamp = round(1e9 * time) + EPOCH * 10**9
        seconds = own["Time"](sec=stamp // 10**9, nanosec=stamp % 10**9)
        head = {"stamp": seconds, "frame_id": "map"}
        header = own["Header"](**head, **({"seq": k} if "seq" in own["Header"].__dataclass_fields__ else {}))
        w, x, y, z = flight.attitude[k].tolist()
        turned = quaternion(x=x, y=y, z=z, w=w)
        pose = own["PoseWithCovariance"](pose=own["Pose"](point(*flight.position[k].tolist()), turned), covariance=still)
        twist = own["Twist"](vector(*body_velocity[k].tolist()), vector(*flight.rates[k].tolist()))
        with_twist = own["TwistWithCovariance"](twist=twist, covariance=still)
        yield "/odom", stamp, own["Odometry"](header, "base_link", pose, with_twist)
        gyro, force, nine = vector(*flight.rates[k].tolist()), vector(*flight.acceleration[k].tolist()), np.zeros(9)
        yield "/imu", stamp, own["Imu"](header, turned, np.full(9, -1.0), gyro, nine, force, nine)
        asked = vector(*flight.rate_command[k].tolist())
        yield "/target", stamp, own["AttitudeTarget"](header, 0, turned, asked, float(flight.thrust[k]))


def _tracked(store, flight: Flown, mask: int, volts: float | None, amperes: float):
    """The same of pose, twist, battery and target."""
    own = {name.rpartition("/")[2]: kind for name, kind in store.types.items()}
    stamped, empty = store.types["builtin_interfaces/msg/Time"], np.zeros(0, dtype=np.float32)
    for k, time in enumerate(flight.times):
        stamp = round(1e9 * time) + EPOCH * 10**9
        header = own["Header"](stamp=stamped(sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id="map")
        w, x, y, z = flight.attitude[k].tolist()
        turned = own["Quaternion"](x=x, y=y, z=z, w=w)
        yield "/pose", stamp, own["PoseStamped"](header, own["Pose"](own["Point"](*flight.position[k].tolist()), turned))
        twist = own["Twist"](own["Vector3"](*flight.velocity[k].tolist()), own["Vector3"](*flight.rates[k].tolist()))
        yield "/twist", stamp, own["TwistStamped"](header, twist)
        known = float(flight.volts[k]) if volts is None else volts
        none = float("nan")
        numbers = (known, none, amperes, none, none, none, none)
        yield (
            "/battery",
            stamp,
            own["BatteryState"](
                header, *numbers, 0, 0, 0, present=True, cell_voltage=empty, cell_temperature=empty, location="", serial_number=""
            ),
        )
        asked = own["Vector3"](*flight.rate_command[k].tolist())
        yield "/target", stamp, own["AttitudeTarget"](header, mask, turned, asked, float(flight.thrust[k]))


def write_tracked(path: Path, flight: Flown, *, mask: int = 0, volts: float | None = None, amperes: float = 12.5) -> Path:
    """A bag without odometry: pose, twist, battery and attitude target."""
    store = _store(Stores.ROS2_HUMBLE)
    with Writer2(path, version=9) as bag:
        topics = {topic: bag.add_connection(topic, kind, typestore=store) for topic, kind in TRACKED.items()}
        for topic, stamp, message in _tracked(store, flight, mask, volts, amperes):
            bag.write(topics[topic], stamp, store.serialize_cdr(message, TRACKED[topic]))
    return path


def write_bag1(path: Path, flight: Flown) -> Path:
    store = _store(Stores.ROS1_NOETIC)
    with Writer1(path) as bag:
        topics = {topic: bag.add_connection(topic, kind, typestore=store) for topic, kind in KINDS.items()}
        for topic, stamp, message in _messages(store, flight):
            bag.write(topics[topic], stamp, store.serialize_ros1(message, KINDS[topic]))
    return path


def write_bag2(path: Path, flight: Flown) -> Path:
    store = _store(Stores.ROS2_HUMBLE)
    with Writer2(path, version=9) as bag:
        topics = {topic: bag.add_connection(topic, kind, typestore=store) for topic, kind in KINDS.items()}
        for topic, stamp, message in _messages(store, flight):
            bag.write(topics[topic], stamp, store.serialize_cdr(message, KINDS[topic]))
    return path


def write_mcap(path: Path, flight: Flown) -> Path:
    store = _store(Stores.ROS2_HUMBLE)
    with path.open("wb") as file, McapWriter(file, chunk_size=50_000) as bag:
        schemas = {topic: bag.register_msgdef(kind, store.generate_msgdef(kind, ros_version=2)[0]) for topic, kind in KINDS.items()}
        for topic, stamp, message in _messages(store, flight):
            bag.write_message(topic, schemas[topic], _plain(message), stamp, stamp)
    return path


def _plain(message):
    """A message as the writer of MCAP takes it."""
    if hasattr(message, "__dataclass_fields__"):
        return {name: _plain(getattr(message, name)) for name in message.__dataclass_fields__ if not name.startswith("__")}
    return message.tolist() if isinstance(message, np.ndarray) else message

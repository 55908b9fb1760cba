"""ROS messages: what hotlap takes of odometry, IMU, poses, attitude targets and batteries, whichever package decoded them."""

from __future__ import annotations

from array import array
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from hotlap.core.errors import UnknownNameError
from hotlap.core.records import Floats
from hotlap.logs.flight_log import COLUMNS
from hotlap.logs.key_map import source_of
from hotlap.logs.recording import Recording
from hotlap.reference.attitude import rotate

Rows = Mapping[str, Sequence[float]]
"""Values of one message by signal."""

IGNORED_RATES, IGNORED_THRUST = 0b111, 0b1000000  # bits of the mask of an attitude target: roll, pitch and yaw rate; thrust
UNMEASURED = -1  # first element of the covariance of what nothing measures


def short(kind: str) -> str:
    """The name of a type without the part that only ROS 2 has: nav_msgs/Odometry."""
    return kind.replace("/msg/", "/")


def _vector(of: Any) -> list[float]:
    return [of.x, of.y, of.z]


def _quaternion(of: Any) -> list[float]:
    return [of.w, of.x, of.y, of.z]


def _odometry(message: Any) -> Rows:
    pose, twist = message.pose.pose, message.twist.twist
    about = {"position": _vector(pose.position), "attitude": _quaternion(pose.orientation)}
    return about | {"velocity": _vector(twist.linear), "rates": _vector(twist.angular)}


def _imu(message: Any) -> Rows:
    parts = {
        "rates": (_vector(message.angular_velocity), message.angular_velocity_covariance),
        "acceleration": (_vector(message.linear_acceleration), message.linear_acceleration_covariance),
        "attitude": (_quaternion(message.orientation), message.orientation_covariance),
    }
    rows = {signal: values for signal, (values, covariance) in parts.items() if covariance[0] != UNMEASURED}
    return rows if any(rows.get("attitude", ())) else {signal: values for signal, values in rows.items() if signal != "attitude"}


def _pose(message: Any) -> Rows:
    pose = message.pose.pose if hasattr(message.pose, "pose") else message.pose
    return {"position": _vector(pose.position), "attitude": _quaternion(pose.orientation)}


def _twist(message: Any) -> Rows:
    return {"velocity": _vector(message.twist.linear)}


def _target(message: Any) -> Rows:
    """What it asks for: a mask says which of its fields count."""
    rates = {} if message.type_mask & IGNORED_RATES else {"rate_command": _vector(message.body_rate)}
    return rates if message.type_mask & IGNORED_THRUST else {**rates, "thrust_command": [message.thrust]}


def _battery(message: Any) -> Rows:
    return {"battery": [message.voltage], "current": [abs(message.current)]}


TAKEN: Mapping[str, Callable[[Any], Rows]] = {  # the first that has a signal gives it
    "nav_msgs/Odometry": _odometry,
    "geometry_msgs/PoseStamped": _pose,
    "geometry_msgs/PoseWithCovarianceStamped": _pose,
    "geometry_msgs/TwistStamped": _twist,
    "sensor_msgs/Imu": _imu,
    "mavros_msgs/AttitudeTarget": _target,
    "sensor_msgs/BatteryState": _battery,
}
FIRST_OF = {"rates": "sensor_msgs/Imu"}  # the type that is asked first, where it is another


def _numbers() -> array[float]:
    """An empty list of numbers, of eight bytes each."""
    return array("d")


class Topics:
    """Messages by topic.

    Args:
        recording: that takes the signals.
        mapping: topics by signal, where they are not to be found.
    """

    def __init__(self, recording: Recording, mapping: Mapping[str, Any] | None) -> None:
        self._recording, self._mapping = recording, mapping if mapping is not None else {}
        for key in self._mapping:
            if key not in COLUMNS:
                raise UnknownNameError("signal", key, COLUMNS, source_of(self._mapping) or "map", key)
        self._kinds: dict[str, str] = {}
        self._times: dict[tuple[str, str], array[float]] = defaultdict(_numbers)
        self._values: dict[tuple[str, str], array[float]] = defaultdict(_numbers)
        self.seen: set[str] = set()

    def take(self, topic: str, kind: str, message: Any, logged: float) -> None:
        """Take up a message.

        Args:
            topic: of the message.
            kind: its type, one of `TAKEN`.
            message: decoded.
            logged: [s] when it was written, for messages without a time of their own.
        """
        self._kinds[topic] = kind
        stamp = message.header.stamp
        time = stamp.sec + 1e-9 * stamp.nanosec
        for signal, values in TAKEN[kind](message).items():
            self._times[topic, signal].append(time or logged)
            self._values[topic, signal].extend(values)

    def finish(self) -> None:
        """Choose a topic for each signal.

        Raises:
            InputError: there is no message that hotlap knows, or a topic that was asked for has none.
        """
        if not self._kinds:
            seen = f"; it has {', '.join(sorted(self.seen)[:8])}" if self.seen else ""
            raise self._recording.fail("", f"is {self._recording.kind} with no {', '.join(TAKEN)}{seen}")
        for topic, kind in self._kinds.items():
            for signal in ("rate_command", "thrust_command") if TAKEN[kind] is _target else ():
                if (topic, signal) not in self._times:
                    self._recording.note(f"{topic}: its mask says that {signal} does not count")
        for signal in COLUMNS:
            topic = self._choose(signal)
            if topic is None:
                continue
            times, values = np.array(self._times[topic, signal]), self._rows(topic, signal)
            if signal == "velocity" and self._kinds[topic] == "nav_msgs/Odometry":
                values = rotate(self._rows(topic, "attitude"), values)
                self._recording.note(f"velocity: of {topic}, turned from the body's frame into the world's")
            self._recording.add(signal, times, values, f"{signal}: {topic}")

    def _rows(self, topic: str, signal: str) -> Floats:
        """Values of all messages, shape (N, columns)."""
        return np.array(self._values[topic, signal]).reshape(-1, COLUMNS[signal])

    def _choose(self, signal: str) -> str | None:
        """The topic of a signal: as asked, else by its type, else the one with most messages."""
        known = [topic for topic, found in self._times if found == signal]
        asked = self._mapping.get(signal)
        if asked is not None:
            if asked not in known:
                raise UnknownNameError(f"topic with {signal}", str(asked), known, self._recording.name)
            return str(asked)
        order = list(TAKEN)
        if signal in FIRST_OF:
            order.insert(0, FIRST_OF[signal])
        turned = [
            topic for topic in known if not (signal == "velocity" and self._kinds[topic].endswith("TwistStamped") and "body" in topic)
        ]
        return min(turned, key=lambda topic: (order.index(self._kinds[topic]), -len(self._times[topic, signal]), topic), default=None)

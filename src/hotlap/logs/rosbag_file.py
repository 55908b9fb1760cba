"""ROS bags, by rosbags: `.bag` files of ROS 1, and folders of ROS 2."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hotlap.logs.flight_log import FlightLog
from hotlap.logs.packages import load
from hotlap.logs.recording import Recording
from hotlap.logs.ros import TAKEN, Topics, short

KIND = "a ROS bag"


def read(path: Path, name: str, mapping: Mapping[str, Any] | None) -> FlightLog:
    """Read a log; see `readers.read`."""
    recording = Recording(name, KIND)
    bags, types = load("rosbags.highlevel", KIND, name), load("rosbags.typesys", KIND, name)
    topics = Topics(recording, mapping)
    store = types.get_typestore(types.Stores.ROS2_HUMBLE)
    with bags.AnyReader([path], default_typestore=store) as bag:
        topics.seen |= {f"{connection.topic} ({short(connection.msgtype)})" for connection in bag.connections}
        known = [connection for connection in bag.connections if short(connection.msgtype) in TAKEN]
        unknown = [connection.topic for connection in known if connection.msgtype not in bag.typestore.fielddefs]
        if unknown:
            recording.note(f"{', '.join(unknown)}: the bag does not say what its messages look like")
        known = [connection for connection in known if connection.topic not in unknown]
        for connection, logged, data in bag.messages(connections=known) if known else ():
            message = bag.deserialize(data, connection.msgtype)
            topics.take(connection.topic, short(connection.msgtype), message, 1e-9 * logged)
    topics.finish()
    return recording.finish()

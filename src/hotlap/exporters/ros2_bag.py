"""A ROS 2 bag (MCAP) of the reference and of a flight with the tuned parameters, for Foxglove and ROS.

Topics: `/reference` (nav_msgs/Path), `/flight` (nav_msgs/Path), `/odometry` (nav_msgs/Odometry) and `/command`
(mavros_msgs/AttitudeTarget) of the flight, `/gates` (geometry_msgs/PoseArray). Time 0 is the start; the frame is that of the track, z up.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hotlap import worlds
from hotlap.core.errors import InputError
from hotlap.core.records import Floats, Log
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.exporters.ros2_messages import definition_of
from hotlap.exporters.tuned import read_tuned
from hotlap.reference.attitude import rotate
from hotlap.reference.scenario import Scenario
from hotlap.study.study import Study
from hotlap.system.whole_files import written_whole

MISSING = "mcap needs the packages mcap and mcap-ros2-support: pip install 'hotlap[logs]'"
TRACK, BODY = "map", "base_link"
RATES_ALONE = 128  # type_mask: the attitude does not count
TOPICS = {
    "/reference": "nav_msgs/Path",
    "/flight": "nav_msgs/Path",
    "/gates": "geometry_msgs/PoseArray",
    "/odometry": "nav_msgs/Odometry",
    "/command": "mavros_msgs/AttitudeTarget",
}
INVERSE = np.array([1.0, -1.0, -1.0, -1.0])
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])


def write(study: Study, path: Path) -> tuple[Path, ...]:
    """Fly the tuned parameters once, in the built-in world with fresh noise, and write the flight.

    Raises:
        InputError: a package is missing, the study has not ended, or the file cannot be written.
    """
    tuned = read_tuned(study)
    seeds = flight_seeds(study.configuration.settings.seed, Stream.DEMONSTRATION, 0, 1)
    flights = worlds.build("built-in", 1).fly(tuned.scenario, tuned.values[None], seeds, log=(0,))
    write_bag(path, tuned.scenario, flights.logs[0])
    return (path,)


def write_bag(path: Path, scenario: Scenario, log: Log) -> None:
    """Write reference and flight as a bag.

    Args:
        path: of the file.
        scenario: that was flown.
        log: of the flight.

    Raises:
        InputError: a package is missing, or the file cannot be written.
    """
    try:
        from mcap_ros2.writer import Writer  # noqa: PLC0415  an extra
    except ImportError:
        raise InputError("", "format", MISSING) from None
    with written_whole(path) as part, part.open("wb") as file:
        writer = Writer(file)
        schemas = {kind: writer.register_msgdef(kind.replace("/", "/msg/"), definition_of(kind)) for kind in set(TOPICS.values())}
        for topic, time, message in messages(scenario, log):
            stamp = round(1e9 * time)
            writer.write_message(topic, schemas[TOPICS[topic]], message, stamp, stamp)
        writer.finish()


def messages(scenario: Scenario, log: Log) -> Iterator[tuple[str, float, dict[str, Any]]]:
    """Topic, time [s] and content of each message."""
    reference, rows = scenario.reference, slice(0, scenario.reference.planned_rows)
    known = np.isfinite(log.states[:, :7]).all(axis=1)
    times, states, commands = log.times[known], log.states[known], log.commands[known]
    gates = scenario.race.track.gate_positions
    yield "/reference", 0.0, _path(reference.times[rows], reference.position[rows], reference.attitude[rows])
    yield "/gates", 0.0, {"header": _header(0.0), "poses": [_pose(place, LEVEL) for place in gates]}
    yield "/flight", 0.0, _path(times, states[:, :3], states[:, 3:7])
    most = scenario.race.vehicle.max_acceleration
    for time, state, command in zip(times.tolist(), states, commands, strict=True):
        yield "/odometry", time, _odometry(time, state)
        if np.isfinite(command).all():
            yield "/command", time, _command(time, state[3:7], command, most)


def _odometry(time: float, state: Floats) -> dict[str, Any]:
    """A state; the velocity is in the body's frame, as ROS has it."""
    velocity = rotate(state[None, 3:7] * INVERSE, state[None, 7:10])[0]
    twist = {"linear": _vector(velocity), "angular": _vector(state[10:13])}
    pose = {"pose": _pose(state[:3], state[3:7]), "covariance": [0.0] * 36}
    return {"header": _header(time), "child_frame_id": BODY, "pose": pose, "twist": {"twist": twist, "covariance": [0.0] * 36}}


def _command(time: float, attitude: Floats, command: Floats, most: float) -> dict[str, Any]:
    """A command; its thrust is a share of the largest that the rotors have."""
    share = float(np.clip(command[0] / most, 0.0, 1.0))
    about = {"orientation": _quaternion(attitude), "body_rate": _vector(command[1:]), "thrust": share}
    return {"header": {**_header(time), "frame_id": BODY}, "type_mask": RATES_ALONE, **about}


def _path(times: Floats, places: Floats, attitudes: Floats) -> dict[str, Any]:
    """Poses in time."""
    rows = zip(times.tolist(), places, attitudes, strict=True)
    return {"header": _header(0.0), "poses": [{"header": _header(time), "pose": _pose(place, turned)} for time, place, turned in rows]}


def _header(time: float) -> dict[str, Any]:
    stamp = round(1e9 * time)
    return {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": TRACK}


def _pose(place: Floats, attitude: Floats) -> dict[str, Any]:
    return {"position": _vector(place), "orientation": _quaternion(attitude)}


def _vector(values: Floats) -> dict[str, float]:
    return dict(zip("xyz", map(float, values), strict=True))


def _quaternion(values: Floats) -> dict[str, float]:
    return dict(zip("wxyz", map(float, values), strict=True))

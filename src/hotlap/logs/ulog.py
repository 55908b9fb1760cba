"""PX4: ULog, by pyulog. Its world is north, east, down, its body forward, right, down."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from hotlap.core.records import Floats
from hotlap.logs.flight_log import FlightLog
from hotlap.logs.frames import TURNED, turn, turn_attitude
from hotlap.logs.packages import load
from hotlap.logs.recording import Recording

KIND = "a ULog of PX4"
VERSIONS = (0, 1)
TOPICS = (
    "vehicle_local_position",
    "vehicle_attitude",
    "vehicle_angular_velocity",
    "sensor_combined",
    "vehicle_rates_setpoint",
    "vehicle_thrust_setpoint",
    "actuator_motors",
    "actuator_outputs",
    "battery_status",
    "esc_status",
)
FACTS = ("MC_", "THR_", "MPC_THR", "PWM_", "CA_ROTOR", "BAT", "IMU_GYRO", "SYS_AUTOSTART")  # how parameters begin that are kept
PWM = (1000.0, 2000.0)  # µs of no thrust and of all
MOST_MOTORS = 12
MOST_TIMES, MORE = 20, 10_000_000  # that a file is read over, and bytes besides


def read(path: Path, name: str) -> FlightLog:
    """Read a log; see `readers.read`."""
    recording = Recording(name, KIND)
    with path.open("rb") as file:
        head = file.read(16)
    if len(head) < 16:
        raise recording.fail("", f"is {KIND} that ends within its first 16 bytes")
    if head[7] not in VERSIONS:
        raise recording.fail("", f"is a ULog of version {head[7]}; hotlap reads versions {' and '.join(map(str, VERSIONS))}")
    with path.open("rb") as file:  # which pyulog leaves open where the log is damaged
        log = load("pyulog", KIND, name).ULog(Bounded(file, recording), list(TOPICS))
    topics = {(data.name, data.multi_id): data.data for data in log.data_list}
    found = {topic: Topic(recording, topic, topics[topic, 0]) for topic in TOPICS if (topic, 0) in topics}
    for topic, take in TAKEN.items():
        if topic in found:
            take(recording, found[topic], log.initial_parameters)
    recording.facts |= {key: value for key, value in log.initial_parameters.items() if key.startswith(FACTS)}
    if log.file_corruption:
        recording.note("the log is damaged or cut short: what could be read was")
    if log.dropouts:
        recording.note(f"{len(log.dropouts)} gaps in which the autopilot could not write")
    return recording.finish()


class Bounded:
    """A file that is read a few times at most: pyulog goes back where a message is damaged, and for ever where the file ends in it.

    Args:
        file: that is read.
        recording: that complains.
    """

    def __init__(self, file: BinaryIO, recording: Recording) -> None:
        self._file, self._recording = file, recording
        self._left = MOST_TIMES * os.fstat(file.fileno()).st_size + MORE
        self.seek, self.tell, self.close = file.seek, file.tell, file.close

    def read(self, count: int = -1) -> bytes:
        """So many bytes.

        Raises:
            InputError: too many were read before.
        """
        content = self._file.read(count)
        self._left -= len(content) + 1
        if self._left < 0:
            raise self._recording.fail("", f"is {KIND} whose messages lead back again and again: it is damaged")
        return content


class Topic:
    """The samples of one topic.

    Args:
        recording: that complains.
        name: of the topic.
        data: columns by name.
    """

    def __init__(self, recording: Recording, name: str, data: Mapping[str, Any]) -> None:
        self.name, self._recording, self._data = name, recording, data
        sampled = self._data.get("timestamp_sample")
        self.times: Floats = np.asarray(self._data["timestamp"] if sampled is None or not np.any(sampled) else sampled) * 1e-6

    def __contains__(self, column: str) -> bool:
        """Whether there is a column of this name."""
        return column in self._data

    def columns(self, *names: str) -> Floats:
        """Some columns, shape (N, columns).

        Raises:
            InputError: one is missing.
        """
        missing = [name for name in names if name not in self._data]
        if missing:
            raise self._recording.fail(self.name, f"has no {', '.join(missing)}")
        return np.column_stack([np.asarray(self._data[name], dtype=np.float64) for name in names])

    def list(self, name: str, most: int) -> Floats:
        """The columns `name[0]`, `name[1]`, ..., shape (N, as many as have a number)."""
        known = [np.asarray(self._data[f"{name}[{i}]"], dtype=np.float64) for i in range(most) if f"{name}[{i}]" in self._data]
        used = [column for column in known if np.isfinite(column).any() and np.any(column > 0)]
        return np.column_stack(used) if used else np.empty((len(self.times), 0))


def _position(recording: Recording, topic: Topic, _: Any) -> None:
    valid = np.ones(len(topic.times), dtype=bool)
    for flag in ("xy_valid", "z_valid"):
        if flag in topic:
            valid &= topic.columns(flag)[:, 0] > 0
    if not valid.any():
        recording.note("vehicle_local_position was never valid: no position")
        return
    recording.add("position", topic.times[valid], turn(topic.columns("x", "y", "z"))[valid], TURNED)
    recording.add("velocity", topic.times[valid], turn(topic.columns("vx", "vy", "vz"))[valid])


def _attitude(recording: Recording, topic: Topic, _: Any) -> None:
    recording.add("attitude", topic.times, turn_attitude(topic.columns("q[0]", "q[1]", "q[2]", "q[3]")))


def _rates(recording: Recording, topic: Topic, _: Any) -> None:
    recording.add("rates", topic.times, turn(topic.columns("xyz[0]", "xyz[1]", "xyz[2]")))


def _imu(recording: Recording, topic: Topic, _: Any) -> None:
    rates = turn(topic.columns("gyro_rad[0]", "gyro_rad[1]", "gyro_rad[2]"))
    recording.add("rates", topic.times, rates, "rates: of sensor_combined, without the autopilot's filters")
    force = topic.columns("accelerometer_m_s2[0]", "accelerometer_m_s2[1]", "accelerometer_m_s2[2]")
    recording.add("acceleration", topic.times, turn(force))


def _rates_setpoint(recording: Recording, topic: Topic, _: Any) -> None:
    recording.add("rate_command", topic.times, turn(topic.columns("roll", "pitch", "yaw")))
    if "thrust_body[2]" in topic:
        recording.add("thrust_command", topic.times, -topic.columns("thrust_body[2]"))
    elif "thrust" in topic:
        recording.add("thrust_command", topic.times, topic.columns("thrust"))


def _thrust_setpoint(recording: Recording, topic: Topic, _: Any) -> None:
    recording.add("thrust_command", topic.times, -topic.columns("xyz[2]"))


def _motors(recording: Recording, topic: Topic, _: Any) -> None:
    recording.add("motor_command", topic.times, topic.list("control", MOST_MOTORS))


def _outputs(recording: Recording, topic: Topic, parameters: Mapping[str, Any]) -> None:
    low, high = (float(parameters.get(key, value)) for key, value in zip(("PWM_MIN", "PWM_MAX"), PWM, strict=True))
    outputs = topic.list("output", 16)
    outputs = outputs[:, (np.nanmax(outputs, axis=0) <= 1.5 * high)] if outputs.size else outputs
    if outputs.size and "motor_command" not in recording:
        share = np.clip((outputs - low) / (high - low), 0.0, 1.0)
        recording.add("motor_command", topic.times, share, f"motor_command: actuator_outputs from {low:g} to {high:g} us")


def _battery(recording: Recording, topic: Topic, _: Any) -> None:
    for column in ("voltage_v", "voltage_filtered_v"):
        if column in topic:
            recording.add("battery", topic.times, topic.columns(column))
    if "current_a" in topic and np.any(topic.columns("current_a") > 0):  # -1 where nothing measures it
        recording.add("current", topic.times, topic.columns("current_a"))


def _speeds(recording: Recording, topic: Topic, _: Any) -> None:
    known = [topic.columns(f"esc[{i}].esc_rpm") for i in range(8) if f"esc[{i}].esc_rpm" in topic]
    used = [column for column in known if np.any(column > 0)]
    if used:
        recording.add("motor_speed", topic.times, np.hstack(used) * (2 * np.pi / 60))


TAKEN = {  # in this order: the first that has a signal gives it
    "vehicle_local_position": _position,
    "vehicle_attitude": _attitude,
    "vehicle_angular_velocity": _rates,
    "sensor_combined": _imu,
    "vehicle_rates_setpoint": _rates_setpoint,
    "vehicle_thrust_setpoint": _thrust_setpoint,
    "actuator_motors": _motors,
    "actuator_outputs": _outputs,
    "battery_status": _battery,
    "esc_status": _speeds,
}

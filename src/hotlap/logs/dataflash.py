"""ArduPilot: dataflash, by pymavlink. Its world is north, east, down, its body forward, right, down; angles are in degrees."""

from __future__ import annotations

import math
from array import array
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hotlap.core.records import Floats
from hotlap.logs.flight_log import FlightLog
from hotlap.logs.frames import TURNED, from_angles, turn, turn_attitude
from hotlap.logs.packages import load, without_remarks
from hotlap.logs.recording import Recording

KIND = "a dataflash log of ArduPilot"
FIRST = {"IMU": ("I",), "BAT": ("Inst", "Instance"), "XKF1": ("C",), "NKF1": ("C",), "XKQ": ("C",)}  # 0 of it counts
KINDS = ("ATT", "RATE", "IMU", "RCOU", "BAT", "XKF1", "NKF1", "XKQ", "POS", "PARM")
FACTS = ("ATC_RAT", "ATC_THR", "MOT_", "INS_GYRO_FILTER", "BATT_", "FRAME", "SERVO_BLH", "SCHED_LOOP_RATE")
EARTH = 6378137.0  # m, radius at the equator
PWM = (1000.0, 2000.0)
MOST_MESSAGES = 20_000_000
PARAMETER, TIME, CLOCK = "PARM", "TimeUS", "its clock"


def read(path: Path, name: str) -> FlightLog:
    """Read a log; see `readers.read`."""
    recording, reader = Recording(name, KIND), load("pymavlink.DFReader", KIND, name)
    form = reader.DFReader_text if path.suffix.lower() == ".log" else _forward(reader.DFReader_binary, recording)
    log, tables, parameters = form.__new__(form), dict[str, Table](), dict[str, Any]()
    try:
        with without_remarks():  # on every byte that is none of a message
            log.__init__(str(path))  # apart, so that its file is closed where it fails
        for _ in range(MOST_MESSAGES):
            message = log.recv_match(type=list(KINDS))
            if message is None:
                break
            kind = message.get_type()
            if kind == PARAMETER:
                parameters[message.Name] = message.Value
            elif all(getattr(message, field, 0) in {0, None} for field in FIRST.get(kind, ())):
                fields = {**message.to_dict(), CLOCK: message._timestamp}  # noqa: SLF001  it has no other name
                tables.setdefault(kind, Table(recording, kind, fields)).add(fields)
    finally:
        if hasattr(log, "filehandle"):
            log.filehandle.close()
    if not tables:
        raise recording.fail("", f"is {KIND} with none of {', '.join(KINDS[:-1])}: it is cut short, or holds no flight")
    _take(recording, tables, parameters)
    recording.facts |= {key: value for key, value in parameters.items() if key.startswith(FACTS)}
    return recording.finish()


def _forward(binary: Any, recording: Recording) -> Any:
    """A reader of the package that never stands still: messages that say they have no length would be read for ever."""

    class Forward(binary):
        def _parse_next(self) -> Any:
            begin, message = self.offset, super()._parse_next()
            if message is not None and self.offset <= begin:
                raise recording.fail("", f"is {KIND} with a message {message.get_type()} of no length at byte {begin}: it is damaged")
            return message

    return Forward


class Table:
    """The messages of one kind, eight bytes a number.

    Args:
        recording: that complains.
        kind: of the messages.
        first: the fields of the first message: those that are numbers are kept.
    """

    def __init__(self, recording: Recording, kind: str, first: Mapping[str, Any]) -> None:
        self._recording, self._kind = recording, kind
        self._names = [name for name, value in first.items() if isinstance(value, int | float)]
        self._numbers: array[float] = array("d")

    def __contains__(self, column: str) -> bool:
        """Whether there is a column of this name."""
        return column in self._names

    def add(self, fields: Mapping[str, Any]) -> None:
        """Take up a message."""
        self._numbers.extend(value if isinstance(value := fields.get(name), int | float) else math.nan for name in self._names)

    @property
    def times(self) -> Floats:
        """Shape (N,) [s]."""
        return self.columns(TIME)[:, 0] * 1e-6 if TIME in self else self.columns(CLOCK)[:, 0]

    def columns(self, *names: str) -> Floats:
        """Some columns, shape (N, columns).

        Raises:
            InputError: one is missing.
        """
        missing = [name for name in names if name not in self]
        if missing:
            raise self._recording.fail(self._kind, f"has no {', '.join(missing)}")
        return np.array(self._numbers).reshape(-1, len(self._names))[:, [self._names.index(name) for name in names]]


def _take(recording: Recording, tables: dict[str, Table], parameters: dict[str, Any]) -> None:
    _take_place(recording, tables)
    if "XKQ" in tables:
        recording.add("attitude", tables["XKQ"].times, turn_attitude(tables["XKQ"].columns("Q1", "Q2", "Q3", "Q4")))
    if "ATT" in tables:
        roll, pitch, yaw = np.radians(tables["ATT"].columns("Roll", "Pitch", "Yaw")).T
        recording.add("attitude", tables["ATT"].times, turn_attitude(from_angles(roll, pitch, yaw)), "attitude: from the angles of ATT")
    if "IMU" in tables:
        imu = tables["IMU"]
        recording.add("rates", imu.times, turn(imu.columns("GyrX", "GyrY", "GyrZ")))
        recording.add("acceleration", imu.times, turn(imu.columns("AccX", "AccY", "AccZ")))
    if "RATE" in tables:
        rate = tables["RATE"]
        recording.add("rates", rate.times, turn(np.radians(rate.columns("R", "P", "Y"))), "rates: of RATE")
        recording.add("rate_command", rate.times, turn(np.radians(rate.columns("RDes", "PDes", "YDes"))))
        if "AOut" in rate:
            recording.add("thrust_command", rate.times, np.clip(rate.columns("AOut"), 0.0, 1.0))
    if "RCOU" in tables:
        _take_motors(recording, tables["RCOU"], parameters)
    if "BAT" in tables:
        battery = tables["BAT"]
        recording.add("battery", battery.times, battery.columns("Volt"))
        if "Curr" in battery:
            recording.add("current", battery.times, battery.columns("Curr"))


def _take_place(recording: Recording, tables: dict[str, Table]) -> None:
    """Position and velocity: of a filter, else of POS."""
    for kind in ("XKF1", "NKF1"):
        if kind in tables:
            table = tables[kind]
            recording.add("position", table.times, turn(table.columns("PN", "PE", "PD")), TURNED)
            recording.add("velocity", table.times, turn(table.columns("VN", "VE", "VD")))
    if "POS" in tables and "position" not in recording:
        table = tables["POS"]
        latitude, longitude, height = table.columns("Lat", "Lng", "RelHomeAlt" if "RelHomeAlt" in table else "Alt").T
        north, east = (np.radians(angle - angle[0]) * EARTH for angle in (latitude, longitude))
        place = np.column_stack([north, -east * np.cos(np.radians(latitude[0])), height])
        recording.add("position", table.times, place, "position: of POS, from the first fix; a metre or more may be wrong")


def _take_motors(recording: Recording, table: Table, parameters: dict[str, Any]) -> None:
    """Outputs that are motors: by their functions where those are logged, else the first four."""
    motors = [i for i in range(1, 15) if 33 <= parameters.get(f"SERVO{i}_FUNCTION", 0) <= 40] or [1, 2, 3, 4]
    low, high = (float(parameters.get(key) or value) for key, value in zip(("MOT_PWM_MIN", "MOT_PWM_MAX"), PWM, strict=True))
    share = np.clip((table.columns(*(f"C{i}" for i in motors)) - low) / (high - low), 0.0, 1.0)
    said = f"motor_command: {', '.join(f'C{i}' for i in motors)} of RCOU from {low:g} to {high:g} us"
    recording.add("motor_command", table.times, share, said)

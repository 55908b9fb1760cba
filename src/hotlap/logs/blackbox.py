"""Betaflight: blackbox, by orangebox. Its body is forward, left, up; the setpoint that it logs holds the sweep of the chirp mode."""

from __future__ import annotations

import csv
import re
import struct
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator, Mapping
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

import numpy as np

from hotlap.core.errors import InputError
from hotlap.core.records import Floats
from hotlap.logs.flight_log import FlightLog
from hotlap.logs.number_table import NumberTable
from hotlap.logs.recording import Recording

KIND = "a blackbox of Betaflight"
GRAVITY = 9.80665
VERSION = re.compile(r"(\d+)\.(\d+)\.(\d+)")
KEPT = ("rollPID", "pitchPID", "yawPID", "d_min", "d_max", "rates", "rate_limits", "tpa", "thrust_linear", "motor_poles", "looptime")
KEPT += ("dshot_idle_value", "motorOutput", "vbat_sag_compensation", "debug_mode", "gyro_lowpass_hz", "dterm_lpf1_static_hz")
FIRST = b"H Product:Blackbox"  # line of each flight
PACKAGE, PROGRAM = "orangebox", "bb2csv"
PATIENCE = 300.0  # s of decoding
LAST_WORDS = 4096  # bytes of what it says
FEWEST = 10  # frames that make a flight


def read(path: Path, name: str) -> FlightLog:
    """Read the first flight of a log; see `readers.read`."""
    recording = Recording(name, KIND)
    content = path.read_bytes()
    headers, flights = _headers(content), content.count(FIRST)
    columns = _decode(path, recording)
    if flights > 1:
        recording.note(f"the file holds {flights} flights: this is the first")
    if "time" not in columns:
        raise recording.fail("time", "is missing")
    _take(recording, columns, headers)
    recording.facts |= {key: value for key, value in headers.items() if key.startswith(("chirp", "Firmware")) or key in KEPT}
    return recording.finish()


def _decode(path: Path, recording: Recording) -> dict[str, Floats]:
    """Numbers of the frames of the first flight by the name of their field; words, of slow fields, are NaN.

    Orangebox is under the GPL, so its program runs as a process of its own. What it writes is read line by line.

    Raises:
        InputError: it is not there, takes too long, or finds too few frames.
    """
    command = [sys.executable, "-P", str(_program(recording.name)), "--allow-invalid-header", str(path.absolute())]
    late, pipe = threading.Event(), subprocess.PIPE
    settings = {"stdin": subprocess.DEVNULL, "encoding": "utf-8", "errors": "replace"}
    with tempfile.TemporaryFile() as said, subprocess.Popen(command, stdout=pipe, stderr=said, **settings) as program:
        clock = threading.Timer(PATIENCE, lambda: (late.set(), program.kill()))
        clock.start()
        try:
            names, table, short, cut = _frames(csv.reader(program.stdout or ()))
            failed = program.wait() != 0
        except BaseException:
            program.kill()
            raise
        finally:
            clock.cancel()
        said.seek(max(said.tell() - LAST_WORDS, 0))
        last = said.read().decode("utf-8", "replace").strip().rpartition("\n")[2]
    if late.is_set():
        raise recording.fail("", f"is {KIND} that takes more than {PATIENCE:g} s to decode: it is damaged, or too long")
    words = f" ({PROGRAM} said: {(last or ', '.join(names))[:120]})" if failed else ""
    if len(table) < FEWEST:
        raise recording.fail("", f"is {KIND} with {len(table)} frames: it is cut short, or holds no flight{words}")
    if failed:
        recording.note(f"the log has no end: it may be cut short{words}")
    if cut:
        recording.note("the last frame is cut short and was left out")
    if short:
        recording.note(f"{short} frames have fewer than {len(names)} fields and were left out")
    return table.columns()


def _frames(rows: Iterator[list[str]]) -> tuple[list[str], NumberTable, int, bool]:
    """Names of the fields, frames, how many were too short, and whether the last was."""
    names = next(rows, [])
    table, short, cut = NumberTable({name: k for k, name in enumerate(names)}, words=True), 0, False
    for row in rows:
        short += cut
        cut = len(row) < len(names)
        if not cut:
            table.add(row)
    return names, table, short, cut


def _program(name: str) -> Path:
    """Orangebox's program that writes a log as CSV.

    Raises:
        InputError: it is not installed.
    """
    try:
        files = distribution(PACKAGE).files or []
    except PackageNotFoundError:
        files = []
    for file in files:
        if file.name == PROGRAM:
            return Path(str(file.locate()))
    raise InputError(name, "", f"is {KIND}, and {PACKAGE} is missing, which reads it: pip install 'hotlap[logs]'")


def _headers(content: bytes) -> dict[str, Any]:
    """The lines before the first frame, `H name:value`: whole numbers, lists of them, or text."""
    found = dict[str, Any]()
    for line in content.split(b"\n"):
        if not line.startswith(b"H "):
            break
        key, _, value = line[2:].decode("utf-8", "replace").partition(":")
        found[key.strip()] = _value(value.strip())
    return found


def _value(text: str) -> Any:
    try:
        numbers = [int(part, 0) for part in text.split(",")]
    except ValueError:
        return text
    return numbers[0] if len(numbers) == 1 else numbers


def _take(recording: Recording, columns: Mapping[str, Floats], headers: Mapping[str, Any]) -> None:
    times = columns["time"] * 1e-6
    found = VERSION.search(str(headers.get("Firmware revision", "")))
    version = tuple(map(int, found.groups())) if found else (4, 0, 0)
    if not found or "Betaflight" not in str(headers.get("Firmware revision", "")):
        recording.note(f"written by {headers.get('Firmware revision', 'nobody who says so')}: its units were taken as those of Betaflight")
    finer = 10.0 if int(headers.get("blackbox_high_resolution", 0) or 0) else 1.0
    degrees = np.pi / 180 / finer
    if (rates := _vector(recording, columns, "gyroADC")) is not None:
        recording.add("rates", times, rates * _gyro_scale(headers, degrees, finer), "rates: filtered by the firmware (gyroADC)")
    if (force := _vector(recording, columns, "accSmooth")) is not None:
        one = float(headers.get("acc_1G", 2048) or 2048)
        recording.add("acceleration", times, force * (GRAVITY / one))
    if (asked := _vector(recording, columns, "setpoint")) is not None:
        recording.add("rate_command", times, asked * degrees, "rate_command: setpoint, which holds the sweep of the chirp mode")
    else:
        recording.note("no setpoint was logged: rcCommand alone does not say which rates were asked for")
    if "setpoint[3]" in columns and version >= (4, 0, 0):
        recording.add("thrust_command", times, np.clip(columns["setpoint[3]"] / 1000, 0.0, 1.0))
    elif "rcCommand[3]" in columns:
        share = np.clip(columns["rcCommand[3]"] / finer / 1000 - 1, 0.0, 1.0)
        recording.add("thrust_command", times, share, "thrust_command: rcCommand, before the mixer's limits")
    _take_motors(recording, times, columns, headers)
    _take_battery(recording, times, columns, version)
    if (vector := _vector(recording, columns, "imuQuaternion")) is not None:
        parts = vector / 0x7FFF
        scalar = np.sqrt(np.clip(1 - (parts**2).sum(axis=1), 0.0, 1.0))
        recording.add("attitude", times, np.column_stack([scalar, parts]), "attitude: as the firmware estimates it")
    recording.note("Betaflight logs no position in metres")


def _gyro_scale(headers: Mapping[str, Any], degrees: float, finer: float) -> float:
    """[rad/s] of a unit of the gyro: 1 deg/s, unless the header has another scale, as the bits of a float."""
    given = headers.get("gyro_scale")
    scale = struct.unpack("<f", given.to_bytes(4, "little"))[0] if isinstance(given, int) and 0 < given < 2**32 else 1.0
    return degrees * scale if scale > 1e-3 else scale * 1e6 / finer  # of Cleanflight: rad/us


def _take_motors(recording: Recording, times: Floats, columns: Mapping[str, Floats], headers: Mapping[str, Any]) -> None:
    motors = [columns[f"motor[{i}]"] for i in range(8) if f"motor[{i}]" in columns]
    if motors:
        given = headers.get("motorOutput", [headers.get("minthrottle", 1070), headers.get("maxthrottle", 2000)])
        low, high = map(float, given)
        share = np.clip((np.column_stack(motors) - low) / (high - low), 0.0, 1.0)
        recording.add("motor_command", times, share, f"motor_command: 0 to 1 is {low:g} to {high:g} in the log")
    speeds = [columns[f"eRPM[{i}]"] for i in range(8) if f"eRPM[{i}]" in columns]
    if speeds and any(np.any(column > 0) for column in speeds):
        poles = float(headers.get("motor_poles", 14) or 14)
        turns = np.column_stack(speeds) * 100 / (poles / 2)
        recording.add("motor_speed", times, turns * (2 * np.pi / 60), f"motor_speed: of motors with {poles:g} poles")


def _take_battery(recording: Recording, times: Floats, columns: Mapping[str, Floats], version: tuple[int, ...]) -> None:
    volts = 0.01 if version >= (4, 0, 0) else 0.1
    if "vbatLatest" in columns and version >= (3, 1, 0):
        recording.add("battery", times, columns["vbatLatest"] * volts)
    if "amperageLatest" in columns and version >= (3, 1, 7):
        recording.add("current", times, columns["amperageLatest"] * 0.01)


def _vector(recording: Recording, columns: Mapping[str, Floats], name: str) -> Floats | None:
    """Three columns, shape (N, 3); None where there are none.

    Raises:
        InputError: one of them is missing.
    """
    wanted = [f"{name}[{i}]" for i in range(3)]
    missing = [column for column in wanted if column not in columns]
    if len(missing) == 3:
        return None
    if missing:
        raise recording.fail(name, f"has no {', '.join(missing)}")
    return np.column_stack([columns[column] for column in wanted])

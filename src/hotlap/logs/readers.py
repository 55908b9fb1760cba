"""Readers: a flight log from a file of PX4, Betaflight, ArduPilot, ROS, or a table, whichever it is."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from hotlap.core.errors import InputError
from hotlap.logs import blackbox, csv_table, dataflash, mcap_file, rosbag_file, ulog
from hotlap.logs.flight_log import FlightLog
from hotlap.logs.hotlap_csv import KIND as OWN
from hotlap.logs.hotlap_csv import is_hotlap_csv, read_hotlap_csv
from hotlap.logs.packages import quietly
from hotlap.logs.plausibility import check_units
from hotlap.system.text_files import cause_of

MOST_BYTES = 2_000_000_000  # of a log
MOST_OF_TEXT = 200_000_000  # and of what is decoded byte by byte
TEXT_OF_ARDUPILOT = b"FMT,"
LISTED = "PX4 ULog, Betaflight blackbox, ArduPilot dataflash, MCAP, ROS bag, CSV"

Reader = Callable[[Path, str, "Mapping[str, Any] | None"], FlightLog]


def read(path: str | Path, mapping: Mapping[str, Any] | None = None) -> FlightLog:
    """Read a flight log; which program wrote it is seen from its first bytes.

    Units and frames are converted to those of `COLUMNS`; `notes` says what was assumed.

    Args:
        path: a file, or the folder of a ROS 2 bag.
        mapping: of a CSV table, its columns by signal, with `time`, `units` and `frame`; of MCAP and ROS bags, topics by signal.

    Raises:
        InputError: it cannot be read, it is none of these, a package is missing, or its numbers cannot be in the units they should be in.
    """
    path = Path(path)
    name = str(path)
    try:
        kind, reader = _recognise(path, name)
        with quietly(kind, name):
            log = reader(path, name, mapping)
    except OSError as error:
        raise InputError(name, "", f"cannot be read: {cause_of(error)}") from None
    check_units(log)
    return log


def need(log: FlightLog, signals: Iterable[str], purpose: str) -> None:
    """Refuse a log without signals that are needed.

    Raises:
        InputError: says which are missing, and what for.
    """
    missing = [signal for signal in signals if signal not in log.signals]
    if missing:
        has = ", ".join(log.signals) or "nothing"
        raise InputError(log.name, "", f"has no {', '.join(missing)}, which {purpose} needs; it is {log.kind} with {has}")


def _recognise(path: Path, name: str) -> tuple[str, Reader]:
    """What a file is, and what reads it."""
    if path.is_dir():
        if not (path / "metadata.yaml").is_file():
            raise InputError(name, "", "is a folder, and no ROS 2 bag: it has no metadata.yaml")
        return rosbag_file.KIND, rosbag_file.read
    if not path.exists():
        raise InputError(name, "", "there is no such file")
    if not path.is_file():
        raise InputError(name, "", "is not a file that can be read from end to end")
    size = path.stat().st_size
    if size == 0:
        raise InputError(name, "", "is empty")
    with path.open("rb") as file:
        head = file.read(4096)
    kind, reader = _by_bytes(head, path)
    most = MOST_OF_TEXT if reader in {_blackbox, csv_table.read, _own} or head.startswith(TEXT_OF_ARDUPILOT) else MOST_BYTES
    if size > most:
        raise InputError(name, "", f"is larger than {most / 1e6:g} MB: cut out the flight")
    if reader in {csv_table.read, _own} and (_is_binary(head) or path.suffix.lower() in OTHERS):
        raise InputError(name, "", f"is no log that hotlap knows: {LISTED}")
    return kind, reader


def _by_bytes(head: bytes, path: Path) -> tuple[str, Reader]:
    """What a file is, by how it begins."""
    if head.startswith(b"ULog\x01\x12\x35"):
        return ulog.KIND, _ulog
    if head.startswith(b"H Product:Blackbox"):
        return blackbox.KIND, _blackbox
    if head.startswith(b"\xa3\x95") or (path.suffix.lower() == ".log" and head.startswith(TEXT_OF_ARDUPILOT)):
        return dataflash.KIND, _dataflash
    if head.startswith(b"\x89MCAP"):
        return mcap_file.KIND, mcap_file.read
    if head.startswith(b"#ROSBAG V2"):
        return rosbag_file.KIND, rosbag_file.read
    if head.startswith(b"SQLite format 3"):
        return rosbag_file.KIND, _in_folder
    expected = SUFFIXES.get(path.suffix.lower())
    if expected:
        return "", _refusing(expected)
    if is_hotlap_csv(head.split(b"\n", 1)[0].decode("utf-8", "replace")):
        return OWN, _own
    return csv_table.KIND, csv_table.read


SUFFIXES = {
    ".ulg": ulog.KIND,
    ".bbl": blackbox.KIND,
    ".bfl": blackbox.KIND,
    ".bin": dataflash.KIND,
    ".mcap": mcap_file.KIND,
    ".bag": rosbag_file.KIND,
}

OTHERS = frozenset({".toml", ".json", ".yaml", ".yml", ".xml", ".sdf", ".md", ".html", ".py"})  # text that is no table


def _refusing(expected: str) -> Reader:
    """What refuses a file whose name promises something else."""

    def refuse(path: Path, name: str, mapping: Mapping[str, Any] | None) -> FlightLog:  # noqa: ARG001  as readers are called
        raise InputError(name, "", f"does not begin like {expected}, as its name says: it is text, or damaged")

    return refuse


def _is_binary(head: bytes) -> bool:
    try:
        head[: -4 if len(head) == 4096 else None].decode("utf-8")
    except UnicodeDecodeError:
        return True
    return b"\0" in head


def _in_folder(path: Path, name: str, mapping: Mapping[str, Any] | None) -> FlightLog:
    """A database of a ROS 2 bag is read by its folder."""
    if not (path.parent / "metadata.yaml").is_file():
        raise InputError(name, "", f"is a part of a ROS 2 bag, and {os.fspath(path.parent)} has no metadata.yaml")
    return rosbag_file.read(path.parent, name, mapping)


def _own(path: Path, name: str, mapping: Mapping[str, Any] | None) -> FlightLog:
    return csv_table.read(path, name, mapping) if mapping is not None else read_hotlap_csv(path)


def _ulog(path: Path, name: str, mapping: Mapping[str, Any] | None) -> FlightLog:
    return _unmapped(ulog.read(path, name), mapping)


def _blackbox(path: Path, name: str, mapping: Mapping[str, Any] | None) -> FlightLog:
    return _unmapped(blackbox.read(path, name), mapping)


def _dataflash(path: Path, name: str, mapping: Mapping[str, Any] | None) -> FlightLog:
    return _unmapped(dataflash.read(path, name), mapping)


def _unmapped(log: FlightLog, mapping: Mapping[str, Any] | None) -> FlightLog:
    """A log that names its own columns; says so where a map was given."""
    return log if mapping is None else replace(log, notes=(*log.notes, f"the map was not used: {log.kind} names its own columns"))

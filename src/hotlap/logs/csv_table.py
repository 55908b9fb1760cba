"""CSV: any table with a row a sample, by a key map or by the names of its columns."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from hotlap.core.records import Floats
from hotlap.logs.flight_log import FlightLog
from hotlap.logs.frames import TURNED, turn, turn_attitude
from hotlap.logs.key_map import TIME, KeyMap, guess_map, make_map
from hotlap.logs.number_table import NumberTable, is_number
from hotlap.logs.recording import Recording

KIND = "a CSV table"
FEWEST = 2  # rows
TURNING = {"position": turn, "velocity": turn, "rates": turn, "rate_command": turn, "acceleration": turn, "attitude": turn_attitude}


def read(path: Path, name: str, mapping: Mapping[str, Any] | None) -> FlightLog:
    """Read a log; see `readers.read`."""
    recording = Recording(name, KIND)
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            heads, mark = _heads(recording, file)
            keys = _keys(recording, heads, mapping)
            columns = _columns(recording, csv.reader(file, delimiter=mark), heads, keys)
    except (UnicodeDecodeError, csv.Error):
        raise recording.fail("", "is neither a log that hotlap knows nor a table of text") from None
    signals = {
        signal: np.column_stack([columns[column] for column in names]) * keys.scale(signal) for signal, names in keys.columns.items()
    }
    for signal, values in signals.items():
        if signal != TIME:
            recording.add(signal, signals[TIME][:, 0], TURNING[signal](values) if keys.down and signal in TURNING else values)
    if keys.down:
        recording.note(TURNED)
    return recording.finish()


def _heads(recording: Recording, file: TextIO) -> tuple[list[str], str]:
    """The names of the columns, and what stands between them.

    Raises:
        InputError: it is no table.
    """
    head = file.readline(100_000)
    if "\0" in head:
        raise recording.fail("", "is neither a log that hotlap knows nor a table of text")
    mark = max(",;\t", key=head.count)
    mark = mark if mark in head else " "
    heads = [cell.strip().strip('"').strip() for cell in (head.split(mark) if mark != " " else head.split())]
    if len(heads) < 2 or all(map(is_number, heads)):
        raise recording.fail("", "is no table: its first line must name the columns")
    return heads, mark


def _keys(recording: Recording, heads: Sequence[str], mapping: Mapping[str, Any] | None) -> KeyMap:
    """Which columns are what.

    Raises:
        InputError: there is no time, nothing beside it, or a column is missing.
    """
    keys = make_map(mapping) if mapping is not None else guess_map(heads)
    if TIME not in keys.columns:
        raise recording.fail("", f"has no column of times that hotlap knows, of {_few(heads)}: say which with a key map (map=...)")
    if len(keys.columns) == 1:
        raise recording.fail("", f"has no column that hotlap knows beside the time, of {_few(heads)}: say which with a key map (map=...)")
    if mapping is None:
        recording.note("columns were known by their names: " + "; ".join(f"{key}: {' '.join(of)}" for key, of in keys.columns.items()))
    for signal, names in keys.columns.items():
        missing = [name for name in names if name not in heads]
        if missing:
            raise recording.fail(signal, f"has no column {', '.join(missing)}; there are {_few(heads)}")
    return keys


def _columns(recording: Recording, rows: Any, heads: Sequence[str], keys: KeyMap) -> dict[str, Floats]:
    """The columns that are asked for, by name, read row by row.

    Raises:
        InputError: there are too few rows, or one is none of numbers.
    """
    table = NumberTable({name: heads.index(name) for names in keys.columns.values() for name in names})
    last, line = list[str](), 0
    for row in rows:
        if row:
            _take(recording, table, last, line, len(heads))
            last, line = row, rows.line_num + 1
    if last and len(last) < len(heads):  # written to when it was cut
        recording.note("the last row is cut short and was left out")
    else:
        _take(recording, table, last, line, len(heads))
    if len(table) < FEWEST:
        raise recording.fail("", f"has {len(table)} rows below its head: this is no flight")
    return table.columns()


def _take(recording: Recording, table: NumberTable, row: Sequence[str], line: int, width: int) -> None:
    """Take up a row, if there is one."""
    try:
        if row:
            table.add(row)
    except IndexError:
        raise recording.fail(f"line {line}", f"has {len(row)} cells, and the head {width}") from None
    except ValueError:
        name, text = table.wrong(row)
        raise recording.fail(f"line {line}, {name}", f"must be a number, not '{text[:40]}'") from None


def _few(heads: Sequence[str]) -> str:
    """Some names of columns."""
    return ", ".join(heads[:12]) + (", ..." if len(heads) > 12 else "")

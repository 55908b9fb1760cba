"""CSV: any table with a row a sample, by a key map or by the names of its columns."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hotlap.core.records import Floats
from hotlap.logs.flight_log import FlightLog
from hotlap.logs.frames import TURNED, turn, turn_attitude
from hotlap.logs.key_map import TIME, KeyMap, guess_map, make_map
from hotlap.logs.recording import Recording

KIND = "a CSV table"
FEWEST = 2  # rows
TURNING = {"position": turn, "velocity": turn, "rates": turn, "rate_command": turn, "acceleration": turn, "attitude": turn_attitude}


def read(path: Path, name: str, mapping: Mapping[str, Any] | None) -> FlightLog:
    """Read a log; see `readers.read`."""
    recording = Recording(name, KIND)
    heads, rows = _rows(recording, path)
    keys = make_map(mapping) if mapping is not None else guess_map(heads)
    if TIME not in keys.columns:
        raise recording.fail("", f"has no column of times that hotlap knows, of {_few(heads)}: say which with a key map (map=...)")
    if len(keys.columns) == 1:
        raise recording.fail("", f"has no column that hotlap knows beside the time, of {_few(heads)}: say which with a key map (map=...)")
    if mapping is None:
        recording.note("columns were known by their names: " + "; ".join(f"{key}: {' '.join(of)}" for key, of in keys.columns.items()))
    times = _numbers(recording, heads, rows, TIME, keys)[:, 0]
    for signal in keys.columns:
        if signal != TIME:
            values = _numbers(recording, heads, rows, signal, keys)
            recording.add(signal, times, TURNING[signal](values) if keys.down and signal in TURNING else values)
    if keys.down:
        recording.note(TURNED)
    return recording.finish()


def _rows(recording: Recording, path: Path) -> tuple[list[str], list[list[str]]]:
    """The head of the table, and its rows.

    Raises:
        InputError: it is no table.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            head = file.readline(100_000)
            if "\0" in head:
                raise recording.fail("", "is neither a log that hotlap knows nor a table of text")
            mark = max(",;\t", key=head.count)
            heads = [cell.strip().strip('"').strip() for cell in (head.split(mark) if mark in head else head.split())]
            rows = [row for row in csv.reader(file, delimiter=mark if mark in head else " ") if row]
    except (UnicodeDecodeError, csv.Error):
        raise recording.fail("", "is neither a log that hotlap knows nor a table of text") from None
    if len(heads) < 2 or all(_is_number(head) for head in heads):
        raise recording.fail("", "is no table: its first line must name the columns")
    if len(rows) < FEWEST:
        raise recording.fail("", f"has {len(rows)} rows below its head: this is no flight")
    if len(rows[-1]) < len(heads):  # written to when it was cut
        recording.note("the last row is cut short and was left out")
        rows.pop()
    return heads, rows


def _numbers(recording: Recording, heads: Sequence[str], rows: Sequence[Sequence[str]], signal: str, keys: KeyMap) -> Floats:
    """The columns of a signal as numbers in hotlap's units, shape (N, columns)."""
    names = keys.columns[signal]
    missing = [name for name in names if name not in heads]
    if missing:
        raise recording.fail(signal, f"has no column {', '.join(missing)}; there are {_few(heads)}")
    places = [heads.index(name) for name in names]
    numbers = np.empty((len(rows), len(places)))
    for i, row in enumerate(rows):
        for j, place in enumerate(places):
            try:
                numbers[i, j] = float(row[place] or "nan")
            except ValueError:
                raise recording.fail(f"line {i + 2}, {names[j]}", f"must be a number, not '{row[place][:40]}'") from None
            except IndexError:
                raise recording.fail(f"line {i + 2}", f"has {len(row)} cells, and the head {len(heads)}") from None
    return numbers * keys.scale(signal)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _few(heads: Sequence[str]) -> str:
    """Some names of columns."""
    return ", ".join(heads[:12]) + (", ..." if len(heads) > 12 else "")

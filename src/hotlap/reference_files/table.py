"""Tables: the columns of a reference's file, whatever its separators, its order of columns and its names for them.

A file has a line for each moment. What is needed is `t, p_x, p_y, p_z`; the other columns stand in groups of which all or none are
there: attitude (q, or roll, pitch, yaw), velocity, body rates, rotor thrusts, acceleration, yaw.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.files.error_messages import show
from hotlap.reference_files.columns import GROUPS, KNOWN, REQUIRED, THRUST_NAMES, Column, by_count, columns_of
from hotlap.system.regular_files import is_there, read_text

Floats = NDArray[np.float64]

MAX_BYTES = 20_000_000  # the largest known, with the columns of complementary progress, takes half
LEAST_ROWS = 10
LARGEST = 1e20  # a number beyond it is a mistake, of which squares and sums might overflow; nanoseconds since 1970 have 1e18
COMMENTS = ("#", "%", "//")
PLACES = {name: place for place, name in enumerate(KNOWN)}
TIME, POSITION, ATTITUDE, VELOCITY, RATES, THRUSTS = 0, slice(1, 4), slice(4, 8), slice(8, 11), slice(11, 14), slice(14, 18)
ACCELERATION, ANGLES, YAW = slice(18, 21), slice(21, 24), 23
_DECIMAL_COMMA = re.compile(r"\s*[-+]?\d+,\d+([eE][-+]?\d+)?\s*")


@dataclass(frozen=True)
class Table:
    """The columns of a file.

    Attributes:
        source: the file, for messages.
        values: shape (rows, 24), in the order of `KNOWN`; NaN where the file has no such column.
        lines: shape (rows,) line of the file that each row stands in.
        given: names of the columns that the file has.
        notes: what was assumed about it, a clause each.
    """

    source: str
    values: Floats
    lines: NDArray[np.int64]
    given: frozenset[str]
    notes: tuple[str, ...] = ()

    def has(self, group: str) -> bool:
        """Whether a group of columns is there, by its name in `GROUPS`."""
        return self.given.issuperset(GROUPS[group])

    def noted(self, *notes: str) -> Table:
        """The same with further notes."""
        return replace(self, notes=(*self.notes, *notes))

    def without(self, group: str, note: str) -> Table:
        """The same as if a group of columns were not there."""
        values = self.values.copy()
        values[:, [PLACES[name] for name in GROUPS[group]]] = np.nan
        return replace(self, values=values, given=self.given - set(GROUPS[group]), notes=(*self.notes, note))

    def angles(self) -> Floats:
        """Roll, pitch and yaw, shape (rows, 3) [rad]."""
        return self.values[:, ANGLES]

    def with_attitudes(self, attitudes: Floats) -> Table:
        """The same with attitudes, shape (rows, 4)."""
        values = self.values.copy()
        values[:, ATTITUDE] = attitudes
        return replace(self, values=values, given=self.given | set(GROUPS["attitude"]))

    def with_values(self, values: Floats) -> Table:
        """The same with other values."""
        return replace(self, values=values)

    def rows(self, kept: NDArray[np.bool_]) -> Table:
        """Some of its rows."""
        return replace(self, values=self.values[kept], lines=self.lines[kept])

    def error(self, row: int, column: str, reason: str) -> InputError:
        """The fault of one value, or of a whole row where the column is ""."""
        return _fault(self.source, int(self.lines[row]), column, reason)


def read_table(path: Path) -> Table:
    """The columns of a file, every value a finite number.

    Raises:
        InputError: with the file, the line and column, and the reason.
    """
    source, notes = str(path), list[str]()
    numbered = [(number, line) for number, line in enumerate(_text(path).splitlines(), 1) if line.strip()]
    comments = [(number, line) for number, line in numbered if line.lstrip().startswith(COMMENTS)]
    kept = [(number, line) for number, line in numbered if not line.lstrip().startswith(COMMENTS)]
    if not kept and not comments:
        raise InputError(source, "line 1", "is empty; it must be a header that names the columns")
    separator = _separator(kept[0][1] if kept else "")
    cells = _cells(source, kept, separator)
    header, cells = _header(source, comments, cells, separator)
    if separator != "," and any("," in cell and _DECIMAL_COMMA.fullmatch(cell) for _, row in cells for cell in row):
        cells = [(line, [cell.replace(",", ".") for cell in row]) for line, row in cells]
        notes.append("decimal commas are read as points")
    columns = columns_of(source, *header) if header is not None else _guessed(source, cells, notes)
    table = _numbers(source, columns, cells)
    odd = [column for column in columns.values() if column.factor != 1.0]
    notes += (
        [f"{', '.join(column.name for column in odd)}: read in {', '.join(dict.fromkeys(column.unit for column in odd))}"] if odd else []
    )
    return table.noted(*notes)


def _text(path: Path) -> str:
    """What stands in a file."""
    if path.suffix.lower() == ".toml" and is_there(path):
        raise InputError(str(path), "", "is TOML, and no reference: that is a table of numbers, CSV")
    return read_text(path, MAX_BYTES, "this is no reference").replace("\r\n", "\n").replace("\r", "\n")


def _separator(line: str) -> str:
    """What stands between the values of a line: `;`, a tab, a comma, or spaces ("")."""
    return next((mark for mark in (";", "\t", ",") if mark in line), "")


def _cells(source: str, lines: Sequence[tuple[int, str]], separator: str) -> list[tuple[int, list[str]]]:
    """The values of each line, with its number."""
    if not separator:
        return [(number, line.split()) for number, line in lines]
    reader = csv.reader((line for _, line in lines), delimiter=separator)
    try:
        rows = [(lines[reader.line_num - 1][0], row) for row in reader]
    except csv.Error as error:
        raise InputError(source, f"line {lines[max(reader.line_num, 1) - 1][0]}", f"is no CSV: {error}") from None
    return [(number, row) for number, row in rows if any(cell.strip() for cell in row)]


def _header(
    source: str, comments: Sequence[tuple[int, str]], cells: list[tuple[int, list[str]]], separator: str
) -> tuple[tuple[int, list[str]] | None, list[tuple[int, list[str]]]]:
    """Line and names of the columns, None where nothing names them, and the rows below."""
    if cells and not all(_is_number(cell) for cell in cells[0][1] if cell.strip()):
        return cells[0], cells[1:]
    for line, comment in reversed(comments):  # a header may be a comment
        text = comment.strip().lstrip("#%/").strip()
        for names in (text.split(separator) if separator else text.split(), re.split(r"[,;\s]+", text)):
            if sum(1 for name in names if name.strip() in PLACES) >= len(REQUIRED):
                return (line, list(names)), cells
    if not cells:
        raise InputError(source, "", f"has 0 rows; a flight takes at least {LEAST_ROWS}")
    return None, cells


def _guessed(source: str, cells: Sequence[tuple[int, list[str]]], notes: list[str]) -> dict[str, Column]:
    """Columns by their number, where there is no header."""
    rows = [[_value(cell) for cell in row if cell.strip()] for _, row in cells[:200]]
    width, line = len(rows[0]), cells[0][0]
    values = np.array([row for row in rows if len(row) == width])
    values[np.abs(values) > LARGEST] = np.nan  # refused later, where its column has a name
    index = len(values) > 1 and bool(np.array_equal(values[:, 0], values[0, 0] + np.arange(len(values)))) and width > len(REQUIRED)
    for skipped in (1, 0) if index else (0,):
        names = by_count(values[:, skipped:])
        if names:
            first = "an index, " if skipped else ""
            notes.append(f"it has no header; its {width} columns are read as {first}{', '.join(names)}")
            return {name: Column(name, place + skipped) for place, name in enumerate(names)}
    reason = f"is no header, and {width} columns could be anything; name them in the first line, as t,p_x,p_y,p_z,v_x,v_y,v_z"
    raise InputError(source, f"line {line}", reason)


def _numbers(source: str, columns: dict[str, Column], cells: Sequence[tuple[int, list[str]]]) -> Table:
    """Every value as a number, in SI units."""
    last, values = cells[-1][0] if cells else 0, np.full((len(cells), len(KNOWN)), np.nan)
    ordered = sorted(columns.values(), key=lambda column: PLACES[column.name])
    places = [PLACES[column.name] for column in ordered]
    for k, (line, row) in enumerate(cells):
        values[k, places] = [_number(source, line, column, row, line == last) for column in ordered]
    if len(cells) < LEAST_ROWS:
        raise InputError(source, "", f"has {len(cells)} rows; a flight takes at least {LEAST_ROWS}")
    factors = np.array([column.factor for column in ordered])
    if (factors != 1).any():
        values[:, places] = (values[:, places] - np.where(np.array(places) == TIME, values[0, TIME], 0.0)) * factors
    table = Table(source, values, np.array([line for line, _ in cells]), frozenset(columns))
    if table.has("thrusts"):
        _mend_last_thrusts(values)
    return table


def _number(source: str, line: int, column: Column, row: list[str], last: bool) -> float:
    """One value; a thrust in the last row need not be there, for nothing follows it."""
    cell = row[column.place].strip() if column.place < len(row) else ""
    value = _value(cell)
    if abs(value) <= LARGEST:
        return value
    if last and column.name in THRUST_NAMES:
        return np.nan
    if column.place >= len(row):
        raise _fault(source, line, column.name, f"is missing: the line has only {len(row)} values")
    raise _fault(source, line, column.name, f"must be a finite number, not {show(cell)}")


def _value(cell: str) -> float:
    """A number; NaN where it is none."""
    try:
        return float(cell)
    except ValueError:
        return np.nan


def _is_number(cell: str) -> bool:
    """Whether something stands for a number, a decimal comma allowed."""
    return not np.isnan(_value(cell.replace(",", "."))) or cell.strip().lower() == "nan"


def _mend_last_thrusts(values: Floats) -> None:
    """Repeat the last thrusts but one where the last ones are unlike any before: they are often zeros or NaN."""
    before, last = values[:-1, THRUSTS], values[-1, THRUSTS]
    like = np.all(last >= 0) and np.all(last <= 1.001 * before.max()) and last.sum() >= 0.999 * before.sum(axis=1).min()
    if not like:
        values[-1, THRUSTS] = values[-2, THRUSTS]


def without_repeated(table: Table) -> Table:
    """The table without rows that stand there twice; of two that differ in thrusts alone the later one is kept: it holds from there on.

    Raises:
        InputError: two rows of one time differ.
    """
    times, states = table.values[:, TIME], np.nan_to_num(table.values[:, 1:14])
    same_time = np.abs(np.diff(times)) < 1e-12
    if not same_time.any():
        return table
    scale = np.maximum(np.abs(states).max(axis=0), 1.0)
    differs = (np.abs(np.diff(states, axis=0)) > 1e-6 * scale).any(axis=1) & same_time
    if differs.any():
        row = int(differs.argmax()) + 1
        raise table.error(row, "t", f"{times[row]:g} s stands in line {table.lines[row - 1]} already, with other values")
    count = int(same_time.sum())
    rows = "a row that is there twice was" if count == 1 else f"{count} rows that are there twice were"
    return table.rows(np.append(~same_time, True)).noted(f"{rows} dropped")


def _fault(source: str, line: int, column: str, reason: str) -> InputError:
    """The fault of one value of a file."""
    return InputError(source, f"line {line}" + (f", {column}" if column else ""), reason)

"""hotlap's own CSV: what `hotlap fly --log` writes, as a flight log, and the other way round."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from hotlap.core.errors import InputError
from hotlap.core.records import Floats, columns_of
from hotlap.logs.flight_log import FlightLog, Signal
from hotlap.logs.number_table import NumberTable
from hotlap.logs.recording import LARGEST
from hotlap.system.text_files import replace

KIND = "a flight of hotlap (CSV)"
FULL_THRUST = "full_thrust"  # fact: thrust per mass [m/s^2] that a thrust command of 1 stands for
GROUPS = {
    "position": ("p_x", "p_y", "p_z"),
    "attitude": ("q_w", "q_x", "q_y", "q_z"),
    "velocity": ("v_x", "v_y", "v_z"),
    "rates": ("w_x", "w_y", "w_z"),
    "rate_command": ("command_w_x", "command_w_y", "command_w_z"),
    "thrust_command": ("command_thrust",),
}
NEEDED = ("t", *GROUPS["rates"], *GROUPS["rate_command"])


def read_hotlap_csv(path: str | Path) -> FlightLog:
    """Read one.

    Args:
        path: a file with the columns of `hotlap fly --log`; those of the rotors and the estimates need not be there.

    Returns:
        The log; its thrust command is what the file has, thrust per mass, over the largest in it, which is the fact `full_thrust`.

    Raises:
        InputError: there is no such file, a column is missing, or a row is none of numbers.
    """
    table = _read(Path(path))
    label = str(path)
    times = table["t"]
    if len(times) < 2 or (np.diff(times) <= 0).any():
        raise InputError(label, "t", "must increase from row to row, over two rows or more")
    signals, facts, notes = dict[str, Signal](), {}, list[str]()
    for signal, names in GROUPS.items():
        if all(name in table for name in names):
            values = np.column_stack([table[name] for name in names])
            good = np.abs(values) < LARGEST
            if not good.all():
                row = int(np.argwhere(~good)[0, 0])
                raise InputError(label, signal, f"is not finite in row {row + 2}")
            signals[signal] = Signal(times, values)
        elif any(name in table for name in names):
            raise InputError(label, next(name for name in names if name not in table), "this column is missing, others of its kind are not")
    if "thrust_command" in signals:
        largest = float(signals["thrust_command"].values.max())
        if largest <= 0:
            raise InputError(label, "command_thrust", "is never above 0")
        signals["thrust_command"] = Signal(times, signals["thrust_command"].values / largest)
        facts[FULL_THRUST] = largest
        notes.append(f"thrust command 1 is {largest:.4g} m/s^2, the largest in the log")
    return FlightLog(label, KIND, signals, facts, tuple(notes))


def is_hotlap_csv(header: str) -> bool:
    """Whether the first line of a file is that of a log of hotlap."""
    return set(NEEDED) <= {name.strip() for name in header.split(",")}


def write_hotlap_csv(path: str | Path, log: FlightLog) -> None:
    """Write a log with the columns of `hotlap fly --log`; all its signals on the times of the rates, NaN where there is none.

    Args:
        path: of the file.
        log: with the fact `full_thrust`, or else thrust commands are written as they are.
    """
    times, full = log.signals["rates"].times, float(log.facts.get(FULL_THRUST, 1.0))
    columns = {name: np.full(len(times), np.nan) for name in columns_of(4)}
    columns["t"] = times
    for signal, names in GROUPS.items():
        if signal in log.signals:
            values = log.signals[signal].at(times) * (full if signal == "thrust_command" else 1.0)
            columns.update(zip(names, values.T, strict=True))
    rows = np.column_stack(list(columns.values())).tolist()
    replace(path, "\n".join([",".join(columns), *(",".join(map(repr, row)) for row in rows)]) + "\n")


def _read(path: Path) -> dict[str, Floats]:
    """Columns by name."""
    label = str(path)
    try:
        with path.open(encoding="utf-8") as file:
            return _table(label, (line for line in enumerate(file, start=1) if line[1].strip()))
    except FileNotFoundError:
        raise InputError(label, "", "there is no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(label, "", f"cannot be read as text: {getattr(error, 'strerror', None) or 'it is no UTF-8'}") from None


def _table(label: str, lines: Iterator[tuple[int, str]]) -> dict[str, Floats]:
    """Columns by name, of lines with their numbers."""
    _, head = next(lines, (0, ""))
    names = [name.strip() for name in head.split(",")]
    table = NumberTable({name: k for k, name in enumerate(names)})
    for number, line in lines:
        row = line.rstrip("\r\n").split(",")
        for name in NEEDED if not len(table) else ():
            if name not in names:
                raise InputError(label, name, f"this column is missing; a log of hotlap has {', '.join(NEEDED)}")
        if len(row) != len(names):
            raise InputError(label, f"row {number}", f"has {len(row)} values, the header has {len(names)}: is the file cut off?")
        try:
            table.add(row)
        except ValueError:
            raise InputError(label, f"row {number}", f"'{table.wrong(row)[1].strip()[:30]}' is no number") from None
    if not len(table):
        raise InputError(label, "", "is empty: a header and rows of numbers are needed")
    return table.columns()

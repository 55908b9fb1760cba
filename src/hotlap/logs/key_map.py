"""Key map: which columns of a table are which signal, in which unit and frame."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from hotlap.core.errors import InputError, UnknownNameError
from hotlap.files.toml_reader import read
from hotlap.logs.flight_log import COLUMNS

TIME, UNITS, FRAME = "time", "units", "frame"
UP, DOWN = "up", "ned"
FRAMES = (UP, DOWN)
SCALES: Mapping[str, Mapping[str, float]] = {  # by signal, what a unit is in hotlap's own
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "position": {"m": 1.0, "cm": 0.01, "mm": 1e-3},
    "velocity": {"m/s": 1.0, "cm/s": 0.01, "mm/s": 1e-3},
    "rates": {"rad/s": 1.0, "deg/s": np.pi / 180},
    "rate_command": {"rad/s": 1.0, "deg/s": np.pi / 180},
    "acceleration": {"m/s^2": 1.0, "g": 9.80665},
    "thrust_command": {"1": 1.0, "%": 0.01},
    "motor_command": {"1": 1.0, "%": 0.01},
    "motor_speed": {"rad/s": 1.0, "rpm": 2 * np.pi / 60},
    "battery": {"V": 1.0, "mV": 1e-3},
    "current": {"A": 1.0, "mA": 1e-3},
}
GUESSES: Mapping[str, Sequence[str]] = {  # names that tables have
    "time": ("t", "time", "timestamp", "time_s", "t_s"),
    "position": ("p_x p_y p_z", "px py pz", "pos_x pos_y pos_z", "position_x position_y position_z", "x y z"),
    "velocity": ("v_x v_y v_z", "vx vy vz", "vel_x vel_y vel_z", "velocity_x velocity_y velocity_z"),
    "attitude": ("q_w q_x q_y q_z", "qw qx qy qz", "quat_w quat_x quat_y quat_z"),
    "rates": ("w_x w_y w_z", "wx wy wz", "omega_x omega_y omega_z", "gyro_x gyro_y gyro_z", "p q r"),
    "acceleration": ("a_x a_y a_z", "ax ay az", "acc_x acc_y acc_z"),
    "rate_command": ("command_w_x command_w_y command_w_z", "w_cmd_x w_cmd_y w_cmd_z", "rate_x_des rate_y_des rate_z_des"),
    "thrust_command": ("thrust", "throttle", "thrust_command"),
    "battery": ("battery", "voltage", "vbat", "battery_voltage"),
    "current": ("current",),
}


@dataclass(frozen=True)
class KeyMap:
    """What the columns of a table are.

    Attributes:
        columns: of each signal, and of the time.
        units: of those that are not in hotlap's own.
        down: whether the axes are north, east, down and forward, right, down.
    """

    columns: Mapping[str, tuple[str, ...]]
    units: Mapping[str, str] = field(default_factory=dict)
    down: bool = False

    def scale(self, signal: str) -> float:
        """What one of its unit is in hotlap's own."""
        return SCALES.get(signal, {}).get(self.units.get(signal, ""), 1.0)


class WrittenMap(dict[str, Any]):
    """A map that was read from a file, which messages name.

    Args:
        content: of the file.
        source: its name.
    """

    def __init__(self, content: Mapping[str, Any], source: str) -> None:
        super().__init__(content)
        self.source = source


def source_of(given: Mapping[str, Any]) -> str:
    """The file that a map was read from; "" for none."""
    return given.source if isinstance(given, WrittenMap) else ""


def load_map(path: Path) -> WrittenMap:
    """A map that is written as TOML.

    Raises:
        InputError: it cannot be read.
    """
    return WrittenMap(read(path, str(path)), str(path))


def asked_map(given: str | Path | Mapping[str, Any] | None) -> Mapping[str, Any] | None:
    """A map as it is asked for: a file, or what one would hold.

    Raises:
        InputError: the file cannot be read.
    """
    return load_map(Path(given)) if isinstance(given, str | Path) else given


def make_map(given: Mapping[str, Any]) -> KeyMap:
    """A map from what was given: columns by signal, `time`, and if need be `units` and `frame`.

    Raises:
        InputError: a key is unknown, or a value is of no use.
    """
    columns: dict[str, tuple[str, ...]] = {}
    source = source_of(given) or "map"
    for key, value in given.items():
        if key in {UNITS, FRAME}:
            continue
        if key != TIME and key not in COLUMNS:
            raise UnknownNameError("signal", key, (TIME, *COLUMNS, UNITS, FRAME), source, key)
        names = value.replace(",", " ").split() if isinstance(value, str) else value
        if not isinstance(names, list | tuple) or not names or not all(isinstance(name, str) for name in names):
            raise InputError(source, key, "must be the names of columns")
        wanted = 1 if key == TIME else COLUMNS[key]
        if wanted and len(names) != wanted:
            raise InputError(source, key, f"needs {wanted} column{'s' if wanted > 1 else ''}, not {len(names)}")
        columns[key] = tuple(names)
    if TIME not in columns:
        raise InputError(source, TIME, "is missing: the column that holds the time")
    return KeyMap(columns, _units(given.get(UNITS, {}), source), _is_down(given.get(FRAME, UP), source))


def guess_map(heads: Iterable[str]) -> KeyMap:
    """A map from the names of columns alone."""
    known = {head.lower(): head for head in heads}
    columns = {}
    for signal, guesses in GUESSES.items():
        for guess in guesses:
            names = guess.split()
            if any(name in known for name in names) and (len(names) == 1 or names[0] not in "xp" or names[1] in known):
                columns[signal] = tuple(known.get(name, name) for name in names)
                break
    return KeyMap(columns)


def _units(given: Any, source: str) -> dict[str, str]:
    if not isinstance(given, Mapping):
        raise InputError(source, UNITS, "must be a table of units by signal")
    for signal, unit in given.items():
        if signal not in SCALES:
            raise UnknownNameError("signal with a unit", str(signal), SCALES, source, UNITS)
        if unit not in SCALES[signal]:
            raise UnknownNameError("unit", str(unit), SCALES[signal], source, f"{UNITS}.{signal}")
    return dict(given)


def _is_down(given: Any, source: str) -> bool:
    if str(given).lower() not in FRAMES:
        raise UnknownNameError("frame", str(given), FRAMES, source, FRAME)
    return str(given).lower() == DOWN

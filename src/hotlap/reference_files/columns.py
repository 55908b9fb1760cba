"""Columns: the names, units and order in which files of the field say what a reference does."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError

Floats = NDArray[np.float64]

GROUPS: Mapping[str, tuple[str, ...]] = {
    "time": ("t",),
    "position": ("p_x", "p_y", "p_z"),
    "attitude": ("q_w", "q_x", "q_y", "q_z"),
    "velocity": ("v_x", "v_y", "v_z"),
    "rates": ("w_x", "w_y", "w_z"),
    "thrusts": ("u_1", "u_2", "u_3", "u_4"),
    "acceleration": ("a_x", "a_y", "a_z"),
    "angles": ("roll", "pitch", "yaw"),
    "yaw": ("yaw",),
}
WHOLE = ("time", "position", "attitude", "velocity", "rates", "thrusts")  # what `save_reference` writes, in the field's order
KNOWN = tuple(name for group in (*WHOLE, "acceleration", "angles") for name in GROUPS[group])
REQUIRED = (*GROUPS["time"], *GROUPS["position"])
THRUST_NAMES = frozenset(GROUPS["thrusts"])

_OTHER_NAMES: Mapping[str, tuple[str, ...]] = {
    "t": ("time", "timestamp", "t_s", "time_s"),
    "yaw": ("psi", "heading"),
    "roll": ("phi",),
    "pitch": ("theta",),
    **{f"p_{axis}": (f"p{axis}", f"pos_{axis}", f"position_{axis}", axis) for axis in "xyz"},
    **{f"v_{axis}": (f"v{axis}", f"vel_{axis}", f"velocity_{axis}") for axis in "xyz"},
    **{f"a_{axis}": (f"a_lin_{axis}", f"a{axis}", f"acc_{axis}", f"accel_{axis}", f"acceleration_{axis}") for axis in "xyz"},
    **{f"w_{axis}": (f"w{axis}", f"omega_{axis}", f"rate_{axis}", f"rates_{axis}") for axis in "xyz"},
    **{f"q_{part}": (f"q{part}", f"quat_{part}", f"quaternion_{part}", f"orientation_{part}") for part in "wxyz"},
    **{f"u_{rotor}": (f"u{rotor}", f"thrust_{rotor}") for rotor in "1234"},
}
_DEGREE = math.pi / 180
_ANGLES: Mapping[str, float] = {"rad": 1.0, "radians": 1.0, **dict.fromkeys(("deg", "degrees", "\u00b0"), _DEGREE)}
_UNITS: Mapping[str, Mapping[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "position": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "attitude": {},
    "velocity": {"m/s": 1.0, "km/h": 1 / 3.6, "cm/s": 1e-2, "mm/s": 1e-3},
    "rates": {"rad/s": 1.0, **dict.fromkeys(("deg/s", "deg_s", "dps", "\u00b0/s"), _DEGREE), **_ANGLES},
    "thrusts": {"n": 1.0},
    "acceleration": dict.fromkeys(("m/s^2", "m/s2", "m/s/s", "m/s\u00b2"), 1.0),
    "angles": _ANGLES,
}
_NONE = {"": 1.0, "-": 1.0, "1": 1.0}
_BRACKETED = re.compile(r"(.*?)[\s_]*[\[(]\s*(.*?)\s*[\])]")
_SUFFIXED = re.compile(r"(.*)_(deg/s|deg_s|degrees|deg|rad|dps|ns|us|ms|mm|cm)")


@dataclass(frozen=True)
class Column:
    """A column of a file.

    Attributes:
        name: one of `KNOWN`.
        place: where it stands, from 0.
        unit: as the file says it; "" where it says nothing.
        factor: that makes SI units of it.
    """

    name: str
    place: int
    unit: str = ""
    factor: float = 1.0


def columns_of(source: str, line: int, header: Sequence[str]) -> dict[str, Column]:
    """The columns that a header names; whatever else stands there is ignored.

    Args:
        source: the file, for messages.
        line: where the header stands.
        header: names as they stand in the file.

    Raises:
        InputError: a column is missing, stands there twice or has a unit that is not known.
    """
    names = [name.strip().strip("\"'").lstrip("#%/").strip() for name in header]
    found = {name: column for name in KNOWN if (column := _find(source, name, names))}
    if not set(found) & set(REQUIRED):
        raise InputError(source, f"line {line}", f"is no header of a reference; it must have the columns {','.join(REQUIRED)}")
    _refuse_partial(source, found)
    return found


def _find(source: str, name: str, names: Sequence[str]) -> Column | None:
    """Where a column stands: by its own name, else by another name that the field has for it, with or without a unit."""
    exact = [place for place, other in enumerate(names) if other == name]
    if len(exact) > 1:
        raise InputError(source, name, "this column stands there twice")
    if exact:
        return Column(name, exact[0])
    plain = [_plain(other) for other in names]
    for known in (name, *_OTHER_NAMES.get(name, ())):
        places = [place for place, (other, _) in enumerate(plain) if other == known]
        if len(places) > 1:
            raise InputError(source, name, f"this column stands there twice, as {' and '.join(names[place] for place in places)}")
        if places:
            unit = plain[places[0]][1]
            return Column(name, places[0], unit, _factor(source, name, names[places[0]], unit))
    return None


def _factor(source: str, name: str, written: str, unit: str) -> float:
    """What makes SI units of a column."""
    units = next(_UNITS[group] for group in _UNITS if name in GROUPS[group])
    factor = {**_NONE, **units}.get(unit.lower())
    if factor is None:
        raise InputError(source, written, f"the unit {unit} is not known; {name} is in {', '.join(units) or 'no unit'}")
    return factor


def _plain(name: str) -> tuple[str, str]:
    """A name in small letters with underscores, and its unit."""
    match = _BRACKETED.fullmatch(name)
    text, unit = (match[1], match[2]) if match else (name, "")
    text = re.sub(r"[\s.\-]+", "_", text.strip().lower())
    match = None if unit else _SUFFIXED.fullmatch(text)
    return (match[1], match[2]) if match else (text, unit)


def _refuse_partial(source: str, found: Mapping[str, Column]) -> None:
    """A group of columns is there as a whole or not at all."""
    for group, names in GROUPS.items():
        missing = [name for name in names if name not in found]
        needed = group in {"time", "position"} or (len(missing) < len(names) and group != "angles")
        if missing and needed:
            reason = f"this column is missing; needed: {','.join(REQUIRED)}; the others in groups: {','.join(names)}"
            raise InputError(source, missing[0], reason)


def by_count(values: Floats) -> tuple[str, ...]:
    """Names of the columns of a file without a header, by how many there are; () where they could be anything.

    The field's order is time, position, attitude, velocity, rates, thrusts; what has no attitude is taken for position, velocity,
    acceleration and yaw.

    Args:
        values: shape (rows, columns).
    """
    count, whole = values.shape[1], tuple[str, ...]()
    for group in WHOLE:
        whole += GROUPS[group]
        if count == len(whole) and (count < 5 or _has_attitude(values)):
            return whole
    flat, acceleration = (*REQUIRED, *GROUPS["velocity"]), GROUPS["acceleration"]
    others = (flat, (*flat, "yaw"), (*flat, *acceleration), (*flat, *acceleration, "yaw"), (*REQUIRED, "yaw"))
    return next((names for names in others if len(names) == count), ())


def _has_attitude(values: Floats) -> bool:
    """Whether the columns behind the position are unit quaternions."""
    return bool((np.abs(np.linalg.norm(values[:, 4:8], axis=1) - 1) < 0.01).all())

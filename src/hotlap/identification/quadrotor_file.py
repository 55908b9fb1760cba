"""The file of a quadrotor that was identified: its base, the keys that differ, each with its interval, and what was not told."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from hotlap.core.printable import printable
from hotlap.files.error_messages import check
from hotlap.files.kinds import Kind
from hotlap.files.recognition import TYPES
from hotlap.files.toml_writer import write_pair
from hotlap.identification.estimates import Estimate, by_key
from hotlap.identification.identify import Identification
from hotlap.identification.model import scaled, thrust_range
from hotlap.identification.unknowns import AXES
from hotlap.identification.wording import number
from hotlap.race.quadrotor import MOST_DELAY, Quadrotor

WIDTH = 140
LOOP, THRUST = "rate_loop.p", "full thrust per mass"
DRAGS = ("rotor_drag", "drag", "body_drag")


def quadrotor_of(found: Identification, label: str) -> Quadrotor:
    """The base with what the logs tell.

    Args:
        found: what they tell.
        label: of the file, for messages.

    Raises:
        InputError: no vehicle has these numbers; with the label, key and reason.
    """
    table = found.base.model_dump(mode="python", exclude_unset=True)
    for key, value in changes(found).items():
        table[key] = {**table.get(key, {}), **value} if isinstance(value, Mapping) else value
    return check(TYPES[Kind.QUADROTOR], table, label)  # pyright: ignore[reportReturnType]  the type that was asked for


def changes(found: Identification) -> dict[str, Any]:
    """Keys of the file with their values, rounded, in the order of the estimates: the vehicle that was fitted, zeros included.

    What is not told keeps the base's value.
    """
    base, changed = found.base, dict[str, Any]()
    for key, ones in by_key(found.estimates).items():
        told = [one for one in ones if one.told]
        if not told or key in DRAGS or (key.startswith("rate_loop.") and key != LOOP):
            continue
        if key == LOOP and base.rate_loop is not None:
            factors = [one.value / one.former if one.told else 1.0 for one in ones]
            others = {one.key.removeprefix("rate_loop."): one.value for one in found.estimates if one.told}
            loop = scaled(base.rate_loop, factors, others)
            changed["rate_loop"] = {name: _rounded(getattr(loop, name)) for name in ("p", "i", "d")}
        elif key == "rotor_thrust":
            changed[key] = _rounded(thrust_range(base, ones[0].value))
        elif key == "delay":
            changed[key] = _rounded(min(max(ones[0].value, 0.0), MOST_DELAY))
        elif len(ones) == 1:
            changed[key] = _rounded(max(ones[0].value, 0.0))
        else:
            changed[key] = _rounded(tuple(one.value if one.told else one.former for one in ones))
    if base.inflow and any(one.name == THRUST and one.told for one in found.estimates):
        changed["inflow"] = 0.0
    return changed | _drags(found)


def _drags(found: Identification) -> dict[str, Any]:
    """Keys of drag: along an axis of which the log tells something as it was fitted, where a form that was not has none."""
    base, ones = found.base, {one.name: one for one in found.estimates if one.key in DRAGS}
    linear, body, changed = list(base.drag), list(base.body_drag), dict[str, Any]()
    for k, axis in enumerate(AXES):
        own = [ones[name] for name in (f"drag {axis}", f"body drag {axis}", *(["rotor drag"] if k < 2 else [])) if name in ones]
        if any(one.told for one in own):
            values = {one.key: max(one.value, 0.0) for one in own}
            linear[k], body[k] = values.get("drag", 0.0), values.get("body_drag", 0.0)
            changed |= {"rotor_drag": _rounded(values["rotor_drag"])} if "rotor_drag" in values else {}
    for key, values in (("drag", linear), ("body_drag", body)):
        if values != list(getattr(base, key)):
            changed[key] = _rounded(values)
    return changed


def text_of(found: Identification, base: str) -> str:
    """The file.

    Args:
        found: what the logs tell.
        base: name or path of the base, as seen from the file.
    """
    lines = [f"# {line}" for remark in _head(found) for line in textwrap.wrap(printable(remark), WIDTH - 2, subsequent_indent="  ")]
    lines.append(write_pair("base", base))
    by = by_key(found.estimates)
    tables = []
    for key, value in changes(found).items():
        if isinstance(value, Mapping):
            tables += ["", f"[{key}]  # p: {_intervals(by[LOOP])}", *(write_pair(name, one) for name, one in value.items())]
        else:
            remark = _intervals(by[key]) if key in by else "as it was fitted"
            lines.append(f"{write_pair(key, value)}  # {remark}")
    lines.append(write_pair("provenance", f"identified by hotlap from {printable(', '.join(found.logs))}"))
    return "\n".join([*lines, *tables]) + "\n"


def _head(found: Identification) -> Iterator[str]:
    """What the file is made of, and what is not in it."""
    known, written = found.thrust_map, changes(found)
    yield f"Identified by hotlap from {', '.join(found.logs)}: {found.seconds:.0f} s of flight. Intervals are of 95 %."
    yield f"Taken to be right: the {found.known} of {found.base.name}, its geometry and inertia."
    if not any(one.name == THRUST and not one.told for one in found.estimates):
        power = "" if math.isnan(known.power) else f" (V / {known.voltage:.2f} V)^{known.power:.2f}"
        shape = f"{known.full:.4g} ({1 - known.curvature:.3f} u + {known.curvature:.3f} u^2)" if known.curvature else f"{known.full:.4g} u"
        yield f"Thrust per mass [m/s^2] of a throttle u from 0 to 1: {shape}{power}; hovers at {known.hover:.3f}."
    for one in found.untold:
        if one.key:
            kept = "by itself" if one.key in DRAGS and one.key in written else "as the base has it"
            yield f"Not told, {kept}: {one.name}: {one.reason}{f'; would tell: {one.manoeuvre}' if one.manoeuvre else ''}."
    yield from (f"Note: {note}." for note in found.notes)


def _intervals(ones: Sequence[Estimate]) -> str:
    """Unit and intervals of one key."""
    shown = [f"{number(one.low)} to {number(one.high)}" if one.told else "not told" for one in ones]
    return f"{ones[0].unit}; {', '.join(shown)}"


def _rounded(value: Any) -> Any:
    """Numbers of six digits."""
    return float(f"{value:.6g}") if isinstance(value, float | int) else [float(f"{one:.6g}") for one in value]

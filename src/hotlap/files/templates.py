"""Templates: commented files to start from; every key with its unit, meaning and default."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hotlap.files import toml_writer
from hotlap.files.documented_keys import Key, documented_keys
from hotlap.files.kinds import Kind
from hotlap.files.recognition import TYPES
from hotlap.race.schema import Described

HEADS: Mapping[Kind, str] = {
    Kind.TRACK: "A track: gates in the order in which they are flown. x forward, y left, z up, in metres and radians.\n"
    "# A gate has the position of its centre, the heading (yaw) in which it is passed, and an opening: side, width and height, radius\n"
    "# or corners; pitch, roll, depth, frame, direction and counts are in docs/files.md. A bare [x, y, z] is passed near by, any way.",
    Kind.QUADROTOR: 'A quadrotor. Instead of writing all keys it may build on another one: base = "hummingbird".',
    Kind.RACE: "A race: who flies which track, how it is planned, controlled and judged.\n"
    "# track, vehicle, model and planning.quadrotor take a name, a path, or a table with a base and what differs from it.",
}

EXAMPLES: Mapping[Kind, Mapping[str, Any]] = {
    Kind.TRACK: {
        "start": [0.0, 0.0, 1.0],
        "gates": [
            {"position": [6.0, 2.0, 1.5], "yaw": 0.1, "side": 1.5},
            {"position": [12.0, 0.0, 2.0], "yaw": -1.1, "width": 2.0, "height": 1.2, "frame": 0.1},
            {"position": [12.0, -6.0, 1.5], "yaw": -2.4, "radius": 0.7},
            [4.0, -6.0, 1.0],
        ],
        "opening": {"side": 1.5, "frame": 0.1},
        "end": [0.0, -4.0, 1.0],
        "floor": 0.0,
        "ceiling": 6.0,
        "box": {"low": [-5.0, -10.0, 0.0], "high": [17.0, 5.0, 6.0]},
        "poles": [{"position": [9.0, 3.0], "radius": 0.05, "top": 3.0}],
        "spheres": [{"position": [9.0, -8.0, 1.5], "radius": 0.5}],
        "boxes": [{"low": [5.0, -3.0, 0.0], "high": [7.0, -2.0, 1.0]}],
    },
    Kind.QUADROTOR: {
        "mass": 0.85,
        "inertia": [1e-3, 1e-3, 1.7e-3],
        "arm": 0.15,
        "rotor_thrust": [0.0, 6.9],
        "torque_ratio": 0.05,
        "radius": 0.25,
        "rotors": [[0.106, 0.106, 1.0], [0.106, -0.106, -1.0], [-0.106, -0.106, 1.0], [-0.106, 0.106, -1.0]],
        "rotor_speed": 2500.0,
        "rate_loop.p": [0.08, 0.08, 0.2],
        "battery.sag": 0.1,
        "battery.sag_per_ampere_hour": 0.05,
        "battery.hover_current": 15.0,
    },
    Kind.RACE: {
        "track": "circle",
        "vehicle": {"base": "hummingbird", "delay": 0.045},
        "model": "hummingbird",
        "planning.quadrotor": "airsim-plan",
        "planning.thrust_share": 0.75,
        "controller.offset_free": True,
        "controller.solver": "real_time",
        "planning.v_max": 20.0,
        "planning.clearance": 0.1,
        "planning.ramp.distance": 35.0,
        "planning.ramp.thrust_to_weight": 1.5,
        "planning.ramp.rate": 4.5,
        "planning.floor": -5.0,
    },
}


def new(kind: Kind, name: str, values: Mapping[str, Any] | None = None) -> str:
    """The text of a new file that loads as it stands.

    Args:
        kind: what it describes.
        name: what it is called.
        values: of some of its keys, in place of the examples.
    """
    examples = {**EXAMPLES[kind], **(values or {})}
    head = f'# {HEADS[kind]}\n# Lines that begin with "# " show defaults or examples: remove the mark to change one.\n'
    return f"{head}name = {toml_writer.write_value(name)}\n" + "".join(_lines(TYPES[kind], examples, "", optional=False))


def _lines(description: type[Described], examples: Mapping[str, Any], path: str, *, optional: bool) -> list[str]:
    """Lines of a table: its values first, then the tables within it."""
    values, tables = [], []
    for key in documented_keys(description):
        name = path + key.name
        if name == "name":
            continue
        if key.table is not None and name not in examples:
            absent = optional or key.default is None
            header = f"\n{'# ' * absent}[{name}]  # {key.meaning}\n"
            tables += [header, *_lines(key.table, examples, f"{name}.", optional=absent)]
        else:
            values.append(_line(key, examples.get(name, key.default), optional=optional or not key.required))
    return values + tables


def _line(key: Key, value: Any, *, optional: bool) -> str:
    """A key with its value and what it means; on one line where it is a comment, so that one mark brings it in."""
    text = f"{key.name} = {toml_writer.write_value(value)}" if optional else toml_writer.write_pair(key.name, value)
    unit = f"[{key.unit}] " if key.unit else ""
    return f"{'# ' * optional}{text}  # {unit}{key.meaning}\n"

"""TOGT-Planner: its tracks and drones, YAML (github.com/FSC-Lab/TOGT-Planner)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from hotlap.files.content import Content
from hotlap.files.kinds import Kind
from hotlap.importers.imported import Findings, Format
from hotlap.importers.rotors import from_diagonal, from_lever, place_rotors
from hotlap.importers.turning import angles_of, is_level, quaternion_of, rotation_of
from hotlap.race.gate import Gate
from hotlap.race.gate_plane import plane_of

Floats = NDArray[np.float64]
SHORTEST_TUNNEL = 1e-3  # m: below it TOGT-Planner makes no tunnel


def _is_track(content: Content) -> bool:
    return "initState" in content or "orders" in content


def _read_track(content: Content, name: str | None) -> Findings:
    found = Findings({"name": name})
    _begin(found, content["initState"])
    clearances: dict[str, float] = {}
    gates = [gate for order in _orders(content) for gate in _gate(content[order], clearances, found)]
    found.table["gates"] = gates
    _finish(found, content)
    _tell(found, gates, clearances)
    left = [key for key in content.table() if key not in {"initState", "endState", "orders", *_orders(content)}]
    found.lost += [f"{key}: is not among the orders" for key in left]
    return found


def _orders(content: Content) -> list[str]:
    """The gates in the order flown; one alone may stand without brackets."""
    orders = content["orders"]
    return [orders.text()] if isinstance(orders.value, str) else [entry.text() for entry in orders.entries()]


def _begin(found: Findings, state: Content) -> None:
    """Where a flight starts, and how."""
    found.table["start"] = state["pos"].vector()
    attitude = _attitude(state)
    if not is_level(attitude):
        found.table["attitude"] = attitude
    velocity = state["vel"].vector() if "vel" in state else [0.0] * 3
    if any(velocity):
        found.table["start_velocity"] = velocity
    found.lost += [
        f"initState.{key}: a start has no {word}" for key, word in {"acc": "acceleration", "jer": "jerk"}.items() if _moves(state, key)
    ]
    if "rot" in state and not np.allclose(np.abs(state["rot"].vector(4)), np.abs(attitude), atol=1e-3):
        found.lost.append("initState.rot: TOGT-Planner takes the attitude from euler")


def _attitude(state: Content) -> list[float]:
    """(w, x, y, z) of a state, from angles in degrees."""
    return quaternion_of(*map(math.radians, state["euler"].vector())) if "euler" in state else [1.0, 0.0, 0.0, 0.0]


def _moves(state: Content, key: str) -> bool:
    return key in state and any(state[key].vector())


def _finish(found: Findings, content: Content) -> None:
    """Where the plan ends, and how."""
    if "endState" not in content:
        return
    state = content["endState"]
    found.table["end"] = state["pos"].vector()
    if _moves(state, "vel"):
        found.lost.append("endState.vel: an end is at rest or at any speed; here at any speed")
    else:
        found.table["end_at_rest"] = True
    if not is_level(_attitude(state)):
        found.lost.append("endState.euler: an end has no attitude of its own")


def _tell(found: Findings, gates: list[dict], clearances: Mapping[str, float]) -> None:
    """Say which conventions were taken."""
    if any("yaw" in gate for gate in gates):
        found.taken += [
            "angles in degrees; a gate's normal is -z of its rotation and its upper side +x, as TOGT-Planner's prisms stand",
            "a gate is given by its centre; its length is our depth, half of it on each side",
        ]
    if any("yaw" in gate and "depth" not in gate for gate in gates):
        found.taken.append(
            'a gate without length counts in both directions there, and along its normal here; direction = "either" allows both'
        )
    words = "its gates have no margins" if not clearances else f"its margins leave {_range(clearances)} to the rim"
    setting = f"planning.clearance = {max(clearances.values(), default=0.0):.4g} in the race and radius = 0.0 in the quadrotor"
    found.taken.append(f"openings are written whole; TOGT-Planner's drone is a point and {words}: {setting} plan like it")


def _range(clearances: Mapping[str, float]) -> str:
    least, largest = min(clearances.values()), max(clearances.values())
    return f"{largest:.4g} m" if largest - least < 1e-6 else f"{least:.4g} to {largest:.4g} m"


def _gate(entry: Content, clearances: dict[str, float], found: Findings) -> list[dict]:
    """A gate; none where nothing has to be passed."""
    kind = entry["type"].text()
    if kind == "FreeCorridor":
        found.lost.append(f"{entry.key}: a FreeCorridor is no gate")
        return []
    if "stationary" in entry and entry["stationary"].value is False:
        found.lost.append(f"{entry.key}.stationary: the gate moves there")
    if kind == "SingleBall":
        radius = entry["radius"].positive() - _margin(entry) / 2
        if radius <= 0:
            raise entry["margin"].fault("leaves nothing of the ball")
        return [{"position": entry["position"].vector(), "radius": radius}]
    if kind not in SHAPES:
        raise entry["type"].fault(f"'{kind}' is none of {', '.join(['SingleBall', 'FreeCorridor', *SHAPES])}")
    return [_prism(entry, kind, clearances)]


def _prism(entry: Content, kind: str, clearances: dict[str, float]) -> dict:
    """A gate that is a polygon."""
    rotation = rotation_of(*map(math.radians, entry["rpy"].vector()))
    axes = np.stack([-rotation[:, 2], rotation[:, 1], rotation[:, 0]], axis=1)  # normal, left, up
    gate = {"position": entry["position"].vector(), **angles_of(axes)}
    whole, narrow = SHAPES[kind](entry, margin=False), SHAPES[kind](entry, margin=True)
    if kind == "RectanglePrisma" and math.isclose(abs(gate.get("roll", 0.0)), math.pi):
        del gate["roll"]  # it looks the same upside down
    clearance = _clearance({**gate, **whole}, {**gate, **narrow}, entry)
    if clearance > 1e-9:
        clearances[entry.key] = clearance
    length = entry["length"].number() if "length" in entry else 0.0
    return {**gate, **whole, **({"depth": length} if length > SHORTEST_TUNNEL else {})}


def _clearance(gate: dict, narrowed: dict, entry: Content) -> float:
    """How far the rim moves in by the margins, where it moves most [m]."""
    planes = [plane_of(_checked(table, entry), 1.0) for table in (gate, narrowed)]
    whole, narrow = (plane.edges[1] for plane in planes if plane is not None)
    return float((whole - narrow).max())


def _checked(table: dict, entry: Content) -> Gate:
    """A gate, for its geometry."""
    try:
        return Gate.model_validate(table)
    except ValueError:
        raise entry.fault("its size, less its margin, is no opening") from None


def _margin(entry: Content, key: str = "margin") -> float:
    return entry[key].number() if key in entry else 0.0


def _rectangle(entry: Content, *, margin: bool) -> dict:
    width = entry["width"].positive() - margin * _margin(entry, "marginW")
    height = entry["height"].positive() - margin * _margin(entry, "marginH")
    return {"side": width} if width == height else {"width": width, "height": height}


def _triangle(entry: Content, *, margin: bool) -> dict:
    """Two corners below and one above, around the middle of its height."""
    half_width, half_height = ((entry[key].positive() - margin * _margin(entry)) / 2 for key in ("width", "height"))
    return {"corners": [[half_width, -half_height], [0.0, half_height], [-half_width, -half_height]]}


def _regular(corners: int, radius: float, first: float) -> dict:
    """Corners [left, up] of a regular polygon, from an angle [rad] off the upper side on."""
    angles = first + 2 * math.pi / corners * np.arange(corners)
    points = radius * np.stack([np.sin(angles), np.cos(angles)], axis=1)
    return {"corners": np.where(np.abs(points) < 1e-12, 0.0, points).tolist()}


def _pentagon(entry: Content, *, margin: bool) -> dict:
    return _regular(5, entry["radius"].positive() - margin * _margin(entry), 0.0)


def _hexagon(entry: Content, *, margin: bool) -> dict:
    """Two corners lie left and right."""
    return _regular(6, entry["side"].positive() - margin * _margin(entry), math.pi / 6)


SHAPES: Mapping[str, Callable[..., dict]] = {
    "RectanglePrisma": _rectangle,
    "TrianglePrisma": _triangle,
    "PentagonPrisma": _pentagon,
    "HexagonPrisma": _hexagon,
}


def _is_drone(content: Content) -> bool:
    return any(key in content for key in ("armLength", "torCoeff", "T_bm"))


def _read_drone(content: Content, name: str | None) -> Findings:
    found = Findings({"name": name, "mass": content["mass"].positive(), "inertia": content["inertia"].diagonal()})
    _arms(found, content)
    least = content["thrust_min"].number() if "thrust_min" in content else 0.0
    found.table["rotor_thrust"] = [least, content["thrust_max"].positive()]
    if "omega_max" in content:
        found.table["rate_limit"] = content["omega_max"].vector()
    if "gravity" in content:
        found.table["gravity"] = content["gravity"].positive()
    return found


def _arms(found: Findings, content: Content) -> None:
    """Arm and torque ratio, in the order in which TOGT-Planner looks for them."""
    if content.has("armLength", "torCoeff"):
        length = content["armLength"].positive()
        found.table["torque_ratio"] = content["torCoeff"].positive()
        if "beta" not in content:
            from_lever(found, length, "armLength, without beta,")
        elif abs(content["beta"].number() - 45) < 1e-6:
            from_diagonal(found, length, "armLength, with beta,")
        else:
            beta = math.radians(content["beta"].number())
            x, y = length * math.cos(beta), length * math.sin(beta)
            place_rotors(found, np.array([[x, y], [x, -y], [-x, -y], [-x, y]]), content["beta"])
    elif "T_bm" in content:
        _, roll, pitch, yaw = content["T_bm"].matrix(4, 4)
        found.table["torque_ratio"] = abs(yaw[0])
        place_rotors(found, np.array([np.negative(pitch), roll]).T, content["T_bm"])
    else:
        found.table["torque_ratio"] = content["torCoeff"].positive()
        keys = ("tbm_fr", "tbm_bl", "tbm_br", "tbm_fl")
        place_rotors(found, np.array([content[key].vector()[:2] for key in keys]), content)


FORMATS = (
    Format("a track of TOGT-Planner (YAML)", Kind.TRACK, _is_track, _read_track),
    Format("a drone of TOGT-Planner (YAML)", Kind.QUADROTOR, _is_drone, _read_drone),
)

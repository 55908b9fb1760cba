"""Fast-fly: its gates and quadrotors, YAML (github.com/ZhouZiyuBIT/Fast-fly)."""

from __future__ import annotations

from hotlap.files.content import Content
from hotlap.files.kinds import Kind
from hotlap.importers.imported import Findings, Format
from hotlap.importers.rotors import from_diagonal


def _is_track(content: Content) -> bool:
    return content.has("pos", "rot") and isinstance(content["pos"].value, list)


def _read_track(content: Content, name: str | None) -> Findings:
    gates = [[x, -y, -z] for x, y, z in (gate.vector() for gate in content["pos"].entries())]
    found = Findings({"name": name, "start": gates[-1], "gates": gates})
    found.taken += [
        "positions are north, east, down: x stays, y and z change their signs",
        "there is no start: it starts at rest at the last gate and flies one lap; laps = 3 flies three",
        "a gate is a point; how close counts is judge.distance in the race, for the plan planning.tolerance",
    ]
    if any(angle.number() for angle in content["rot"].entries()):
        found.lost.append("rot: the line along which a gate is drawn, in degrees; it has no passing direction")
    return found


def _is_quadrotor(content: Content) -> bool:
    return "omega_xy_max" in content


def _read_quadrotor(content: Content, name: str | None) -> Findings:
    found = Findings({"name": name, "mass": content["mass"].positive(), "inertia": content["inertia"].diagonal()})
    from_diagonal(found, content["arm_length"].positive(), "arm_length")
    least = content["thrust_min"].number() if "thrust_min" in content else 0.0
    found.table |= {"rotor_thrust": [least, content["thrust_max"].positive()], "torque_ratio": content["torque_coeff"].positive()}
    if "drag_coeff" in content:
        found.table["drag"] = content["drag_coeff"].vector()
        found.taken.append("drag_coeff is per mass, as our drag")
    rate = content["omega_xy_max"].positive()
    found.table["rate_limit"] = [rate, rate, content["omega_z_max"].number()]
    found.lost += [f"{key}: a limit of speed" for key in ("v_xy_max", "v_z_max") if key in content]
    return found


FORMATS = (
    Format("gates of Fast-fly (YAML)", Kind.TRACK, _is_track, _read_track),
    Format("a quadrotor of Fast-fly (YAML)", Kind.QUADROTOR, _is_quadrotor, _read_quadrotor),
)

"""rpg_time_optimal: its tracks and quadrotors, YAML (github.com/uzh-rpg/rpg_time_optimal)."""

from __future__ import annotations

from hotlap.files.content import Content
from hotlap.files.kinds import Kind
from hotlap.importers.imported import Findings, Format
from hotlap.importers.rotors import ROTORS, from_lever
from hotlap.importers.turning import is_level
from hotlap.race.quadrotor import GRAVITY


def _is_track(content: Content) -> bool:
    return "gates" in content and isinstance(content["gates"].value, list)


def _read_track(content: Content, name: str | None) -> Findings:
    gates = [gate.vector() for gate in content["gates"].entries()]
    found = Findings({"name": name})
    _begin(found, content.maybe("initial") or content, gates)
    found.table["gates"] = gates
    if "ring" in content and content["ring"].value is True:
        found.table["closed"] = True
        found.lost.append("ring: the lap ends where it began here, not at the same speed and attitude")
    if "end" in content:
        _finish(found, content["end"])
    found.taken.append("a gate is a point; how close counts is judge.distance in the race, for the plan planning.tolerance")
    return found


def _begin(found: Findings, initial: Content, gates: list[list[float]]) -> None:
    """Where a flight starts, and how."""
    if "position" in initial:
        found.table["start"] = initial["position"].vector()
    else:
        found.table["start"] = gates[-1]
        found.taken.append("there is no position to start from: it starts at the last gate")
    if "attitude" in initial and not is_level(initial["attitude"].vector(4)):
        found.table["attitude"] = initial["attitude"].vector(4)
    if "velocity" in initial and any(initial["velocity"].vector()):
        found.table["start_velocity"] = initial["velocity"].vector()
    if "omega" in initial and any(initial["omega"].vector()):
        found.lost.append(f"{initial['omega'].key}: a start does not turn")


def _finish(found: Findings, end: Content) -> None:
    """Where the plan ends, and how."""
    if "position" in end:
        found.table["end"] = end["position"].vector()
    if "velocity" in end:
        if any(end["velocity"].vector()):
            found.lost.append("end.velocity: an end is at rest or at any speed; here at any speed")
        else:
            found.table["end_at_rest"] = True
    found.lost += [f"end.{key}: an end has none of its own" for key in ("attitude", "omega") if key in end]


def _is_quadrotor(content: Content) -> bool:
    return any(key in content for key in ("omega_max_xy", "TWR_max"))


def _read_quadrotor(content: Content, name: str | None) -> Findings:
    found = Findings({"name": name, "mass": content["mass"].positive(), "inertia": content["inertia"].diagonal()})
    from_lever(found, content["arm_length"].positive(), "arm_length")
    _thrust(found, content)
    found.table["torque_ratio"] = content["torque_coeff"].positive()
    rate, yaw_rate = content["omega_max_xy"].positive(), content["omega_max_z"].number()
    found.table["rate_limit"] = [rate, rate, yaw_rate]
    if "drag_coeff" in content:
        found.table["drag"] = [content["drag_coeff"].number()] * 3
        found.taken.append("drag_coeff is per mass, as our drag")
    if "v_max" in content:
        found.lost.append(f"v_max: it stands for drag in the plan; set planning.v_max = {content['v_max'].positive():g} in the race")
    if "rampup_dist" in content and content["rampup_dist"].number() > 0:
        found.lost.append(f"rampup_dist: limits grow at the start; set {_ramp(content)} in the race")
    found.lost.append("gravity: rpg_time_optimal plans with 9.801 m/s^2; set gravity to plan like it")
    return found


def _thrust(found: Findings, content: Content) -> None:
    """Each limit in newtons, or as a ratio to the weight, which precedes."""
    ratios = ("TWR_min" in content, "TWR_max" in content)
    values = [content["TWR_min" if ratios[0] else "thrust_min"].number() if ratios[0] or "thrust_min" in content else 0.0]
    values += [content["TWR_max" if ratios[1] else "thrust_max"].positive()]
    weight = found.table["mass"] * GRAVITY / ROTORS
    found.table["rotor_thrust"] = [value * weight if ratio else value for value, ratio in zip(values, ratios, strict=True)]
    if any(ratios):
        found.taken.append(f"TWR is the ratio of thrust to weight: a rotor's share is a quarter, with g = {GRAVITY} m/s^2")


def _ramp(content: Content) -> str:
    """The ramp as it is written in a race."""
    keys = {"distance": "rampup_dist", "thrust_to_weight": "TWR_ramp_start", "rate": "omega_ramp_start"}
    return "planning.ramp = { " + ", ".join(f"{ours} = {content[theirs].number():g}" for ours, theirs in keys.items()) + " }"


FORMATS = (
    Format("a track of rpg_time_optimal (YAML)", Kind.TRACK, _is_track, _read_track),
    Format("a quadrotor of rpg_time_optimal (YAML)", Kind.QUADROTOR, _is_quadrotor, _read_quadrotor),
)

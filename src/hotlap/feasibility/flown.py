"""What a race's plan, or the reference that is flown in its place, asks of vehicle and controller, and how it passes the gates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hotlap.core.counts import count
from hotlap.feasibility.demands import Demands, advice, demands
from hotlap.feasibility.finding import Finding, Level, note_if, warning_if
from hotlap.feasibility.race import thrust_share
from hotlap.race.flight_performance import command_lag
from hotlap.race.gate import Gate
from hotlap.race.gate_plane import GatePlane, plane_of
from hotlap.race.race import GateRule, PlanDynamics, Race
from hotlap.reference.encounters import EncounterKind, find_encounters
from hotlap.reference.reference import Reference

SIDEWAYS = 0.5  # cosine of velocity and normal below which a gate is flown along rather than through
ALIKE = 0.02  # difference of two shares of the thrust that says nothing
SUDDEN = 1.0  # rad/s at the first moment that a drone at rest does not have
FINE = 0.002  # s between the positions at which one looks for what is touched
TIGHT = 0.05  # m: noise of the start alone is as large

Floats = NDArray[np.float64]


def describe_flown(race: Race, reference: Reference, file: str = "") -> tuple[Finding, ...]:
    """What is flown, and what it asks for.

    Args:
        race: whose vehicle flies.
        reference: planned, or read.
        file: that the reference was read from; "" for a plan.
    """
    wanted = demands(race, reference)
    about = f"{wanted.length:.0f} m at up to {wanted.top_speed:.1f} m/s"
    lap = {"lap_time_s": reference.lap_time, "length_m": wanted.length, "top_speed_m_per_s": wanted.top_speed}
    read = [Finding("reference", file, "flown in place of a plan; the settings of [planning] do not count")] if file else []
    return (
        *read,
        Finding("lap", f"{reference.lap_time:.2f} s", about, figures=lap),
        *_thrust(race, wanted, file),
        *(_beyond_weights(race, reference, wanted) if file else ()),
        _first_moment(race, wanted, file),
        *_least_room(race, reference),
        *_directions(race, reference),
        *_touched(race, reference),
    )


def _thrust(race: Race, wanted: Demands, file: str) -> list[Finding]:
    """The share of the vehicle's thrust that it takes at most, where that is not what the planner was told."""
    share = max(wanted.thrust_share, wanted.rotor_share) if np.isfinite(wanted.rotor_share) else wanted.thrust_share
    if not file and not wanted.exhausting and share < thrust_share(race) + ALIKE:
        return []
    remark = "of the vehicle's thrust at most, its own drag included"
    if wanted.exhausting and not file:
        late = "no tuner will help" if race.judge.rule is GateRule.CLOCK else "the drone will fall behind its clock"
        remark += f": {late}; lower planning.thrust_share or planning.v_max"
    return [Finding("asks for", f"{share:.0%}", remark, warning_if(wanted.exhausting and not file), {"largest_thrust_share": share})]


def _beyond_weights(race: Race, reference: Reference, wanted: Demands) -> list[Finding]:
    """What of a reference no weights can make up for."""
    level = Level.WARNING if wanted.exhausting or wanted.too_quick else Level.NOTE
    return [Finding("reference asks", "too much", clause, level) for clause in advice(race, reference)]


def _first_moment(race: Race, wanted: Demands, file: str) -> Finding:
    """Thrust and rates that it begins with, where rotors hover and nothing turns yet."""
    rate = float(np.abs(wanted.first_rates).max())
    sudden = rate > SUDDEN
    remark = "of the thrust and a body rate, at once"
    if sudden:
        remark += f"; the drone turns {command_lag(race.vehicle) * 1e3:.0f} ms later"
        remark += "" if file or race.planning.dynamics is PlanDynamics.FULL else ', planning.dynamics = "full" plans with that'
    figures = {"first_thrust_share": wanted.first_share, "first_rate_rad_per_s": rate}
    return Finding("first moment", f"{wanted.first_share:.0%}, {rate:.1f} rad/s", remark, note_if(sudden), figures)


def rooms(race: Race, reference: Reference) -> Floats:
    """By how much a reference lies inside of what counts as passing each counted gate, shape (gates,) [m]; negative: outside.

    Where openings count, that is the least of the room around the vehicle and of how deep it goes through the gate before it turns back.

    Args:
        race: its gates and its judge.
        reference: that passes them.
    """
    places = zip(race.track.counted, reference.gate_times.tolist(), reference.position_at(reference.gate_times), strict=True)
    return np.array([_room(race, reference, gate, time, place) for gate, time, place in places])


def _room(race: Race, reference: Reference, gate: Gate, time: float, place: Floats) -> float:
    """The same for one gate, passed at a time [s] and place [m]."""
    by_opening = race.judge.rule is GateRule.OPENING
    plane = plane_of(gate, race.judge.distance) if by_opening else None
    if plane is not None:
        size = race.vehicle.outer_radius if plane.solid else 0.0
        return min(-float(plane.rim_distance(plane.to_gate(place)[1:])) - size, _depth(plane, reference, time))
    counts = gate.radius if by_opening and gate.radius else race.judge.distance
    return counts - float(np.linalg.norm(place - gate.position))


def _depth(plane: GatePlane, reference: Reference, time: float) -> float:
    """How far it goes beyond a plane, either way, before it crosses it again [m]."""
    along = plane.to_gate(reference.position_at(np.arange(time, reference.times[-1], FINE)))[:, 0]
    way = np.sign(along[1]) if len(along) > 1 else 0.0
    back = np.flatnonzero(way * along[1:] < 0)
    return float(np.abs(along[: back[0] + 1]).max()) if len(back) else float("inf")


def _least_room(race: Race, reference: Reference) -> list[Finding]:
    """The gate that it passes closest to the edge of what counts."""
    left = rooms(race, reference)
    worst = int(left.argmin())
    name = [point.name for point in race.track.route if point.counts][worst]
    figures = {"room_m": float(left[worst])}
    if left[worst] <= 0:
        remark = f"outside of what counts at {name}: a flight without any error misses it"
        return [Finding("room at the gates", f"{-left[worst]:.2f} m", remark, Level.WARNING, figures)]
    remark = f"for the controller's errors, at {name}; more at the others" if len(left) > 1 else f"for the controller's errors, at {name}"
    return [Finding("room at the gates", f"{left[worst]:.2f} m", remark, note_if(left[worst] < TIGHT), figures)]


def _directions(race: Race, reference: Reference) -> list[Finding]:
    """Gates with an orientation that are passed backwards or along their plane, under a rule that counts it."""
    names = [point.name for point in race.track.route if point.counts]
    velocity = np.stack([np.interp(reference.gate_times, reference.times, column) for column in reference.velocity.T], axis=1)
    backwards, sideways = [], []
    for name, gate, moving in zip(names, race.track.counted, velocity, strict=True):
        plane = plane_of(gate, race.judge.distance)
        if plane is None:
            continue
        cosine = float(moving @ plane.normal / max(np.linalg.norm(moving), 1e-9))
        if abs(cosine) < SIDEWAYS:
            sideways.append(name)
        elif cosine < 0 and plane.one_way:
            backwards.append(name)
    ignored = race.judge.rule is not GateRule.OPENING
    counted = f'; the rule "{race.judge.rule}" counts it, "opening" would not' if ignored else ""
    return [
        Finding(f"passed {how}", count(len(some), "gate"), f"{', '.join(some)}{counted}", Level.NOTE, {"gates": len(some)})
        for how, some in (("backwards", backwards), ("sideways", sideways))
        if some
    ]


def _touched(race: Race, reference: Reference) -> list[Finding]:
    """What the vehicle would touch on the way, if it made no error."""
    times = np.arange(0.0, reference.duration, FINE)
    met = find_encounters(times, reference.position_at(times), race.track, race.vehicle.outer_radius, race.judge.distance)
    return [
        Finding(
            label="touches",
            value=one.name,
            remark=f"after {one.time:.2f} s, by {-one.distance:.2f} m: a flight without any error crashes",
            level=Level.WARNING,
            figures={"time_s": one.time, "overlap_m": -one.distance},
        )
        for one in met
        if one.kind is not EncounterKind.FLOOR  # a reference may begin a little below it
    ]

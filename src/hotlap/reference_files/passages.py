"""Passages: when a flight passes each gate of a track, found from its positions alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.race.gate_plane import GatePlane, plane_of
from hotlap.race.race import GateRule, Race

Floats = NDArray[np.float64]

GOING_ON = 0.02  # s that a flight goes on behind its last row: that row may lie a hair before the last gate's plane
SLACK = 0.01  # m that a reference may be beside an opening: as much as its rows and roundings may tell
STEEP = math.cos(math.radians(75))  # cosine of the angle from a gate's normal below which it is passed sideways


class MissedGateError(ValueError):
    """A gate that is not passed in its turn.

    Args:
        gate: its name: "gate 2".
        reason: in one clause.
    """

    def __init__(self, gate: str, reason: str) -> None:
        self.gate, self.reason = gate, reason
        super().__init__(f"{gate}: {reason}")


@dataclass(frozen=True)
class Target:
    """What has to be passed: a ball, or a plane within an opening.

    Attributes:
        name: for messages: "gate 2".
        centre: shape (3,) [m] (world).
        reach: [m] radius of the ball, where there is no plane.
        limit: what sets it: "judge.distance".
        plane: of an oriented gate; None for a ball.
        keep: [m] to be kept from the rim of a plane's opening.
        slack: [m] that a passage may be beside it.
    """

    name: str
    centre: Floats
    reach: float
    limit: str = "judge.distance"
    plane: GatePlane | None = None
    keep: float = 0.0
    slack: float = 0.0


@dataclass(frozen=True)
class _Passages:
    """Where a target may be passed: times [s] ascending, costs [m^2], and why there is none where there is none."""

    times: Floats
    costs: Floats
    reason: str = ""


def targets_of(race: Race) -> tuple[Target, ...]:
    """What a flight of a race has to pass, in order: as its judge counts."""
    by_openings = race.judge.rule is GateRule.OPENING
    found = []
    for point in race.track.route:
        if not point.counts:
            continue
        gate, reach, limit = point.gate, race.judge.distance, "judge.distance"
        plane = plane_of(gate, reach) if by_openings else None
        if by_openings and plane is None and gate.radius:
            reach, limit = gate.radius, "the gate's radius"
        keep = race.vehicle.outer_radius if plane is not None and plane.solid else 0.0
        found.append(Target(point.name, np.array(gate.position), reach, limit, plane, keep, SLACK if by_openings else 0.0))
    return tuple(found)


def find_passages(times: Floats, position: Floats, velocity: Floats, targets: Sequence[Target]) -> Floats:
    """Times at which the targets are passed, one after the other, shape (targets,) [s].

    A flight may come near a gate several times, and a track may have the same gate several times. Of all ascending choices of
    passages (local closest approaches, or crossings of a plane within its opening and in its direction), that with the least sum of
    squared distances is taken (dynamic programming): going from gate to gate and always taking the next passage would take a fly-by
    for it.

    Args:
        times: shape (rows,) [s].
        position: shape (rows, 3) [m] (world).
        velocity: shape (rows, 3) [m/s] (world).
        targets: in the order in which they have to be passed.

    Raises:
        MissedGateError: for the first target that is not passed, or not in its turn.
    """
    chosen: list[tuple[_Passages, Floats, np.ndarray]] = []  # of each target: passages, least costs so far, choice for the one before
    for target in targets:
        found = _passages(times, position, velocity, target)
        if not len(found.times):
            raise MissedGateError(target.name, found.reason)
        costs, before = found.costs, np.zeros(len(found.times), dtype=np.intp)
        if chosen:
            before, earlier = _best_before(chosen[-1][0].times, chosen[-1][1], found.times)
            costs = costs + earlier
        if not np.isfinite(costs).any():
            raise MissedGateError(target.name, f"is not passed after {targets[len(chosen) - 1].name}, only before it")
        chosen.append((found, costs, before))
    passages, choice = np.empty(len(targets)), int(np.argmin(chosen[-1][1]))
    for k in reversed(range(len(targets))):
        found, _, before = chosen[k]
        passages[k], choice = found.times[choice], int(before[choice])
    return passages


def _passages(times: Floats, position: Floats, velocity: Floats, target: Target) -> _Passages:
    """Where a target may be passed."""
    if target.plane is None:
        return _approaches(times, position, velocity, target)
    return _crossings(times, position, velocity, target, target.plane)


def _approaches(times: Floats, position: Floats, velocity: Floats, target: Target) -> _Passages:
    """Local closest approaches to a point that are close enough."""
    offsets = position - target.centre
    distances = np.linalg.norm(offsets, axis=1)
    falls = np.append(np.inf, distances[:-1]) >= distances
    rises = np.append(distances[1:], np.inf) > distances
    rows = np.flatnonzero(falls & rises)
    offsets, velocity = offsets[rows], velocity[rows]
    least, most = times[np.maximum(rows - 1, 0)] - times[rows], times[np.minimum(rows + 1, len(times) - 1)] - times[rows]
    shifts = -(offsets * velocity).sum(axis=1) / np.maximum((velocity**2).sum(axis=1), 1e-12)  # foot of the perpendicular
    shifts = np.clip(shifts, least, most)
    misses = np.linalg.norm(offsets + shifts[:, None] * velocity, axis=1)
    close = misses <= target.reach + target.slack
    reason = f"is passed at {misses.min():.2f} m; {target.limit} = {target.reach:g} m is the most that counts"
    return _Passages((times[rows] + shifts)[close], misses[close] ** 2, reason)


def _crossings(times: Floats, position: Floats, velocity: Floats, target: Target, plane: GatePlane) -> _Passages:
    """Crossings of a plane in its direction, within its opening less what is kept from the rim."""
    points = plane.to_gate(np.vstack([position, position[-1] + GOING_ON * velocity[-1]]))
    moments, depth = np.append(times, times[-1] + GOING_ON), points[:, 0]
    forward, backward = (depth[:-1] < 0) & (depth[1:] >= 0), (depth[:-1] > 0) & (depth[1:] <= 0)
    rows = np.flatnonzero(forward | backward)
    shares = depth[rows] / (depth[rows] - depth[rows + 1])
    across = points[rows, 1:] + shares[:, None] * (points[rows + 1, 1:] - points[rows, 1:])
    rim = np.maximum(plane.rim_distance(across), _worst_inside(plane, points, rows)) + target.keep
    right = np.full(len(rows), fill_value=True) if not plane.one_way else forward[rows]
    inside = rim <= target.slack
    passed = right & inside
    found = np.minimum(moments[rows] + shares * (moments[rows + 1] - moments[rows]), times[-1])
    costs = ((across - plane.middle[0]) ** 2).sum(axis=1)
    reason = "" if passed.any() else _outside(target, plane, rim, right) or _elsewhere(plane, position, velocity)
    return _Passages(found[passed], costs[passed], reason)


def _worst_inside(plane: GatePlane, points: Floats, rows: NDArray[np.intp]) -> Floats:
    """Largest rim distance on the way through a tunnel, of each crossing of its middle [m]; -inf where it has no depth.

    Args:
        plane: of the gate.
        points: shape (rows, 3) [m] (gate).
        rows: the last ones before each crossing.
    """
    within = np.abs(points[:, 0]) <= plane.depth / 2
    rims, outside = plane.rim_distance(points[:, 1:]), np.flatnonzero(~within)
    worst = np.full(len(rows), -np.inf)
    for k, row in enumerate(rows):
        behind = np.searchsorted(outside, row + 1)  # the flight is within from the last row outside before the crossing
        last = outside[behind] if behind < len(outside) else len(points)
        before = np.searchsorted(outside, row, side="right") - 1
        first = outside[before] + 1 if before >= 0 else 0
        worst[k] = rims[first:last].max(initial=-np.inf)
    return worst


def _outside(target: Target, plane: GatePlane, rim: Floats, right: NDArray[np.bool_]) -> str:
    """Why crossings near the opening do not count, in one clause that says what to change; "" where there are none."""
    if (rim[~right] <= target.slack).any() and not (rim[right] < plane.room).any():
        return 'is passed backwards; turn its yaw by pi, or set its direction to "backward" or "either", if that is the way meant'
    near = rim[right]
    if len(near) and near.min() < 2 * plane.room:
        if plane.solid:
            return (
                f"is passed {near.min():.2f} m outside of what its opening leaves to a vehicle of {target.keep:g} m radius (vehicle.radius)"
            )
        return f"is passed {near.min() + plane.radius:.2f} m from its centre; {target.limit} = {plane.radius:g} m is the most that counts"
    return ""


def _elsewhere(plane: GatePlane, position: Floats, velocity: Floats) -> str:
    """How a flight goes by a gate whose plane it does not cross near the opening, in one clause."""
    distances = np.linalg.norm(position - plane.centre, axis=1)
    row = int(distances.argmin())
    speed = float(np.linalg.norm(velocity[row]))
    cosine = float(velocity[row] @ plane.normal) / max(speed, 1e-9)
    if distances[row] <= plane.room and abs(cosine) < STEEP:
        angle = math.degrees(math.acos(cosine))
        return f"is passed sideways, {angle:.0f} degrees off its normal, and its plane is not crossed within the opening; turn its yaw"
    return f"is not passed: the reference comes no nearer than {distances[row]:.2f} m to its centre"


def _best_before(times: Floats, costs: Floats, later: Floats) -> tuple[np.ndarray, Floats]:
    """For each later time the cheapest of the earlier choices, as index and cost; inf where there is none."""
    least = np.minimum.accumulate(costs)
    first = np.maximum.accumulate(np.where(costs <= least, np.arange(len(costs)), 0))
    last = np.searchsorted(times, later, side="left") - 1  # strictly before
    return first[np.maximum(last, 0)], np.where(last >= 0, least[np.maximum(last, 0)], np.inf)

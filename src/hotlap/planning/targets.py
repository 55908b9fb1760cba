"""Targets: where the phases of a plan end: within balls, or within the openings of gates.

A gate with a direction is two phases: to a plane in front of it, and through the opening to a plane behind it. The vehicle's direction
follows from their order: a condition on the velocity at one node would let a plan come through the wrong way, stop and turn back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hotlap.core.errors import PlanningError
from hotlap.planning.linear_rows import Floats, LinearRows
from hotlap.race.gate_plane import GatePlane, plane_of
from hotlap.race.race import Race
from hotlap.race.track import Waypoint

SHORTEST_DEPTH = 0.02  # m: a gate passed with less depth on each side is one plane
LEAST_SPEED = 0.1  # m/s along the normal, where one plane stands for a gate with a direction
NEIGHBOURS = 0.4  # share of the way to the points before and after that a gate's depth may take
SIDES = 16  # of the polygon that stands in for a circle inside of a tunnel


@dataclass(frozen=True)
class Target:
    """Where a phase ends.

    Attributes:
        waypoint: of the route, as it is called.
        index: of the waypoint in the route.
        counts: whether a flight has to pass it.
        position: shape (3,) [m] (world) the middle of where the phase may end.
        radius: [m] of a ball around it; infinite where the opening is a polygon.
        plane: the gate's plane; None for a ball.
        inset: [m] how far from the rim the plan stays.
        along: [m] from the gate's plane to that of this target, along the normal.
        inside: whether all of the phase lies within the opening, prolonged along the normal.
        speed: [m/s] least speed along the normal at the end of the phase; -inf where any will do.
    """

    waypoint: str
    index: int
    counts: bool
    position: Floats
    radius: float
    plane: GatePlane | None = None
    inset: float = 0.0
    along: float = 0.0
    inside: bool = False
    speed: float = -np.inf

    def rows(self, last: int, count: int) -> LinearRows:
        """What nodes keep to in this phase, whose last node and number of intervals are given; balls are rows of their own."""
        plane = self.plane
        if plane is None:
            return LinearRows.none()
        place = float(plane.normal @ plane.centre) + self.along
        parts = [LinearRows.of(last, plane.normal, place, place)]
        if len(plane.corners):
            parts.append(_within(plane, last, plane.edges, self.inset))
        if np.isfinite(self.speed):
            parts.append(LinearRows.of(last, np.append(np.zeros(3), plane.normal), self.speed, np.inf))
        if self.inside:
            edges = plane.edges if len(plane.corners) else _inscribed(plane.radius - self.inset, self.inset)
            parts += [_within(plane, node, edges, self.inset) for node in range(last - count + 1, last)]
        return LinearRows.joined(parts)


def targets_of(race: Race) -> tuple[Target, ...]:
    """The targets of a race's route.

    Raises:
        PlanningError: naming the gate whose opening is too small for the vehicle.
    """
    route = race.track.route
    points = np.vstack([race.track.start, race.track.waypoints])
    found: list[Target] = []
    for index, waypoint in enumerate(route):
        plane = plane_of(waypoint.gate, race.planning.tolerance)
        if plane is None:
            found.append(_ball(race, waypoint, index))
            continue
        gap = min(float(np.linalg.norm(points[k] - plane.centre)) for k in (index, index + 2) if k < len(points))
        onwards = points[min(index + 2, len(points) - 1)] - points[index]
        found += _through(race, waypoint, index, plane, gap, onwards)
    return tuple(found)


def _ball(race: Race, waypoint: Waypoint, index: int) -> Target:
    """A point within the tolerance, or a ball: one that counts is entered by the clearance, at most half way, for flights to err by."""
    radius, clearance = waypoint.gate.radius or race.planning.tolerance, race.planning.clearance
    if waypoint.counts and waypoint.gate.radius:
        radius -= 0.5 * radius if clearance is None else min(clearance, 0.5 * radius)
    return Target(waypoint.name, index, waypoint.counts, np.array(waypoint.gate.position), radius)


def _through(race: Race, waypoint: Waypoint, index: int, plane: GatePlane, gap: float, onwards: Floats) -> list[Target]:
    """The targets of one opening.

    Args:
        race: its vehicle and clearance count.
        waypoint: with the gate.
        index: of the waypoint.
        plane: of the gate.
        gap: [m] distance to the nearer of the points before and after.
        onwards: shape (3,) [m] from the point before to the point after.
    """
    size = race.vehicle.outer_radius if plane.solid else 0.0
    inset = _inset(race, waypoint, plane, size)
    if not plane.one_way and plane.depth > 0 and plane.normal @ onwards < 0:
        plane = plane.turned()
    middle, room = plane.middle
    radius = np.inf if len(plane.corners) else room - inset
    centre = plane.centre + plane.rotation[:, 1:] @ middle
    target = Target(waypoint.name, index, waypoint.counts, centre, radius, plane, inset)
    depth = plane.depth / 2 + min(race.vehicle.outer_radius, NEIGHBOURS * max(gap - plane.depth / 2, 0.0))
    if not plane.one_way and plane.depth == 0:
        return [target]
    if depth < SHORTEST_DEPTH:
        return [replace(target, speed=LEAST_SPEED if plane.one_way else -np.inf)]
    entry = replace(target, position=centre - depth * plane.normal, along=-depth)
    return [entry, replace(target, position=centre + depth * plane.normal, along=depth, inside=True)]


def _inset(race: Race, waypoint: Waypoint, plane: GatePlane, size: float) -> float:
    """[m] how far from the rim the centre of a vehicle of a given radius [m] stays."""
    clearance, room = race.planning.clearance, plane.room
    if not plane.solid:
        return 0.0
    if room <= size + (clearance or 0.0):
        needs = f"its radius of {size:.3g} m" + (f" and a clearance of {clearance:.3g} m" if clearance else "")
        reason = f"the opening has room for a circle of {room:.3g} m, and the vehicle needs more than {needs}"
        raise PlanningError(race.track.name, waypoint.name, reason)
    return size + (0.5 * (room - size) if clearance is None else clearance)


def _within(plane: GatePlane, node: int, edges: tuple[Floats, Floats], inset: float) -> LinearRows:
    """A node within the edges of a polygon, less an inset [m]."""
    outward, offsets = edges
    world = outward @ plane.rotation[:, 1:].T
    return LinearRows.of(node, world, -np.inf, offsets - inset + world @ plane.centre)


def _inscribed(radius: float, inset: float) -> tuple[Floats, Floats]:
    """Edges of a regular polygon that, less the inset, lies within a circle of a radius [m]."""
    angles = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1), np.full(SIDES, radius * np.cos(np.pi / SIDES) + inset)

"""Surroundings: what a plan keeps clear of, where a path comes too near, and the rows that keep it away.

A solid is convex as seen from a short piece of the path: both ends of an interval stay on the outer side of a plane that touches it where
the interval comes nearest. The chord between them cannot jump over it then, however long the interval; what the curve bulges beyond the
chord is measured, and added the next time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import PlanningError
from hotlap.planning.guess import hermite
from hotlap.planning.linear_rows import LinearRows
from hotlap.planning.problem import Floats, Problem, Trajectory
from hotlap.planning.targets import Target
from hotlap.race.gate_plane import GatePlane
from hotlap.race.solids import Solid, floor_at, gate_planes, plug, same_place, solids_of, walls_of
from hotlap.reference.encounters import find_crossings

STEP, SPACING = 0.002, 0.01  # s or m, whichever is longer, between the places of an interval that are looked at
FEWEST, MOST = 12, 120  # of these places
REACH = 0.3  # m beyond the margin within which a solid is looked at, and half of an interval's length
SLACK = 0.02  # m that a path may come nearer than it should
GIVEN = 0.3  # share of a clearance that nobody asked for by which a path may come nearer
SHRUNK = 0.4  # of such a clearance, where there is no way with all of it
EXTRA = 0.005  # m added to what a path came too near
SLOPE = 0.3  # by which a margin that had to be made smaller grows with the distance from there
PLUGGED = 0.05  # m kept from an opening that must not be crossed
SPREAD, BALL_STRIDE = 25, 4  # places across an opening that are looked at; of these every so many across a ball
DEEP = 0.3  # share of the margin: a path that comes nearer is led around anew


@dataclass(frozen=True)
class Kept:
    """One solid to keep clear of.

    Attributes:
        solid: what stands there.
        margin: [m] to be kept by the vehicle's centre.
        least: [m] that must be kept.
        anchors: places (3,) (world) of start and targets that are nearer than the margin, each with its distance [m].
        tolerance: [m] by which a path may be nearer.
    """

    solid: Solid
    margin: float
    least: float
    anchors: tuple[tuple[Floats, float], ...]
    tolerance: float

    @classmethod
    def of(cls, problem: Problem, solid: Solid, margin: float, least: float) -> Kept:
        """A solid on a problem's course."""
        anchors = []
        places = [(problem.start, 0.0, None), *((target.position, least, target.plane) for target in problem.targets)]
        for place, smallest, own in places:
            distance = max(float(solid.measure(place[None])[0][0]), smallest)
            if same_place(own, solid.plane) and not solid.opening:
                distance = smallest
            if distance < margin:
                anchors.append((place, distance))
        given = 0.0 if problem.clearance_given else GIVEN * (margin - least)
        return cls(solid, margin, least, tuple(anchors), max(SLACK, given))

    def margins(self, points: Floats) -> Floats:
        """[m] to be kept at points (n, 3): less near to start and targets that are nearer themselves."""
        margins = np.full(len(points), self.margin)
        for place, distance in self.anchors:
            margins = np.minimum(margins, distance + SLOPE * np.linalg.norm(points - place, axis=1))
        return margins

    @property
    def slack(self) -> float:
        """[m] by which straight ways around it may be nearer."""
        return min(2 * SLACK, 0.4 * self.margin)


@dataclass(frozen=True)
class Path:
    """A trajectory at many places of each interval.

    Attributes:
        times: shape (rows,) [s].
        points: shape (rows, 3) [m] (world).
        intervals: shape (rows,) the interval of each.
        owners: shape (N,) the phase of each interval.
        nodes: shape (N + 1, 3) [m] (world).
        samples: places of each interval.
    """

    times: Floats
    points: Floats
    intervals: np.ndarray
    owners: np.ndarray
    nodes: Floats
    samples: int

    @classmethod
    def of(cls, trajectory: Trajectory) -> Path:
        """Cubic curves through the nodes."""
        longest = np.linalg.norm(np.diff(trajectory.states[:, :3], axis=0), axis=1).max()
        samples = int(np.clip(np.ceil(min(longest / SPACING, trajectory.steps.max() / STEP)), FEWEST, MOST))
        shares = (np.arange(samples) + 0.5) / samples
        place, speed = trajectory.states[:, :3], trajectory.states[:, 3:6]
        count, steps = len(trajectory.steps), trajectory.steps[:, None]
        points = np.stack([hermite(np.full(count, s), steps, (place[:-1], place[1:]), (speed[:-1], speed[1:]))[0] for s in shares], axis=1)
        times = trajectory.times[:-1, None] + shares * steps
        return cls(times.ravel(), points.reshape(-1, 3), np.repeat(np.arange(count), samples), trajectory.owners, place, samples)

    @property
    def ends(self) -> NDArray[np.intp]:
        """Node at which each phase ends, shape (M,)."""
        return np.cumsum(np.bincount(self.owners))


@dataclass(frozen=True)
class Fault:
    """Where a path comes too near.

    Attributes:
        kept: index of the solid.
        phase: on the way to which target.
        distance: [m] of the vehicle's centre from it.
        lack: [m] by which that is too little.
        touched: whether the vehicle touches it.
    """

    kept: int
    phase: int
    distance: float
    lack: float
    touched: bool


@dataclass(frozen=True)
class Surroundings:
    """Everything that a plan keeps clear of.

    Attributes:
        problem: what is planned.
        kept: the solids; openings that must not be crossed are among them once a path has crossed them.
        extra: [m] added to the margin of a solid (index) in a phase.
    """

    problem: Problem
    kept: tuple[Kept, ...]
    extra: Mapping[tuple[int, int], float] = field(default_factory=dict)

    @classmethod
    def of(cls, problem: Problem) -> Surroundings:
        """Obstacles and frames of a problem's course."""
        if problem.course is None:
            return cls(problem, ())
        kept = []
        for solid in solids_of(problem.course, problem.tolerance):
            insets = [target.inset for target in problem.targets if same_place(target.plane, solid.plane)]
            margin = max(min([problem.margin, *insets]), problem.radius)
            kept.append(Kept.of(problem, solid, margin, problem.radius))
        kept += [Kept.of(problem, wall, problem.margin, problem.radius) for wall in walls_of(problem.course)]
        if np.isfinite(problem.floor):
            kept.append(Kept.of(problem, floor_at(problem.floor), SLACK, 0.0))
        return cls(problem, tuple(kept))

    def with_plugs(self, path: Path) -> Surroundings:
        """The same, with the openings closed that a path crosses against their direction."""
        if self.problem.course is None:
            return self
        plugs, counted = [], {target.waypoint.removesuffix(" of lap 1") for target in self.problem.targets if target.counts}
        for name, plane in gate_planes(self.problem.course, self.problem.tolerance):
            closed = any(kept.solid.name == name for kept in self.kept)
            if closed or not plane.one_way or name not in counted:
                continue
            if len(self._crossed(plane, path)):
                plugs.append(Kept.of(self.problem, plug(name, plane), PLUGGED, 0.0))
        return replace(self, kept=(*self.kept, *plugs))

    def faults(self, path: Path) -> list[Fault]:
        """Where a path comes too near to what, the worst place for each solid and phase."""
        found = []
        for k, kept in enumerate(self.kept):
            distances, _, lacks = self._measure(kept, path)
            if kept.solid.opening and kept.solid.plane is not None:
                crossed = self._crossed(kept.solid.plane, path)
                distances[crossed], lacks[crossed] = 0.0, kept.margin  # however far apart the places of the path are
            for phase in np.unique(path.owners[path.intervals[lacks > kept.tolerance]]).tolist():
                rows = np.flatnonzero(path.owners[path.intervals] == phase)
                worst = rows[lacks[rows].argmax()]
                distance, lack = float(distances[worst]), float(lacks[worst])
                found.append(Fault(k, phase, distance, lack, distance < min(kept.least, distance + lack)))
        return found

    def with_extra(self, faults: list[Fault]) -> Surroundings:
        """The same, with larger margins where a path came too near."""
        extra = dict(self.extra)
        for fault in faults:
            extra[fault.kept, fault.phase] = extra.get((fault.kept, fault.phase), 0.0) + fault.lack + EXTRA
        return replace(self, extra=extra)

    def shrunk(self) -> Surroundings:
        """The same with a smaller clearance; closed openings stay what they are: a path through one with less would not be seen."""
        kept = [
            kept if kept.solid.opening else replace(kept, margin=kept.least + SHRUNK * (kept.margin - kept.least)) for kept in self.kept
        ]
        return Surroundings(self.problem, tuple(kept))

    def without_extra(self) -> Surroundings:
        """The same, with the margins of the beginning."""
        return replace(self, extra={})

    def rows(self, path: Path) -> LinearRows:
        """Rows that keep the nodes of a plan on the outer side of what is near to a path with the same intervals."""
        parts = []
        for k, kept in enumerate(self.kept):
            distances, away, lacks = self._measure(kept, path)
            own = {int(path.ends[phase]) for phase, target in enumerate(self.problem.targets) if same_place(target.plane, kept.solid.plane)}
            nearest = np.argmin(np.where(np.isfinite(lacks), distances, np.inf).reshape(-1, path.samples), axis=1)
            for interval, sample in enumerate(interval * path.samples + step for interval, step in enumerate(nearest)):
                reach = REACH + 0.5 * float(np.linalg.norm(path.nodes[interval + 1] - path.nodes[interval]))
                if not -lacks[sample] < reach:
                    continue
                margin = distances[sample] + lacks[sample] + self.extra.get((k, int(path.owners[interval])), 0.0)
                least = away[sample] @ path.points[sample] - distances[sample] + margin
                nodes = [node for node in (interval, interval + 1) if node > 0 and node not in own]
                parts += [LinearRows.of(node, away[sample], least, np.inf) for node in nodes]
        return LinearRows.joined(parts)

    def lacks(self, points: Floats) -> tuple[Floats, np.ndarray]:
        """By how much points (n, 3) are too near to the worst solid [m], and its index: for straight ways around."""
        each = np.full((len(self.kept), len(points)), -np.inf)
        for k, kept in enumerate(self.kept):
            near = kept.solid.near(points, kept.margin)
            if near.any():
                each[k, near] = kept.margins(points[near]) - kept.solid.measure(points[near])[0] - kept.slack
        return each.max(axis=0), each.argmax(axis=0)

    def beside(self, index: int, heights: Floats) -> Floats:
        """Free places (k, 3) around a solid."""
        kept, walls = self.kept[index], self.problem.walls
        margin = kept.margin if kept.solid.plane is None else max(kept.margin, self.problem.margin)
        places = kept.solid.around(margin + SLACK, heights)
        inside = (places >= walls[0] + self.problem.radius).all(axis=1) & (places <= walls[1] - self.problem.radius).all(axis=1)
        places = places[inside & (places[:, 2] >= self.problem.floor)]
        return places[self.lacks(places)[0] <= 0] if len(places) else places

    def free_place(self, target: Target, near: Floats) -> Floats:
        """Where a phase may end: the middle, or what is free of everything and nearest to a place (3,) [m] (world)."""
        places = np.vstack([target.position, _spread(target)])
        free = self.lacks(places)[0] <= 0
        if free[0] or not free.any():
            return target.position
        return places[free][np.linalg.norm(places[free] - near, axis=1).argmin()]

    def refuse_blocked(self) -> None:
        """Refuse a start, end or ball in which the vehicle touches more than the ground, and an opening in which it does everywhere.

        Raises:
            PlanningError: naming both.
        """
        problem = self.problem
        places = [(None, "the start", problem.start, 0.0)]
        places += [(target.waypoint, "its middle", target.position, target.radius) for target in problem.targets if target.plane is None]
        for kept in (kept for kept in self.kept if not kept.solid.ground):
            for where, what, place, freedom in places:
                distance = float(kept.solid.measure(place[None])[0][0])
                if distance + freedom < kept.least:
                    reason = (
                        f"{what} is {max(distance, 0):.3g} m from {kept.solid.name}, and the vehicle needs its radius of {kept.least:.3g} m"
                    )
                    raise PlanningError(problem.track, where, reason)
            for target in problem.targets:
                if target.plane is None or same_place(target.plane, kept.solid.plane):
                    continue
                if (kept.solid.measure(_spread(target))[0] < kept.least).all():
                    raise PlanningError(problem.track, target.waypoint, f"its opening is blocked by {kept.solid.name}")

    def _measure(self, kept: Kept, path: Path) -> tuple[Floats, Floats, Floats]:
        """Distances (infinite where it is far), outward directions, and what is lacking; -inf within the gate's own opening."""
        longest = float(np.linalg.norm(np.diff(path.nodes, axis=0), axis=1).max())
        distances, away = np.full(len(path.points), np.inf), np.zeros_like(path.points)
        near = kept.solid.near(path.points, kept.margin + REACH + longest)
        if near.any():
            distances[near], away[near] = kept.solid.measure(path.points[near])
        lacks = kept.margins(path.points) - distances
        return distances, away, np.where(self._on_own_way(kept.solid.plane, path, opening=kept.solid.opening), -np.inf, lacks)

    def _crossed(self, plane: GatePlane, path: Path) -> NDArray[np.intp]:
        """Rows of a path at which it crosses an opening against its direction, other than on its own way through it."""
        crossings = find_crossings(path.times, path.points, plane)
        wrong = crossings.times[~crossings.forward & (crossings.rims < 0)]
        rows = np.clip(np.searchsorted(path.times, wrong), 0, len(path.times) - 1)
        return rows[~self._on_own_way(plane, path, opening=True)[rows]]

    def _on_own_way(self, plane: GatePlane | None, path: Path, *, opening: bool) -> np.ndarray:
        """Whether each place of a path belongs to a passage through a plane that the route asks for, shape (rows,).

        Args:
            plane: of a gate; None for what has no opening.
            path: the places.
            opening: whether the opening is meant, and not its frame: where one plane stands for a gate, it is crossed beside a node.
        """
        through = np.zeros(len(path.owners), dtype=bool)
        for phase, target in enumerate(self.problem.targets):
            if not same_place(target.plane, plane):
                continue
            if target.inside:
                through[path.owners == phase] = True
            elif opening and target.along == 0:
                through[path.ends[phase] - 1 : path.ends[phase] + 1] = True
        return through[path.intervals]


def _spread(target: Target) -> Floats:
    """Places (n, 3) [m] (world) all over where a phase may end: an opening less its inset, or a ball."""
    plane, ticks = target.plane, np.linspace(-1, 1, SPREAD)
    if plane is None:
        cube = np.stack(np.meshgrid(*[ticks[::BALL_STRIDE]] * 3), axis=-1).reshape(-1, 3)
        return target.position + target.radius * cube[np.linalg.norm(cube, axis=1) <= 1]
    corners = plane.corners if len(plane.corners) else plane.radius * np.array([[-1.0, -1.0], [1.0, 1.0]])
    low, high = corners.min(axis=0) + target.inset, corners.max(axis=0) - target.inset
    flat = (low + high) / 2 + (high - low) / 2 * np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
    flat = np.vstack([plane.middle[0], flat[plane.rim_distance(flat) <= -target.inset]])
    return plane.centre + flat @ plane.rotation[:, 1:].T + target.along * plane.normal

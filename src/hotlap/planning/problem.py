"""Problem: what is to be planned; Trajectory: a candidate at the nodes of the transcription."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import PlanningError
from hotlap.planning.linear_rows import LinearRows
from hotlap.planning.targets import Target, targets_of
from hotlap.race.flight_performance import top_speed
from hotlap.race.gate_plane import plane_of
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import PlanDynamics, Race, Ramp
from hotlap.race.track import Track

Floats = NDArray[np.float64]

SHORTEST, LONGEST = 0.02, 60.0  # s, of one phase
BRIEFEST = 1e-3  # s, of a phase through a gate
FEWEST = 3  # intervals of a phase


@dataclass(frozen=True)
class Problem:
    """A minimum-time problem: from the start through ordered targets; everything that the planner knows of a race.

    Attributes:
        track: its name, for messages.
        start: shape (3,) [m] (world).
        attitude: shape (4,) at the start.
        targets: where the phases end.
        tolerance: [m] how far from a waypoint without an opening its phase may end.
        floor: [m] height below which the plan does not go; -inf where there is none.
        intervals: K, shooting intervals of each phase.
        quadrotor: the planning model.
        drag: [1/s] its linear drag, isotropic.
        ramp: limits that grow over the first metres, or None.
        start_velocity: shape (3,) [m/s] (world).
        end_at_rest: whether the plan ends at rest, level.
        radius: [m] of the vehicle.
        clearance: [m] wanted beside it.
        clearance_given: whether somebody asked for it.
        walls: shape (2, 3) [m] (world) least and largest coordinates; infinite where there is no wall.
        course: the track, where it has more than points: gates with directions or frames, obstacles, walls.
        dynamics: what the plan knows of the quadrotor; with "full" the quadrotor's own drags, motors and rate loop count.
        command_rates: shape (3,) [rad/s] largest rates that the rate loop is asked for, with "full".
    """

    track: str
    start: Floats
    attitude: Floats
    targets: tuple[Target, ...]
    tolerance: float
    floor: float
    intervals: int
    quadrotor: Quadrotor
    drag: float
    ramp: Ramp | None
    start_velocity: Floats
    end_at_rest: bool
    radius: float
    clearance: float
    clearance_given: bool
    walls: Floats
    course: Track | None
    dynamics: PlanDynamics
    command_rates: Floats

    @classmethod
    def of(cls, race: Race) -> Problem:
        """The problem that a race poses.

        Raises:
            PlanningError: the plan may not use enough thrust to hover, or an opening is too small for the vehicle.
        """
        track, settings, ratio = race.track, race.planning, race.planning_model.thrust_to_weight
        if ratio <= 1:
            hint = "raise planning.thrust_share" if settings.quadrotor is None else "give planning.quadrotor stronger rotors"
            raise PlanningError(track.name, None, f"the plan may use a thrust-to-weight of {ratio:.2f} and cannot hover; {hint}")
        floor = track.floor if settings.floor is None else settings.floor
        return cls(
            track=track.name,
            start=np.array(track.start),
            attitude=np.array(track.attitude),
            targets=targets_of(race),
            tolerance=settings.tolerance,
            floor=-np.inf if floor is None else floor,
            intervals=settings.nodes,
            quadrotor=_planned(race),
            drag=race.planning_drag,
            ramp=settings.ramp,
            start_velocity=np.array(track.start_velocity),
            end_at_rest=track.end_at_rest,
            radius=race.vehicle.outer_radius,
            clearance=race.vehicle.outer_radius if settings.clearance is None else settings.clearance,
            clearance_given=settings.clearance is not None,
            walls=_walls(track),
            course=track if _more_than_points(track) else None,
            dynamics=settings.dynamics,
            command_rates=settings.rate_share * np.array(race.controller.rates),
        )

    @property
    def full(self) -> bool:
        """Whether motors, rate loop and all drags are planned with."""
        return self.dynamics is PlanDynamics.FULL

    @property
    def phases(self) -> int:
        """M, one for each target."""
        return len(self.targets)

    @cached_property
    def waypoints(self) -> Floats:
        """The middles of the targets, shape (M, 3) [m] (world)."""
        return np.array([target.position for target in self.targets])

    @cached_property
    def radii(self) -> Floats:
        """[m] of the balls in which the phases end, shape (M,); infinite where there is none."""
        return np.array([target.radius for target in self.targets])

    @property
    def counts(self) -> tuple[int, ...]:
        """Intervals of each phase where they differ: a way through a gate has as many as its length asks for."""
        if not any(target.inside for target in self.targets):
            return ()
        legs = self.legs
        usual = float(np.median(legs[[not target.inside for target in self.targets]]))
        shares = np.ceil(self.intervals * legs / usual).clip(min(FEWEST, self.intervals), self.intervals)
        return tuple(int(share) if target.inside else self.intervals for target, share in zip(self.targets, shares, strict=True))

    @property
    def intervals_in_all(self) -> int:
        """N."""
        return sum(self.counts) or self.phases * self.intervals

    @property
    def margin(self) -> float:
        """[m] that the vehicle's centre keeps from obstacles and walls, where it can."""
        return self.radius + self.clearance

    @property
    def has_openings(self) -> bool:
        """Whether a target is an opening."""
        return any(target.plane is not None for target in self.targets)

    def rows(self) -> LinearRows:
        """What the openings ask for."""
        intervals = np.array(self.counts) if self.counts else np.full(self.phases, self.intervals)
        ends = np.cumsum(intervals)
        return LinearRows.joined(
            target.rows(int(end), int(count)) for target, end, count in zip(self.targets, ends, intervals, strict=True)
        )

    @property
    def points(self) -> Floats:
        """Start and waypoints, shape (M + 1, 3) [m] (world)."""
        return np.vstack([self.start, self.waypoints])

    @property
    def legs(self) -> Floats:
        """Straight distances from point to point, shape (M,) [m]."""
        return np.linalg.norm(np.diff(self.points, axis=0), axis=1)

    @property
    def level_acceleration(self) -> float:
        """[m/s^2] largest acceleration at constant height."""
        quadrotor = self.quadrotor
        return float(np.sqrt(quadrotor.max_acceleration**2 - quadrotor.gravity**2))

    @property
    def shortest(self) -> Floats:
        """[s] least duration of each phase, shape (M,)."""
        return np.array([BRIEFEST if target.inside else SHORTEST for target in self.targets])

    @property
    def top_speed(self) -> float:
        """[m/s] in level flight with all drags of the quadrotor; infinite where there are none."""
        return top_speed(self.quadrotor)

    def error(self, phase: int, reason: str) -> PlanningError:
        """The failure of one phase: names its gate, point, or the end."""
        return PlanningError(self.track, self.targets[phase].waypoint, reason)


def _more_than_points(track: Track) -> bool:
    """Whether a track has gates with planes, obstacles or walls, of which the nodes of a plan do not tell enough."""
    walled = track.box is not None or track.ceiling is not None
    return walled or bool(track.poles or track.spheres or track.boxes) or any(plane_of(gate, 1.0) for gate in track.gates)


def _walls(track: Track) -> Floats:
    """Of box and ceiling."""
    walls = np.array([[-np.inf] * 3, [np.inf] * 3])
    if track.box is not None:
        walls = np.array([track.box.low, track.box.high])
    if track.ceiling is not None:
        walls[1, 2] = min(walls[1, 2], track.ceiling)
    return walls


def _planned(race: Race) -> Quadrotor:
    """The planning model; the drag that `planning.v_max` gives stands in place of its linear one."""
    quadrotor, settings = race.planning_model, race.planning
    if settings.v_max is None or settings.dynamics is not PlanDynamics.FULL:
        return quadrotor
    return quadrotor.model_copy(update={"drag": (race.planning_drag,) * 3})


@dataclass(frozen=True)
class Trajectory:
    """M phases of K intervals each, or of numbers of their own; N in all. Also used for lower and upper bounds of one.

    Attributes:
        durations: shape (M,) [s] of the phases.
        states: shape (N + 1, nx) at the nodes; position first, then velocity.
        controls: shape (N, nu), constant over an interval.
        counts: intervals of each phase where they differ.
    """

    durations: Floats
    states: Floats
    controls: Floats
    counts: tuple[int, ...] = ()

    @property
    def intervals(self) -> NDArray[np.intp]:
        """Number of intervals of each phase, shape (M,)."""
        phases = len(self.durations)
        return np.array(self.counts) if self.counts else np.full(phases, len(self.controls) // phases)

    @property
    def owners(self) -> NDArray[np.intp]:
        """Phase of each interval, shape (N,)."""
        return np.repeat(np.arange(len(self.durations)), self.intervals)

    @property
    def steps(self) -> Floats:
        """Lengths of the intervals, shape (N,) [s]."""
        return np.repeat(self.durations / self.intervals, self.intervals)

    @property
    def times(self) -> Floats:
        """Of the nodes, shape (N + 1,) [s]."""
        return np.concatenate([[0.0], np.cumsum(self.steps)])

    @property
    def duration(self) -> float:
        """[s] of all phases."""
        return float(self.durations.sum())

    @property
    def ends(self) -> NDArray[np.intp]:
        """Node at which each phase ends, shape (M,)."""
        return np.cumsum(self.intervals)

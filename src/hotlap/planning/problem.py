"""Problem: what is to be planned; Trajectory: a candidate at the nodes of the transcription."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import PlanningError
from hotlap.race.flight_performance import top_speed
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import PlanDynamics, Race, Ramp

Floats = NDArray[np.float64]

SHORTEST, LONGEST = 0.02, 60.0  # s, of one phase


@dataclass(frozen=True)
class Problem:
    """A minimum-time problem: from rest through ordered waypoints; everything that the planner knows of a race.

    Attributes:
        track: its name, for messages.
        start: shape (3,) [m] (world).
        attitude: shape (4,) at the start.
        waypoints: shape (M, 3) [m] (world): the gates, then perhaps the end.
        gates: how many of the waypoints are gates.
        tolerance: [m] how far from a waypoint its phase may end.
        floor: [m] height below which the plan does not go; -inf where there is none.
        intervals: K, shooting intervals of each phase.
        quadrotor: the planning model.
        drag: [1/s] its linear drag, isotropic.
        ramp: limits that grow over the first metres, or None.
        dynamics: what the plan knows of the quadrotor; with "full" the quadrotor's own drags, motors and rate loop count.
        command_rates: shape (3,) [rad/s] largest rates that the rate loop is asked for, with "full".
    """

    track: str
    start: Floats
    attitude: Floats
    waypoints: Floats
    gates: int
    tolerance: float
    floor: float
    intervals: int
    quadrotor: Quadrotor
    drag: float
    ramp: Ramp | None
    dynamics: PlanDynamics
    command_rates: Floats

    @classmethod
    def of(cls, race: Race) -> Problem:
        """The problem that a race poses.

        Raises:
            PlanningError: the plan may not use enough thrust to hover.
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
            waypoints=track.waypoints,
            gates=len(track.counted),
            tolerance=settings.tolerance,
            floor=-np.inf if floor is None else floor,
            intervals=settings.nodes,
            quadrotor=_planned(race),
            drag=race.planning_drag,
            ramp=settings.ramp,
            dynamics=settings.dynamics,
            command_rates=settings.rate_share * np.array(race.controller.rates),
        )

    @property
    def full(self) -> bool:
        """Whether motors, rate loop and all drags are planned with."""
        return self.dynamics is PlanDynamics.FULL

    @property
    def phases(self) -> int:
        """M, one for each waypoint."""
        return len(self.waypoints)

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
    def top_speed(self) -> float:
        """[m/s] in level flight with all drags of the quadrotor; infinite where there are none."""
        return top_speed(self.quadrotor)

    def error(self, phase: int, reason: str) -> PlanningError:
        """The failure of one phase: names its gate, or the end."""
        if phase < self.gates:
            return PlanningError(self.track, phase, reason)
        return PlanningError(self.track, None, f"the end: {reason}")


def _planned(race: Race) -> Quadrotor:
    """The planning model; the drag that `planning.v_max` gives stands in place of its linear one."""
    quadrotor, settings = race.planning_model, race.planning
    if settings.v_max is None or settings.dynamics is not PlanDynamics.FULL:
        return quadrotor
    return quadrotor.model_copy(update={"drag": (race.planning_drag,) * 3})


@dataclass(frozen=True)
class Trajectory:
    """M phases of K intervals each; N = M K. Also used for lower and upper bounds of one.

    Attributes:
        durations: shape (M,) [s] of the phases.
        states: shape (N + 1, nx) at the nodes; position first, then velocity.
        controls: shape (N, nu), constant over an interval.
    """

    durations: Floats
    states: Floats
    controls: Floats

    @property
    def intervals(self) -> int:
        """K, intervals of each phase."""
        return len(self.controls) // len(self.durations)

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
        return self.intervals * np.arange(1, len(self.durations) + 1)

"""Small races that are planned in half a second, and plans of them that tests share."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import Any

from hotlap.files.descriptions import load_race
from hotlap.planning.planner import find_plan
from hotlap.planning.problem import Problem, Trajectory
from hotlap.planning.sampling import sample
from hotlap.race.race import PlanDynamics, Race
from hotlap.race.rotors import RotorLayout
from hotlap.race.track import Gate
from hotlap.reference.reference import Reference

HILL = ((6.0, 2.0, 1.0), (10.0, 8.0, 4.0), (2.0, 10.0, 2.5), (-3.0, 4.0, 0.8))


def make_race(
    gates: Iterable[tuple[float, float, float]] = HILL,
    *,
    base: str = "circle-34",
    track: dict[str, Any] | None = None,
    planning: dict[str, Any] | None = None,
    quadrotor: dict[str, Any] | None = None,
) -> Race:
    """A built-in race on another track, with some settings replaced."""
    race = load_race(base)
    own = {"name": "small", "start": (0.0, 0.0, 0.5), "attitude": (1.0, 0.0, 0.0, 0.0), "end": None}
    gates = tuple(Gate(position=gate) for gate in gates)
    planned = race.planning_model.model_copy(update=quadrotor)
    return race.model_copy(
        update={
            "track": race.track.model_copy(update={**own, "gates": gates, **(track or {})}),
            "planning": race.planning.model_copy(update={"quadrotor": planned, **(planning or {})}),
        }
    )


LOW = ((4.0, 0.0, 0.7), (9.0, 3.0, 0.7), (9.0, 9.0, 0.7))  # where diving below the floor would be faster

RACES = {
    "drag": make_race(track={"end": (-6.0, 0.0, 0.8)}),
    "ramp": make_race(base="split-s"),  # no drag, a floor, a yaw rate
    "floor": make_race(LOW, track={"start": (0.0, 0.0, 3.0)}, planning={"floor": 0.6}),
    "inverted": make_race(track={"attitude": (0.0, 1.0, 0.0, 0.0)}, quadrotor={"rotor_thrust": (0.5, 4.0), "layout": RotorLayout.PLUS}),
}


OWN: dict[str, Any] = {  # all that a plan with full dynamics knows
    "motor_time": (0.03, 0.05),
    "rate_gain": (15.0, 12.0, 5.0),
    "torque_damping": 0.2,
    "drag": (0.3, 0.2, 0.1),
    "rotor_drag": 0.03,
    "body_drag": (0.02, 0.03, 0.05),
}
WITH_ALL: dict[str, Any] = {"dynamics": PlanDynamics.FULL, "v_max": None}
FULL = {
    "full": make_race(track={"end": (-6.0, 0.0, 0.8)}, planning=WITH_ALL, quadrotor=OWN),
    "at once": make_race(HILL[:2], planning=WITH_ALL, quadrotor={**OWN, "motor_time": (0.0, 0.0)}),
}


@cache
def planned(name: str) -> tuple[Race, Problem, Trajectory, Reference]:
    """A race with its problem, its plan and the plan's rows, without run-out."""
    race = (RACES | FULL)[name]
    problem = Problem.of(race)
    trajectory = find_plan(problem)
    return race, problem, trajectory, sample(problem, trajectory, cpu_time=0.0)

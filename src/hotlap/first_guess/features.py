"""Features: numbers that describe a piece of a reference trajectory and the vehicle that flies it, for regression."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.race.race import GateRule, Race
from hotlap.reference.reference import PERIOD
from hotlap.reference.scenario import Scenario

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Stretch:
    """Rows of a reference trajectory from the first to the last one of a piece.

    Attributes:
        period: [s] between rows.
        position: shape (rows, 3) [m].
        velocity: shape (rows, 3) [m/s].
        rates: shape (rows, 3) [rad/s].
        thrust: shape (rows,) [-] share of the vehicle's largest thrust.
    """

    period: float
    position: Floats
    velocity: Floats
    rates: Floats
    thrust: Floats

    @property
    def speed(self) -> Floats:
        """Speed [m/s], shape (rows,)."""
        return np.linalg.norm(self.velocity, axis=1)

    @property
    def acceleration(self) -> Floats:
        """Norm of the acceleration between rows [m/s^2], shape (rows - 1,); of a single row 0, shape (1,)."""
        return np.linalg.norm(np.diff(self.velocity, axis=0), axis=1) / self.period if len(self.velocity) > 1 else np.zeros(1)


def _slope(stretch: Stretch) -> float:
    """Angle of the line from the first to the last point above the horizontal [rad]."""
    across, along, up = stretch.position[-1] - stretch.position[0]
    return math.atan2(up, math.hypot(across, along))


OF_A_PIECE: Mapping[str, Callable[[Stretch], float]] = {
    "points": lambda s: 1.0 + (len(s.position) - 1) * (s.period / PERIOD),  # as many as rows every 10 ms would be
    "slope": _slope,
    "rise": lambda s: float(s.position[-1, 2] - s.position[0, 2]),
    "mean_speed": lambda s: float(s.speed.mean()),
    "mean_acceleration": lambda s: float(s.acceleration.mean()),
    "max_speed": lambda s: float(s.speed.max()),
    "max_acceleration": lambda s: float(s.acceleration.max()),
    "mean_rate": lambda s: float(np.linalg.norm(s.rates, axis=1).mean()),
    "max_rate": lambda s: float(np.linalg.norm(s.rates, axis=1).max()),
    "mean_thrust": lambda s: float(s.thrust.mean()),
    "max_thrust": lambda s: float(s.thrust.max()),
}
"""Features of the rows of a piece, in m, rad, m/s, m/s^2, rad/s and shares of the largest thrust; the first five are the paper's."""

OF_A_RACE: Mapping[str, Callable[[Race], float]] = {
    "thrust_to_weight": lambda race: race.vehicle.thrust_to_weight,
    "unknown_delay": lambda race: race.vehicle.delay - (race.control_model.delay if race.controller.predict else 0.0),
    "response_time": lambda race: 1 / float(race.vehicle.hover_rate_gain[0]) + sum(race.vehicle.motor_time) / 2,
    "closest": lambda race: float(race.judge.rule is not GateRule.CLOCK),
}
"""Features of vehicle and rules: thrust over weight, dead time [s] that the control model lacks, lag [s] of motors and rate loop, and
1 where gates are judged by closest approach, else 0."""

PAPER = ("points", "slope", "rise", "mean_speed", "mean_acceleration")


def piece_features(scenario: Scenario, names: Sequence[str]) -> Floats:
    """Features of each of P pieces, shape (P, F), in the order of the names; those of the race are the same in all rows."""
    period, last = scenario.reference.period, scenario.reference.planned_rows - 1
    cuts = [tuple(min(round(time / period), last) for time in (piece.start, piece.end)) for piece in scenario.segments.pieces]
    return np.array([_features(scenario, _stretch(scenario, first, end), names) for first, end in cuts])


def race_features(scenario: Scenario, names: Sequence[str]) -> Floats:
    """Features of a race and of its whole reference, shape (F,), in the order of the names."""
    return np.array(_features(scenario, _stretch(scenario, 0, scenario.reference.planned_rows - 1), names))


def _features(scenario: Scenario, stretch: Stretch, names: Sequence[str]) -> list[float]:
    """Features in the order of the names."""
    return [OF_A_RACE[name](scenario.race) if name in OF_A_RACE else OF_A_PIECE[name](stretch) for name in names]


def _stretch(scenario: Scenario, first: int, end: int) -> Stretch:
    """Rows of a reference, from the first to the last one, which is included."""
    reference, rows = scenario.reference, slice(first, max(end, first) + 1)
    thrust = reference.thrust[rows] / scenario.race.vehicle.max_acceleration
    return Stretch(reference.period, reference.position[rows], reference.velocity[rows], reference.rates[rows], thrust)

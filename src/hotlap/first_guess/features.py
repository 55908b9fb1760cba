"""Features: what a regressor is told about the pieces of a reference, and about who flies them."""

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
    """Rows of a reference from the beginning of a piece to its end, both counted.

    Attributes:
        period: [s] between rows.
        position: shape (rows, 3) [m].
        velocity: shape (rows, 3) [m/s].
        rates: shape (rows, 3) [rad/s].
        thrust: shape (rows,) [-] share of what the vehicle can do.
    """

    period: float
    position: Floats
    velocity: Floats
    rates: Floats
    thrust: Floats

    @property
    def speed(self) -> Floats:
        """[m/s] shape (rows,)."""
        return np.linalg.norm(self.velocity, axis=1)

    @property
    def acceleration(self) -> Floats:
        """[m/s^2] its size between rows, shape (rows - 1,), or (1,) zero of a single row."""
        return np.linalg.norm(np.diff(self.velocity, axis=0), axis=1) / self.period if len(self.velocity) > 1 else np.zeros(1)


def _slope(stretch: Stretch) -> float:
    """Of the chord [rad]; an angle, because a vertical chord has no rise over run."""
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
"""Of the rows of a piece; the first five are the paper's (Sec. IV-D): m, rad, m/s, m/s^2, rad/s, and thrust as a share of the vehicle's."""

OF_A_RACE: Mapping[str, Callable[[Race], float]] = {
    "thrust_to_weight": lambda race: race.vehicle.thrust_to_weight,
    "unknown_delay": lambda race: race.vehicle.delay - (race.control_model.delay if race.controller.predict else 0.0),
    "response_time": lambda race: 1 / race.vehicle.rate_gain[0] + sum(race.vehicle.motor_time) / 2,
    "closest": lambda race: float(race.judge.rule is not GateRule.CLOCK),
}
"""Of who flies: thrust over weight, dead time [s] that the controller does not know of, lag [s] of motors and rate loop, and 1 where gates
are judged by closest approach."""

PAPER = ("points", "slope", "rise", "mean_speed", "mean_acceleration")


def piece_features(scenario: Scenario, names: Sequence[str]) -> Floats:
    """Features of each piece, shape (P, F), in the order of the names; those of the race are the same in every row."""
    period, last = scenario.reference.period, scenario.reference.planned_rows - 1
    cuts = [tuple(min(round(time / period), last) for time in (piece.start, piece.end)) for piece in scenario.segments.pieces]
    return np.array([_features(scenario, _stretch(scenario, first, end), names) for first, end in cuts])


def race_features(scenario: Scenario, names: Sequence[str]) -> Floats:
    """Features of a race and of its whole reference, shape (F,)."""
    return np.array(_features(scenario, _stretch(scenario, 0, scenario.reference.planned_rows - 1), names))


def _features(scenario: Scenario, stretch: Stretch, names: Sequence[str]) -> list[float]:
    """In the order of the names."""
    return [OF_A_RACE[name](scenario.race) if name in OF_A_RACE else OF_A_PIECE[name](stretch) for name in names]


def _stretch(scenario: Scenario, first: int, end: int) -> Stretch:
    """Rows of a reference, both ends counted."""
    reference, rows = scenario.reference, slice(first, max(end, first) + 1)
    thrust = reference.thrust[rows] / scenario.race.vehicle.max_acceleration
    return Stretch(reference.period, reference.position[rows], reference.velocity[rows], reference.rates[rows], thrust)

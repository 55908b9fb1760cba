"""Objective: parameters in, scores out; a scenario, a world and a metric bound together."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.core.parameters import Parameters
from hotlap.core.records import Flights, Scores
from hotlap.race.vehicle_parameters import draw_vehicle_parameters
from hotlap.reference.scenario import Scenario
from hotlap.tuning.scoring import Metric, score
from hotlap.worlds.world import World


class Flies(Protocol):
    """What a tuning needs: parameters in, scores out."""

    def fly(self, parameters: Parameters, seeds: NDArray[np.int64]) -> Scores:
        """Fly parameters, shape (B, S, K), with the noise of seeds, shape (B,); the score of each flight."""
        ...


@dataclass
class Objective:
    """The function that a tuning loop minimises: parameters are flown and scored (Eq. 1 of the paper, sampled).

    Attributes:
        scenario: what is flown.
        world: where.
        metric: what the cost measures.
        randomise: how far each flight's vehicle may differ from the race's, as a share; see `vehicle_parameters.draw_vehicle_parameters`.
        cost: of your own, in place of the metric's: (flights, scores by the metric) -> shape (B,), not negative, less is better.
            A study of it is configured with `cost=objective.own_cost`. One that is negative or of another shape is an `InputError`.
        flights: how many have been flown through it.
    """

    scenario: Scenario
    world: World
    metric: Metric = Metric.TIME
    randomise: float = 0.0
    cost: Callable[[Flights, Scores], NDArray[np.float64]] | None = None
    flights: int = field(default=0, init=False)

    @property
    def own_cost(self) -> str:
        """A name for `cost` by which a study recognises it, with a digest of its source; "" where the metric's counts.

        A closure and the functions that it calls are not part of the digest.
        """
        return "" if self.cost is None else _name(self.cost)

    def fly(self, parameters: Parameters, seeds: NDArray[np.int64]) -> Scores:
        """Fly parameters; the score of each flight.

        Args:
            parameters: shape (B, S, K).
            seeds: shape (B,), the noise of each flight.
        """
        return self.fly_recorded(parameters, seeds)[1]

    def fly_recorded(self, parameters: Parameters, seeds: NDArray[np.int64], log: Sequence[int] = ()) -> tuple[Flights, Scores]:
        """Fly parameters; the record and the score of each flight.

        Args:
            parameters: shape (B, S, K).
            seeds: shape (B,), the noise of each flight.
            log: indices in the batch of the flights to record in full.
        """
        vehicle_parameters = draw_vehicle_parameters(self.scenario.race.vehicle, seeds, self.randomise) if self.randomise else None
        flights = self.world.fly(self.scenario, parameters, seeds, vehicle_parameters=vehicle_parameters, log=log)
        self.flights += len(flights)
        scores = score(flights, self.scenario.race.judge, self.metric)
        if self.cost is None:
            return flights, scores
        return flights, scores.with_costs(_numbers(self.cost(flights, scores), len(flights)))


def _numbers(own: Any, count: int) -> NDArray[np.float64]:
    """Costs of one's own, shape (count,); one that is not a number counts as worse than all others, as an infinite one does.

    Raises:
        InputError: they are no numbers, not one for each flight, or negative.
    """
    try:
        costs = np.asarray(own, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("", "cost", f"must return numbers, shape ({count},), not a {type(own).__name__}") from None
    if costs.shape != (count,):
        raise InputError("", "cost", f"must return one number for each flight, shape ({count},), not {costs.shape}")
    if (costs < 0).any():
        worst = float(costs.min())
        raise InputError(
            "", "cost", f"must not be negative, not {worst:g}: tuners take logarithms; add a constant, or take its exponential"
        )
    return costs


def _name(cost: Callable[..., Any]) -> str:
    """Where a function or a class of callables is found, and eight hexadecimal digits of its source, if there is any."""
    while isinstance(cost, partial):
        cost = cost.func
    named: Any = cost if inspect.isroutine(cost) else type(cost)
    name = f"{named.__module__}.{named.__qualname__}"
    try:
        source = inspect.getsource(named)
    except (OSError, TypeError):  # typed in at a prompt, or compiled
        return name
    return f"{name} {hashlib.sha256(source.encode()).hexdigest()[:8]}"

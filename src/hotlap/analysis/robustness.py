"""Robustness: tuned parameters flown by vehicles that differ a little from the one that they were tuned on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters
from hotlap.core.records import Scores
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.core.success_rate import Validation
from hotlap.race.race import NoiseSettings, Race
from hotlap.race.vehicle_parameters import FORCES, MASSES, VEHICLE_PARAMETERS, scale, vehicle_parameters_of
from hotlap.reference.scenario import Scenario
from hotlap.tuning.goal import Goal
from hotlap.tuning.scoring import score
from hotlap.worlds.world import World

FLIGHTS = 50  # under each change
NOISIER = 2.0
AS_TUNED = "as tuned"
TIMES = ("time", "wind_time")  # of the noise, which stay

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Robustness:
    """Success rate of parameters under one change of the vehicle or the noise.

    Attributes:
        change: in words.
        validation: flights that met the goal.
    """

    change: str
    validation: Validation


def _scaled(factor: float, names: tuple[str, ...]) -> Callable[[Floats], Floats]:
    """Vehicle parameters with some of their columns multiplied."""
    return lambda vehicle_parameters: scale(vehicle_parameters, names, factor)


def _later(seconds: float) -> Callable[[Floats], Floats]:
    """Vehicle parameters with more dead time."""

    def change(vehicle_parameters: Floats) -> Floats:
        """Vehicle parameters with so much more dead time."""
        changed = vehicle_parameters.copy()
        changed[VEHICLE_PARAMETERS.index("delay")] += seconds
        return changed

    return change


CHANGES: Mapping[str, Callable[[Floats], Floats]] = {
    AS_TUNED: lambda vehicle_parameters: vehicle_parameters,
    "10 % lighter": _scaled(0.9, MASSES),
    "10 % heavier": _scaled(1.1, MASSES),
    "15 % less thrust": _scaled(1 / 0.85, FORCES),  # a share of the thrust at every command: all but the rotors grows
    "20 ms more dead time": _later(0.02),
}


def check_robustness(
    scenario: Scenario,
    world: World,
    goal: Goal,
    parameters: Parameters,
    seed: int,
    flights: int = FLIGHTS,
    as_tuned: Scores | None = None,
) -> tuple[Robustness, ...]:
    """Fly parameters under each of `CHANGES`, and with twice the noise; the seeds are the same under each.

    Args:
        scenario: what they were tuned on.
        world: one that takes vehicle parameters for each flight.
        goal: what counts as a success.
        parameters: shape (S, K).
        seed: of the run.
        flights: under each change.
        as_tuned: of flights without a change, with the same seeds; None: they are flown here.
    """
    seeds = flight_seeds(seed, Stream.DEMONSTRATION, 0, flights)
    changes = [change for name, change in CHANGES.items() if as_tuned is None or name != AS_TUNED]
    vehicles = np.stack([change(vehicle_parameters_of(scenario.race.vehicle)) for change in changes])
    repeated = np.repeat(parameters[None], flights * len(vehicles), axis=0)
    flown = world.fly(scenario, repeated, np.tile(seeds, len(vehicles)), vehicle_parameters=np.repeat(vehicles, flights, axis=0))
    noisy = world.fly(replace(scenario, race=_noisier(scenario.race)), repeated[:flights], seeds)
    scores = [*([] if as_tuned is None else [as_tuned]), *(score(some, scenario.race.judge) for some in (flown, noisy))]
    met = np.concatenate([goal.succeeded(some) for some in scores])
    counts = met.reshape(-1, flights).sum(axis=1).tolist()
    return tuple(
        Robustness(change, Validation(flights, count)) for change, count in zip([*CHANGES, "twice the noise"], counts, strict=True)
    )


def _noisier(race: Race) -> Race:
    """The same race with every noise larger."""
    noise = {name: value if name in TIMES else NOISIER * value for name, value in race.noise.model_dump().items()}
    return race.model_copy(update={"noise": NoiseSettings(**noise)})

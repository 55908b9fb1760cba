"""Will it hold? Tuned parameters flown where the truth is a little different from what they were tuned on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hotlap.course import Course
from hotlap.goal import Goal
from hotlap.parameters import Parameters
from hotlap.race import NoiseSettings, Race
from hotlap.scoring import score
from hotlap.seeds import Stream, flight_seeds
from hotlap.truth import FORCES, MASSES, TRUTH, scale, truth_of
from hotlap.validation import Validation
from hotlap.worlds.world import World

FLIGHTS = 100
NOISIER = 2.0
TIMES = ("time", "wind_time")  # of the noise, which stay

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Hold:
    """How parameters fare under one change.

    Attributes:
        change: in words.
        validation: flights that met the goal.
    """

    change: str
    validation: Validation


def _scaled(factor: float, names: tuple[str, ...]) -> Callable[[Floats], Floats]:
    """A truth with some of its columns multiplied."""
    return lambda truth: scale(truth, names, factor)


def _later(seconds: float) -> Callable[[Floats], Floats]:
    """A truth with more dead time."""

    def change(truth: Floats) -> Floats:
        """The truth of that."""
        changed = truth.copy()
        changed[TRUTH.index("delay")] += seconds
        return changed

    return change


CHANGES: Mapping[str, Callable[[Floats], Floats]] = {
    "as tuned": lambda truth: truth,
    "10 % lighter": _scaled(0.9, MASSES),
    "10 % heavier": _scaled(1.1, MASSES),
    "15 % less thrust": _scaled(1 / 0.85, FORCES),  # a share of the thrust at every command: all but the rotors grows
    "20 ms more dead time": _later(0.02),
}


def will_it_hold(course: Course, world: World, goal: Goal, parameters: Parameters, seed: int, flights: int = FLIGHTS) -> tuple[Hold, ...]:
    """Fly parameters under each of `CHANGES`, and with twice the noise; the seeds are the same under each.

    Args:
        course: what they were tuned on.
        world: one that takes a truth for each flight.
        goal: what counts as a success.
        parameters: shape (S, K).
        seed: of the run.
        flights: under each change.
    """
    seeds = flight_seeds(seed, Stream.DEMONSTRATION, 0, flights)
    truths = np.stack([change(truth_of(course.race.vehicle)) for change in CHANGES.values()])
    repeated = np.repeat(parameters[None], flights * len(truths), axis=0)
    flown = world.fly(course, repeated, np.tile(seeds, len(truths)), truth=np.repeat(truths, flights, axis=0))
    noisy = world.fly(replace(course, race=_noisier(course.race)), repeated[:flights], seeds)
    met = np.concatenate([goal.succeeded(score(some, course.race.judge)) for some in (flown, noisy)])
    counts = met.reshape(-1, flights).sum(axis=1).tolist()
    return tuple(Hold(change, Validation(flights, count)) for change, count in zip([*CHANGES, "twice the noise"], counts, strict=True))


def _noisier(race: Race) -> Race:
    """The same race with every noise larger."""
    noise = {name: value if name in TIMES else NOISIER * value for name, value in race.noise.model_dump().items()}
    return race.model_copy(update={"noise": NoiseSettings(**noise)})

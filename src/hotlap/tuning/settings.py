"""Settings of a tuning: its goal, how many flights it may take and how many it must pass."""

from __future__ import annotations

from dataclasses import dataclass, field

from hotlap.core.errors import InputError
from hotlap.core.seeds import FLIGHTS_A_STREAM, LARGEST_RUN_SEED, SELECTIONS_A_RUN
from hotlap.core.success_rate import FLIGHTS, RELIABILITY
from hotlap.tuning.goal import Goal

CONFIRMATIONS = 4  # "flown four times more", Sec. IV-A
SAMPLES = 4  # flights of a candidate, where vehicles differ
SAMPLES_TOGETHER = 8  # likewise, where populations are flown
WANTED = 0.985  # success rate at which a search of some minutes ends before them
CAUTION = 1.0  # standard deviations
MOST_MINUTES = 7 * 24 * 60


@dataclass(frozen=True)
class TuningSettings:
    """Settings of a run.

    Attributes:
        goal: when to stop.
        budget: flights, re-flights included.
        seed: of the tuner's chance and of the flights' noise.
        confirm: fresh re-flights that a candidate must pass.
        validation: flights of a confirmed candidate with noise that the search has not met, outside the budget; 0 for none.
        reliability: least share of them that must meet the goal, or the search goes on; 0 takes any candidate that is confirmed.
        batch: most candidates that a tuner is asked for at once.
        samples: flights of each candidate in the search, all of which must meet the goal; 0: one, or `SAMPLES` where vehicles differ.
        randomise: how far the vehicle may differ from flight to flight, as a share; see `vehicle_parameters.draw_vehicle_parameters`.
        selection: flights by which the result is chosen where no candidate was confirmed, outside the budget; 0: the best by its scores.
        minutes: of wall time that the search may take; it flies populations then. 0: only flights are counted.
    """

    goal: Goal = field(default_factory=Goal)
    budget: int = 200
    seed: int = 0
    confirm: int = CONFIRMATIONS
    validation: int = FLIGHTS
    reliability: float = RELIABILITY
    batch: int = 8
    samples: int = 0
    randomise: float = 0.0
    selection: int = 0
    minutes: float = 0.0

    @property
    def flights_each(self) -> int:
        """Flights of a candidate in the search, before its re-flights."""
        return self.samples or ((SAMPLES_TOGETHER if self.minutes else SAMPLES) if self.randomise else 1)

    @property
    def caution(self) -> float:
        """Standard deviations over a candidate's flights by which a gate's miss counts as more than its mean: it must pass in all."""
        return CAUTION if self.minutes and self.flights_each > 1 else 0.0

    @property
    def wanted(self) -> float:
        """Share of the validation that ends the search: with time left it goes on for more than is needed."""
        return max(self.reliability, WANTED) if self.minutes and self.reliability else self.reliability

    def __post_init__(self) -> None:
        for name, least, largest in (
            ("budget", 1, FLIGHTS_A_STREAM),
            ("seed", 0, LARGEST_RUN_SEED),
            ("confirm", 0, 1000),
            ("validation", 0, FLIGHTS_A_STREAM // 100),
            ("reliability", 0, 1),
            ("batch", 1, 10_000),
            ("samples", 0, 1000),
            ("randomise", 0, 0.9),
            ("selection", 0, SELECTIONS_A_RUN // 10),
            ("minutes", 0, MOST_MINUTES),
        ):
            value = getattr(self, name)
            if not least <= value <= largest:
                raise InputError("", name, f"must be from {least} to {largest}, not {value}")

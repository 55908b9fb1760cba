"""Learning: the races that first guesses are learnt from, tuned, and flown with each other's parameters.

    races -> each tuned with several seeds -> candidates -> all candidates flown in every race -> TrainingSet

None of the tracks is one of the paper's, but for Soccer_Field_Medium, which is a training track there too.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap import tuners
from hotlap.core.errors import PlanningError
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.core.version import __version__
from hotlap.files.descriptions import load_race
from hotlap.first_guess.features import OF_A_PIECE, OF_A_RACE, PAPER, piece_features, race_features
from hotlap.first_guess.training_set import DIGITS, TrainingPiece, TrainingRace, TrainingSet
from hotlap.planning.preparation import prepare
from hotlap.race.controllers import TUNABLE
from hotlap.race.race import Race
from hotlap.race.random_tracks import TrackStyle, random_track
from hotlap.race.schema import Described
from hotlap.race.track import Track
from hotlap.system.engine import is_one_of_many
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune_together
from hotlap.tuning.objective import Objective
from hotlap.worlds.built_in import BuiltIn
from hotlap.worlds.world import World

TUNER = "guided_walk:tied"  # one set for all segments, so that it can be flown on any reference
SEEDS = 3  # tunings of each race
BUDGET, CONFIRM, VALIDATION = 300, 10, 50
FLIGHTS = 8  # of each candidate in each race
FIRST_TRACK = 1000  # seed of the first random track
PIECE_FEATURES = tuple(OF_A_PIECE)
RACE_FEATURES = (*OF_A_RACE, *(name for name in OF_A_PIECE if name not in PAPER or name.startswith("mean")))

SPEEDS: Mapping[str, tuple[float, ...]] = {  # m/s, v_max of the plans of each vehicle: one track of each layout at each speed
    "hummingbird, late": (16.0, 20.0, 25.0, 30.0, 40.0),
    "hummingbird": (18.0, 25.0, 34.0),
    "airsim": (14.0, 15.0, 16.0, 17.0, 18.0, 20.0, 22.0, 25.0, 30.0, 35.0, 50.0),
    "racer": (18.0, 34.0),
    "racer, late": (14.0, 17.0, 20.0, 24.0, 30.0),
}
SOCCER, SOCCER_SPEED = "soccer-medium-20", 20.0
LATE = 0.03  # s, of the racer whose controller does not know it


@dataclass(frozen=True)
class Lesson:
    """A race to learn from, and the name of its vehicle."""

    race: Race
    vehicle: str

    @property
    def name(self) -> str:
        """For people, and not shared by two lessons."""
        return f"{self.race.name} flown by {self.vehicle} ({self.race.fingerprint})"

    @property
    def key(self) -> str:
        """A text that changes with the race and with the settings of its tuning."""
        return f"{self.race.fingerprint} {TUNER} {SEEDS} {BUDGET} {CONFIRM} {VALIDATION} {FLIGHTS}"


def lessons() -> tuple[Lesson, ...]:
    """Random tracks of every layout and Soccer_Field_Medium, flown by several quadrotors at several speeds."""
    found = []
    for vehicle, speeds in SPEEDS.items():
        for k, (speed, layout) in enumerate(product(speeds, TrackStyle)):
            found.append(Lesson(race_of(vehicle, random_track(FIRST_TRACK + k, layout), speed), vehicle))
        soccer = load_race(SOCCER)
        race = race_of(vehicle, soccer.track, SOCCER_SPEED)
        if race.planning.quadrotor is not None:  # the paper has a stronger one for it
            race = race.model_copy(update={"planning": race.planning.model_copy(update={"quadrotor": soccer.planning.quadrotor})})
        found.append(Lesson(race, vehicle))
    return tuple(found)


def race_of(vehicle: str, track: Track, v_max: float) -> Race:
    """A race of one of the vehicles in `SPEEDS` on a track."""
    base = _flown_by(vehicle)
    planning = base.planning.model_copy(update={"v_max": v_max})
    return base.model_copy(update={"name": track.name, "track": track, "planning": planning})


def _flown_by(vehicle: str) -> Race:
    """The race that gives everything but track and speed."""
    base = load_race("airsim-circle-34" if vehicle == "airsim" else "circle-34")
    if vehicle == "hummingbird":  # its controller knows the dead time
        return base.model_copy(update={"model": base.control_model.model_copy(update={"delay": base.vehicle.delay})})
    if not vehicle.startswith("racer"):
        return base
    racer = load_race("split-s")
    planning = base.planning.model_copy(update={"quadrotor": None})
    late = {"delay": LATE} if vehicle == "racer, late" else {}
    changes = {"vehicle": racer.vehicle.model_copy(update=late), "model": racer.vehicle, "controller": racer.controller}
    return base.model_copy(update={**changes, "planning": planning})


class TunedRace(Described):
    """What was found by tuning the race of a lesson.

    Attributes:
        features: of the race, in the order of `RACE_FEATURES`.
        pieces: of its reference.
        optima: confirmed parameters of its tunings, K each.
        tuned: their median in logarithms or, where more flights of it pass every gate, one of them; None without any.
        validated: share of the flights by which it was chosen in which it does.
    """

    features: tuple[float, ...]
    pieces: tuple[TrainingPiece, ...]
    optima: tuple[tuple[float, ...], ...]
    tuned: tuple[float, ...] | None
    validated: float

    @property
    def candidates(self) -> tuple[tuple[float, ...], ...]:
        """All parameters that were found."""
        return (*self.optima, *([self.tuned] if self.tuned else []))


def tune_lesson(lesson: Lesson) -> Iterator[dict[str, Any] | None]:
    """Tune a race with several seeds: a `TunedRace` as plain JSON; None where there is no plan."""
    try:
        scenario = scenario_for(prepare(lesson.race), tuners.build(TUNER))
    except PlanningError:
        yield None
        return
    objective = Objective(scenario, built_in_world())
    shared = {"budget": BUDGET, "confirm": CONFIRM, "validation": 0, "reliability": 0.0}
    runs = [Tuning(tuners.build(TUNER), scenario, TuningSettings(seed=seed, **shared)) for seed in range(SEEDS)]
    for _ in tune_together(objective, runs):
        pass
    confirmed = [run.best.parameters[0] for run in runs if run.best is not None and run.best.confirmed]
    optima = tuple(map(_rounded, confirmed))
    tuned, validated = _steadiest(objective, optima) if optima else (None, 0.0)
    pieces, rows = scenario.segments.pieces, piece_features(scenario, PIECE_FEATURES)
    tuned_race = TunedRace(
        features=_rounded(race_features(scenario, RACE_FEATURES)),
        pieces=tuple(TrainingPiece(kind=piece.kind, features=_rounded(row)) for piece, row in zip(pieces, rows, strict=True)),
        optima=optima,
        tuned=tuned,
        validated=validated,
    )
    yield tuned_race.model_dump(mode="json")


def _steadiest(objective: Objective, optima: Sequence[tuple[float, ...]]) -> tuple[tuple[float, ...], float]:
    """The median of the optima in logarithms, or an optimum that passes every gate in more flights; and in which share of them."""
    candidates = [_rounded(np.exp(np.median(np.log(optima), axis=0))), *optima]  # where there are several modes, the median is none
    shares = (_completions(objective, candidates, VALIDATION) == 1).mean(axis=1)
    best = int(np.argmax(shares))
    return candidates[best], float(shares[best])


def fly_lesson(work: tuple[Lesson, Sequence[tuple[float, ...]]]) -> Iterator[tuple[str, str]]:
    """Candidates flown in a race, all with the same noise: digits of the flights that passed every gate, and of completion."""
    lesson, candidates = work
    completion = _completions(Objective(prepare(lesson.race), built_in_world()), candidates, FLIGHTS)
    passed, completed = (completion == 1).sum(axis=1), np.floor(completion.mean(axis=1) * DIGITS + 1e-9).astype(int)
    yield "".join(map(str, passed.tolist())), "".join(map(str, completed.tolist()))


def candidates_of(tuned: Iterable[TunedRace], default: Iterable[float]) -> tuple[tuple[float, ...], ...]:
    """The default, and all that was tuned, each once."""
    return tuple(dict.fromkeys([tuple(default), *(values for result in tuned for values in result.candidates)]))


def assemble(
    lessons: Sequence[Lesson], tuned: Sequence[TunedRace], candidates: tuple[tuple[float, ...], ...], flown: Sequence[tuple[str, str]]
) -> TrainingSet:
    """The training set of all lessons that have a plan."""
    races = tuple(
        TrainingRace(
            track=lesson.race.track.name,
            vehicle=lesson.vehicle,
            v_max=lesson.race.planning.v_max,
            features=result.features,
            pieces=result.pieces,
            tuned=result.tuned,
            validated=result.validated,
            own=tuple(dict.fromkeys(candidates.index(values) for values in result.candidates)),
            passed=passed,
            completed=completed,
        )
        for lesson, result, (passed, completed) in zip(lessons, tuned, flown, strict=True)
    )
    settings = {"tuner": TUNER, "seeds": SEEDS, "budget": BUDGET, "confirm": CONFIRM, "validation": VALIDATION}
    controller = lessons[0].race.controller
    return TrainingSet(
        provenance={"hotlap": __version__, **settings},
        names=TUNABLE[controller.kind].names,
        horizon_unit=controller.horizon_unit,
        piece_features=PIECE_FEATURES,
        race_features=RACE_FEATURES,
        flights=FLIGHTS,
        candidates=candidates,
        races=races,
    )


def _completions(objective: Objective, candidates: Sequence[Sequence[float]], flights: int) -> NDArray[np.float64]:
    """Completion of each flight, shape (candidates, flights); the noise of the flights is that of every candidate."""
    one = np.repeat(np.array(candidates)[:, None], len(objective.scenario.segments), axis=1)
    seeds = np.tile(flight_seeds(0, Stream.VALIDATION, 0, flights), len(candidates))
    return objective.fly(np.repeat(one, flights, axis=0), seeds).completion.reshape(len(candidates), flights)


def built_in_world() -> World:
    """The built-in world; with one thread where there is a worker for each processor."""
    world = BuiltIn()
    if is_one_of_many():
        world.threads = 1
    return world


def _rounded(values: Iterable[float]) -> tuple[float, ...]:
    """To four digits: what is kept is what was flown."""
    return tuple(float(f"{value:.4g}") for value in values)

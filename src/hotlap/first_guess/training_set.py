"""TrainingSet: races that were tuned, and the success rate of each of many parameter sets in every one of them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files as package_files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from hotlap.core.errors import InputError
from hotlap.files.bounds import keep_bounds
from hotlap.files.error_messages import check
from hotlap.first_guess.features import OF_A_PIECE, OF_A_RACE
from hotlap.race.schema import Described, Positive
from hotlap.reference.segments import SegmentClass
from hotlap.system.regular_files import read_bytes

Floats = NDArray[np.float64]

SHIPPED = "first_guess.json"  # among the package's data
MAX_BYTES = 5_000_000  # what is shipped has a tenth
DIGITS = 9  # completion is kept in ninths


class TrainingPiece(Described):
    """A piece of a reference, as the paper's rule cuts it.

    Attributes:
        kind: class of the piece.
        features: in the order of `TrainingSet.piece_features`.
    """

    kind: SegmentClass
    features: tuple[float, ...]


class TrainingRace(Described):
    """A race that was tuned.

    Attributes:
        track: name of the track, the same for all vehicles that flew it.
        vehicle: name of the vehicle.
        v_max: [m/s] limit of the speed in its plan; None where there was none.
        features: in the order of `TrainingSet.race_features`.
        pieces: pieces of its reference.
        tuned: K parameters, the same in all segments: of its confirmed tunings and of their median those of highest success rate; None
            without any.
        validated: success rate of `tuned` in the flights by which it was chosen, so a little too high; 0 without.
        own: indices of the candidates that come from its tunings.
        passed: a digit for each candidate: number of flights in which it passed every gate.
        completed: a digit for each candidate: mean completion of its flights, in ninths, rounded down.
    """

    track: str
    vehicle: str
    v_max: float | None
    features: tuple[float, ...]
    pieces: tuple[TrainingPiece, ...] = Field(min_length=1)
    tuned: tuple[Positive, ...] | None
    validated: float = Field(ge=0, le=1)
    own: tuple[int, ...]
    passed: str = Field(pattern="^[0-9]*$")
    completed: str = Field(pattern="^[0-9]*$")


class TrainingSet(Described):
    """Races from which first guesses are learnt.

    Attributes:
        provenance: version and settings of the tuning.
        names: names of the K parameters.
        horizon_unit: [s] unit of the horizon of the races' controllers.
        piece_features: names in `features.OF_A_PIECE`.
        race_features: names in `features.OF_A_RACE` and `OF_A_PIECE`; the latter are of the whole reference.
        flights: number of flights of each candidate in each race, at most nine.
        candidates: K parameters each, the same in all segments; first the controller's default.
        races: all of them.
    """

    provenance: dict[str, Any]
    names: tuple[str, ...] = Field(min_length=1)
    horizon_unit: float = Field(gt=0)
    piece_features: tuple[str, ...]
    race_features: tuple[str, ...]
    flights: int = Field(ge=1, le=DIGITS)
    candidates: tuple[tuple[Positive, ...], ...] = Field(min_length=1)
    races: tuple[TrainingRace, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _fitting(self) -> TrainingSet:
        for key, names in (("piece_features", self.piece_features), ("race_features", self.race_features)):
            unknown = set(names) - (set(OF_A_PIECE) | (set(OF_A_RACE) if key == "race_features" else set()))
            if unknown:
                raise ValueError(f"{key}: there is no feature {min(unknown)}")
        lengths = [("candidates", len(self.names), len(values)) for values in self.candidates]
        for race in self.races:
            lengths += [
                ("races", len(self.race_features), len(race.features)),
                ("races", len(self.names), len(self.names if race.tuned is None else race.tuned)),
            ]
            lengths += [("races", len(self.candidates), len(digits)) for digits in (race.passed, race.completed)]
            lengths += [("races", len(self.piece_features), len(piece.features)) for piece in race.pieces]
        for key, wanted, found in lengths:
            if found != wanted:
                raise ValueError(f"{key}: a row has {found} entries where there are {wanted} names")
        if any(int(digit) > self.flights for race in self.races for digit in race.passed):
            raise ValueError(f"races: passed says of a candidate that it passed more than {self.flights} flights")
        if any(not 0 <= index < len(self.candidates) for race in self.races for index in race.own):
            raise ValueError("races: own names a candidate that is not there")
        return self

    @property
    def passed(self) -> Floats:
        """Share of the flights that passed every gate, shape (races, candidates)."""
        return _digits([race.passed for race in self.races]) / self.flights

    @property
    def completed(self) -> Floats:
        """Mean completion, to a ninth, shape (races, candidates)."""
        return _digits([race.completed for race in self.races]) / DIGITS

    def without(self, track: str) -> TrainingSet:
        """The training set without a track and the candidates tuned on it; the controller's default stays a candidate."""
        races = tuple(race for race in self.races if race.track != track)
        kept = sorted({0, *(index for race in races for index in race.own)})
        place = {index: i for i, index in enumerate(kept)}

        def narrowed(race: TrainingRace) -> TrainingRace:
            """A race with the remaining candidates."""
            passed, completed = ("".join(digits[i] for i in kept) for digits in (race.passed, race.completed))
            return race.model_copy(update={"passed": passed, "completed": completed, "own": tuple(place[i] for i in race.own)})

        candidates = tuple(self.candidates[i] for i in kept)
        return self.model_copy(update={"candidates": candidates, "races": tuple(map(narrowed, races))})


@cache
def shipped() -> TrainingSet:
    """The training set that comes with hotlap."""
    return _read(package_files("hotlap.data").joinpath(SHIPPED).read_bytes(), SHIPPED)


def load_training_set(path: Path) -> TrainingSet:
    """A training set from a file.

    Raises:
        InputError: with the file, the key and the reason.
    """
    return _read(read_bytes(path, MAX_BYTES, "this is no training set"), str(path))


def write_training_set(training: TrainingSet) -> str:
    """The content of a file: JSON, a line for each candidate and race."""
    plain = training.model_dump(mode="json")
    lines = [f'"{key}": {json.dumps(value)}' for key, value in plain.items() if key not in ("candidates", "races")]
    lines += [f'"{key}": [\n{_rows(plain[key])}\n]' for key in ("candidates", "races")]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _rows(values: list[Any]) -> str:
    return ",\n".join(json.dumps(value) for value in values)


def _read(content: bytes, source: str) -> TrainingSet:
    """Checked."""
    try:
        plain: Mapping[str, Any] = json.loads(content)
    except (ValueError, RecursionError):
        raise InputError(source, "", "is no JSON document") from None
    if not isinstance(plain, dict):
        raise InputError(source, "", "must be one JSON object")
    return check(TrainingSet, keep_bounds(plain, source), source)


def _digits(rows: list[str]) -> Floats:
    """Shape (rows, digits)."""
    return np.array([[int(digit) for digit in row] for row in rows], dtype=np.float64)

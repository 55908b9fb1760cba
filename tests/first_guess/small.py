"""A small training set without a planner."""

from __future__ import annotations

from typing import Any

from hotlap.first_guess.features import OF_A_PIECE, OF_A_RACE
from hotlap.first_guess.training_set import TrainingPiece, TrainingRace, TrainingSet
from hotlap.reference.segments import SegmentClass

NAMES = ("Q_pos_xy", "Q_pos_z", "Q_attitude", "Q_velocity", "horizon")
DEFAULT = (200.0, 500.0, 50.0, 10.0, 4.0)
GOOD, OTHER = (40.0, 300.0, 30.0, 7.0, 5.0), (100.0, 200.0, 20.0, 20.0, 2.0)
HERE = (2.0, 0.0, 0.1, 0.0, 10.0)  # features of a race
AWAY = (3.0, 0.05, 0.1, 1.0, 20.0)
RACE_FEATURES = (*OF_A_RACE, "mean_speed")


def make_piece(kind: SegmentClass = SegmentClass.FLAT, **features: float) -> TrainingPiece:
    return TrainingPiece(kind=kind, features=tuple(features.get(name, 1.0) for name in OF_A_PIECE))


def make_race(track: str, passed: str, **changes: Any) -> TrainingRace:
    """A race in which each candidate passed all gates so often."""
    plain = {"track": track, "vehicle": "box", "v_max": 20.0, "features": HERE, "pieces": (make_piece(),), "tuned": GOOD}
    plain |= {"validated": 1.0, "own": (), "passed": passed, "completed": passed}
    return TrainingRace(**{**plain, **changes})


def make_set(*races: TrainingRace, candidates: tuple[tuple[float, ...], ...] = (DEFAULT, GOOD, OTHER), **changes: Any) -> TrainingSet:
    plain = {"provenance": {"hotlap": "0"}, "names": NAMES, "horizon_unit": 0.5, "flights": 8, "candidates": candidates}
    plain |= {"piece_features": tuple(OF_A_PIECE), "race_features": RACE_FEATURES, "races": races}
    return TrainingSet(**{**plain, **changes})

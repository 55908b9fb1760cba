"""Configuration: everything that decides about a tuning, in a form that can be kept and compared."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from hotlap import tuners
from hotlap.core.errors import InputError
from hotlap.core.parameters import Parameters
from hotlap.core.shown import Shown
from hotlap.files.error_messages import check
from hotlap.race.race import Race
from hotlap.reference.reference import Reference
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentClass, Segments
from hotlap.tuners import Tuner
from hotlap.tuners.contest import beginning_at_better
from hotlap.tuning.goal import parse_goal
from hotlap.tuning.loop import TuningSettings
from hotlap.tuning.scoring import Metric

GIVEN = "given"  # name of a first guess that a program passed as numbers
MAY_DIFFER = ("budget", "selection", "minutes", "first_guess_name", "rival", "race.planning.dynamics")
"""A study may be given a larger budget, other flights to choose its result by, and other minutes, and goes on with the rival that it has.
Of a first guess the numbers are compared, and of a plan the reference, however they were found."""
FORMER: Mapping[str, Any] = {"lag_lead": 0.0, "offset_free": False, "reference_drag": False}
"""Keys of the controller that studies of earlier versions do not have, with the values by which those were flown."""


@dataclass(frozen=True, repr=False)
class Configuration(Shown):
    """What is tuned in a study, and how.

    Attributes:
        scenario: race, reference and segments.
        world: name of the world.
        metric: what the cost measures.
        tuner: name with preset.
        settings: goal, budget, seed and the like.
        first_guess: shape (S, K).
        cost: of one's own, as `Objective.own_cost` names it; "" where the metric's counts.
        first_guess_name: where the first guess comes from: "learned", "paper", "default", a path, or `GIVEN`.
        rival: shape (S, K), another guess that is flown against the first before the search begins at the better one; None for none.
    """

    scenario: Scenario
    world: str
    metric: Metric
    tuner: str
    settings: TuningSettings
    first_guess: Parameters
    cost: str = ""
    first_guess_name: str = GIVEN
    rival: Parameters | None = None

    def build_tuner(self) -> Tuner:
        """The tuner, not yet started."""
        return beginning_at_better(tuners.build(self.tuner), self.rival)

    @property
    def cost_name(self) -> str:
        """Label of an axis of the cost: with its unit where it is the metric's, else the name of the function."""
        if self.cost:
            return f"cost, {self.cost.partition(' ')[0].rpartition('.')[2]}"
        return self.metric_name

    @property
    def metric_name(self) -> str:
        """Label of an axis of the metric, whatever counts as the cost: with its unit."""
        return "cost [s]" if self.metric is Metric.TIME else "cost [m]"

    @property
    def fingerprint(self) -> str:
        """Sixteen hexadecimal digits that change with everything that must be the same throughout a study."""
        text = json.dumps(sorted(compared(self.dump()).items()))
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def dump(self) -> dict[str, Any]:
        """As plain JSON; the reference by its fingerprint."""
        segments, tuner = self.scenario.segments, tuners.build(self.tuner)
        return {
            "tuner": {"name": tuner.name, **asdict(tuner.settings)},  # first: it decides about the race's fly_on
            "race": self.scenario.race.model_dump(mode="json"),
            "reference": fingerprint_reference(self.scenario.reference),
            "segments": _dump_segments(segments),
            "world": self.world,
            "metric": self.metric,
            **{field.name: getattr(self.settings, field.name) for field in fields(TuningSettings) if field.name != "goal"},
            "goal": str(self.settings.goal),
            "first_guess": self.first_guess.tolist(),
            "first_guess_name": self.first_guess_name,
            "rival": None if self.rival is None else self.rival.tolist(),
            "cost": self.cost,
        }


def load_configuration(plain: Mapping[str, Any], reference: Reference) -> Configuration:
    """The inverse of `Configuration.dump`, given the reference.

    Raises:
        InputError: the race is none that this version knows.
    """
    scenario = Scenario(_load_race(plain["race"]), reference, _load_segments(plain["segments"]))
    return Configuration(
        scenario=scenario,
        world=_text(plain, "world"),
        metric=Metric(plain["metric"]),
        tuner=_text(plain["tuner"], "name"),
        settings=TuningSettings(goal=parse_goal(_text(plain, "goal")), **_numbers(plain)),
        first_guess=_load_guess(plain["first_guess"], scenario),
        cost=_text(plain, "cost"),
        first_guess_name=_text(plain, "first_guess_name"),
        rival=load_rival(plain),
    )


def _load_guess(plain: Any, scenario: Scenario) -> Parameters:
    """The first guess of a dump, with as many numbers as the scenario asks for."""
    guess, shape = np.array(plain, dtype=np.float64), (len(scenario.segments), scenario.space.size)
    if guess.shape != shape:
        raise InputError("", "first_guess", f"must have {shape[0]} rows of {shape[1]} numbers")
    return guess


def _text(plain: Mapping[str, Any], key: str) -> str:
    """A value of a dump that has to be text."""
    if not isinstance(plain[key], str):
        raise InputError("", key, "must be text")
    return plain[key]


def _numbers(plain: Mapping[str, Any]) -> dict[str, Any]:
    """The settings of a dump that are numbers; 0 where an earlier version knew none."""
    numbers = {one.name: plain.get(one.name, 0) for one in fields(TuningSettings) if one.name != "goal"}
    for key, value in numbers.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError("", key, "must be a number")
    return numbers


def load_rival(plain: Mapping[str, Any]) -> Parameters | None:
    """The rival of the first guess in a dump; studies of earlier versions have none."""
    rival = plain.get("rival")
    return None if rival is None else np.array(rival, dtype=np.float64)


def _load_race(plain: Mapping[str, Any]) -> Race:
    """The race of a dump, which an earlier version may have written."""
    return check(Race, {**plain, "controller": {**FORMER, **plain.get("controller", {})}}, source="", prefix="race")


def compared(plain: Mapping[str, Any]) -> dict[str, Any]:
    """Dotted keys and values of a dump, without those that may differ between runs of one study.

    Keys that a dump of an earlier version does not have get their defaults, or the values of `FORMER`.
    """
    with suppress(InputError):
        plain = {**plain, "race": _load_race(plain["race"]).model_dump(mode="json")}
    flat = dict(_flatten(json.loads(json.dumps(plain)), ""))
    return {key: value for key, value in flat.items() if key not in MAY_DIFFER and not _is_provenance(key)}


def _is_provenance(key: str) -> bool:
    """Whether a dotted key says where numbers of the race come from, which changes no flight."""
    path = key.split(".")
    return path[0] == "race" and path[-1] == "provenance"


def first_difference(stored: Mapping[str, Any], asked: Mapping[str, Any]) -> tuple[str, Any, Any] | None:
    """Dotted key and both values of the first difference between two dumps, or None."""
    mine, theirs = compared(stored), compared(asked)
    for key in {**mine, **theirs}:
        if mine.get(key) != theirs.get(key):
            return key, mine.get(key), theirs.get(key)
    return None


def fingerprint_reference(reference: Reference) -> str:
    """Sixteen hexadecimal digits of everything in a reference that a flight depends on."""
    digest = hashlib.sha256()
    for values in (reference.table, reference.gate_times, np.array([reference.duration, reference.period])):
        digest.update(np.ascontiguousarray(values, dtype="<f8").tobytes())
    return digest.hexdigest()[:16]


def pack_reference(reference: Reference) -> bytes:
    """A reference as one compressed block, bit for bit."""
    block = io.BytesIO()
    arrays: dict[str, Any] = {name: np.asarray(values) for name, values in vars(reference).items()}
    np.savez_compressed(block, **arrays)
    return block.getvalue()


def unpack_reference(block: bytes) -> Reference:
    """The inverse of `pack_reference`."""
    with np.load(io.BytesIO(block), allow_pickle=False) as arrays:
        values: dict[str, Any] = {name: arrays[name] if arrays[name].ndim else float(arrays[name]) for name in arrays.files}
    return Reference(**values)


def _dump_segments(segments: Segments) -> dict[str, Any]:
    """As plain JSON."""
    return {
        "starts": segments.starts.tolist(),
        "classes": list(segments.classes),
        "duration": segments.duration,
        "owners": list(segments.owners),
    }


def _load_segments(plain: Mapping[str, Any]) -> Segments:
    """The inverse of `_dump_segments`."""
    classes = tuple(SegmentClass(name) for name in plain["classes"])
    return Segments(np.array(plain["starts"]), classes, plain["duration"], tuple(plain["owners"]))


def _flatten(value: Any, key: str) -> Iterator[tuple[str, Any]]:
    """Leaves of nested tables; lists are leaves, so that a message shows them whole."""
    if isinstance(value, dict):
        for name, item in value.items():
            yield from _flatten(item, f"{key}.{name}" if key else name)
    else:
        yield key, value

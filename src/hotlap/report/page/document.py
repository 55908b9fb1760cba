"""Document: a study as plain JSON, in the form that the page reads (format 1)."""

from __future__ import annotations

import re
from typing import Any

from hotlap import toml
from hotlap.analysis.hold import Hold
from hotlap.check import mistaken
from hotlap.files import PARAMETERS_FILE
from hotlap.report.history import collect, succeeded
from hotlap.report.page.encoding import number, pack
from hotlap.report.page.flown import describe_course, describe_repeats, describe_trace
from hotlap.report.page.shown import Shown
from hotlap.report.page.standing import Standing, begins_at_default
from hotlap.seeds import Stream
from hotlap.validation import Validation

FORMAT = 1
MOST_SAMPLES, MOST_VALUES = 2000, 150_000  # rows, and numbers in them
SYMBOLS = {  # letters of the paper, where it has them
    "Q_pos_xy": "Q_xy",
    "Q_pos_z": "Q_z",
    "Q_attitude": "Q_q",
    "Q_velocity": "Q_v",
    "horizon": "T",
}
STREAMS = (Stream.SEARCH, Stream.CONFIRMATION, Stream.VALIDATION)


def describe(standing: Standing, shown: Shown | None, *, live: bool = False) -> dict[str, Any]:
    """Everything that the page shows.

    Args:
        standing: of the study.
        shown: what was flown again; None: nothing yet.
        live: whether the page is to ask for more.
    """
    traces = [] if shown is None else [describe_trace(*both) for both in zip(shown.scene.traces, shown.efforts, strict=True)]
    return {
        "format": FORMAT,
        "kind": "study",
        "live": live,
        "headline": _headline(standing),
        "course": describe_course(standing.configuration.course),
        "traces": traces,
        "repeats": [] if shown is None else [describe_repeats(repeats) for repeats in shown.scene.repeats],
        "flights": _flights(standing),
        "parameters": _parameters(standing),
        "samples": _samples(standing),
        "sensitivity": _sensitivity(shown),
        "hold": [] if shown is None else [_hold(hold) for hold in shown.holds],
        "configuration": _configuration(standing),
    }


def _headline(standing: Standing) -> dict[str, Any]:
    """The answer to: did it work?"""
    asked, result = standing.configuration, standing.result
    race, settings = asked.course.race, asked.settings
    known = race.believed.delay if race.controller.predict else 0.0
    return {
        "race": race.name,
        "vehicle": race.vehicle.name,
        "model": race.believed.name,
        "latency_unknown": round(race.vehicle.delay - known, 6),
        "mistaken": [name for name in mistaken(race) if name != "delay"],
        "tuner": asked.tuner,
        "goal": str(settings.goal),
        "seed": settings.seed,
        "first_guess": first_guess_of(standing),
        "state": "finished" if standing.finished else "running",
        "flights": 0 if result is None else result.flights,
        "search_flights": 0 if result is None else result.search_flights,
        "budget": settings.budget,
        "lap_time": None if result is None else number(result.best.lap_time),
        "planned_lap_time": number(asked.course.reference.lap_time),
        "completion": None if result is None else number(result.best.completion),
        "confirmed": result is not None and result.best.confirmed,
        "confirm": settings.confirm,
        "validation": None if result is None or result.validation is None else _validation(result.validation),
        "wall_time": None if result is None else number(result.wall_time),
        "remark": "" if result is None else result.remark,
    }


def first_guess_of(standing: Standing) -> str:
    """What the search began with, in a word."""
    if begins_at_default(standing.configuration):
        return "default"
    given = re.search(r" --first-guess[ =](\S+)", standing.command)
    return given[1] if given else "learned"


def _validation(validation: Validation) -> dict[str, Any]:
    low, high = validation.interval
    return {"flights": validation.flights, "successes": validation.successes, "rate": validation.rate, "low": low, "high": high}


def _hold(hold: Hold) -> dict[str, Any]:
    return {"change": hold.change, **_validation(hold.validation)}


def _flights(standing: Standing) -> dict[str, Any]:
    """Every flight, in the order of the ledger."""
    ledger, settings = standing.ledger, standing.configuration.settings
    return {
        "number": pack(ledger.numbers + 1),
        "cost": pack(ledger.cost),
        "completion": pack(ledger.completion),
        "mean_error": pack(ledger.mean_error),
        "lap_time": pack(ledger.lap_time),
        "stream": [STREAMS.index(Stream(stream)) for stream in ledger.streams.tolist()],
        "accepted": ledger.accepted.astype(int).tolist(),
        "succeeded": succeeded(ledger, settings.goal).astype(int).tolist(),
        "failed_segment": ledger.failed_segment.tolist(),
        "cost_name": standing.configuration.cost_name,
    }


def _parameters(standing: Standing) -> dict[str, Any]:
    """What was tuned, from where to where."""
    course, first = standing.configuration.course, standing.configuration.first_guess
    space, unit = course.space, course.race.controller.horizon_unit
    return {
        "names": list(space.names),
        "symbols": [SYMBOLS.get(name, name) for name in space.names],
        "units": [f"{unit:g} s" if name == "horizon" else "" for name in space.names],
        "low": pack(space.low),
        "high": pack(space.high),
        "default": pack(space.first_guess(len(first))),
        "first": pack(first),
        "best": pack(standing.best),
    }


def _samples(standing: Standing) -> dict[str, Any]:
    """Parameters of the search flights, thinned evenly where there are many."""
    most = max(1, min(MOST_SAMPLES, MOST_VALUES // max(1, standing.configuration.first_guess.size)))
    samples = collect(standing.ledger, standing.configuration.settings.goal, most)
    return {
        "parameters": pack(samples.parameters),
        "accepted": samples.accepted.astype(int).tolist(),
        "completion": pack(samples.completion),
        "succeeded": samples.succeeded.astype(int).tolist(),
        "of": int((standing.ledger.streams == int(Stream.SEARCH)).sum()),
    }


def _sensitivity(shown: Shown | None) -> dict[str, Any] | None:
    """How much each parameter matters."""
    if shown is None or shown.sensitivity is None:
        return None
    found = shown.sensitivity
    arrays = {name: pack(getattr(found, name)) for name in ("completion", "complete", "by_segment")}
    return {"factors": found.factors.tolist(), "flights": found.flights, **arrays}


def _configuration(standing: Standing) -> dict[str, Any]:
    """What it takes to do the same again."""
    asked = standing.configuration
    plain, race = asked.dump(), asked.course.race
    tuner = {f"tuner.{key}": value for key, value in plain["tuner"].items()}
    settings = {key: value for key, value in plain.items() if key not in {"tuner", "race", "segments", "first_guess"}}
    return {
        "command": standing.command,
        "fingerprint": asked.fingerprint,
        "versions": dict(standing.openings[-1][1]) if standing.openings else {},
        "opened": [moment for moment, _ in standing.openings],
        "race_toml": toml.write(race.model_dump(mode="json", exclude_none=True)),
        "settings": {**tuner, **settings},
        "world": asked.world,
        "files": {"study": str(standing.folder), "parameters": str(standing.folder / PARAMETERS_FILE)},
    }

"""Document: a study as plain JSON, in the form that the page reads (format 1)."""

from __future__ import annotations

from typing import Any

from hotlap.analysis.robustness import Robustness
from hotlap.core.seeds import Stream
from hotlap.core.success_rate import Validation
from hotlap.files import toml_writer
from hotlap.files.descriptions import PARAMETERS_FILE
from hotlap.planning.feasibility import mistaken
from hotlap.report.history import collect, succeeded
from hotlap.report.page.encoding import number, pack
from hotlap.report.page.flown import describe_repeats, describe_scenario, describe_trace
from hotlap.report.page.replay import Replay
from hotlap.study.snapshot import Snapshot

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


def describe(snapshot: Snapshot, replay: Replay | None, *, live: bool = False) -> dict[str, Any]:
    """Everything that the page shows.

    Args:
        snapshot: of the study.
        replay: what was flown again; None: nothing yet.
        live: whether the page is to ask for more.
    """
    traces = [] if replay is None else [describe_trace(*both) for both in zip(replay.scene.traces, replay.efforts, strict=True)]
    return {
        "format": FORMAT,
        "kind": "study",
        "live": live,
        "headline": _headline(snapshot),
        "scenario": describe_scenario(snapshot.configuration.scenario),
        "traces": traces,
        "repeats": [] if replay is None else [describe_repeats(repeats) for repeats in replay.scene.repeats],
        "flights": _flights(snapshot),
        "parameters": _parameters(snapshot),
        "samples": _samples(snapshot),
        "sensitivity": _sensitivity(replay),
        "hold": [] if replay is None else [_hold(hold) for hold in replay.holds],
        "configuration": _configuration(snapshot),
    }


def _headline(snapshot: Snapshot) -> dict[str, Any]:
    """The answer to: did it work?"""
    asked, result = snapshot.configuration, snapshot.result
    race, settings = asked.scenario.race, asked.settings
    known = race.control_model.delay if race.controller.predict else 0.0
    return {
        "race": race.name,
        "vehicle": race.vehicle.name,
        "model": race.control_model.name,
        "latency_unknown": round(race.vehicle.delay - known, 6),
        "mistaken": [name for name in mistaken(race) if name != "delay"],
        "tuner": asked.tuner,
        "goal": str(settings.goal),
        "seed": settings.seed,
        "first_guess": asked.first_guess_name,
        "state": "finished" if snapshot.finished else "running",
        "flights": 0 if result is None else result.flights,
        "search_flights": 0 if result is None else result.search_flights,
        "budget": settings.budget,
        "lap_time": None if result is None else number(result.best.lap_time),
        "planned_lap_time": number(asked.scenario.reference.lap_time),
        "completion": None if result is None else number(result.best.completion),
        "confirmed": result is not None and result.best.confirmed,
        "confirm": settings.confirm,
        "validation": None if result is None or result.validation is None else _validation(result.validation),
        "wall_time": None if result is None else number(result.wall_time),
        "remark": "" if result is None else result.remark,
    }


def _validation(validation: Validation) -> dict[str, Any]:
    low, high = validation.interval
    return {"flights": validation.flights, "successes": validation.successes, "rate": validation.rate, "low": low, "high": high}


def _hold(hold: Robustness) -> dict[str, Any]:
    return {"change": hold.change, **_validation(hold.validation)}


def _flights(snapshot: Snapshot) -> dict[str, Any]:
    """Every flight, in the order of the ledger."""
    ledger, settings = snapshot.ledger, snapshot.configuration.settings
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
        "cost_name": snapshot.configuration.cost_name,
    }


def _parameters(snapshot: Snapshot) -> dict[str, Any]:
    """What was tuned, from where to where."""
    scenario, first = snapshot.configuration.scenario, snapshot.configuration.first_guess
    space, unit = scenario.space, scenario.race.controller.horizon_unit
    return {
        "names": list(space.names),
        "symbols": [SYMBOLS.get(name, name) for name in space.names],
        "units": [f"{unit:g} s" if name == "horizon" else "" for name in space.names],
        "low": pack(space.low),
        "high": pack(space.high),
        "default": pack(space.first_guess(len(first))),
        "first": pack(first),
        "best": pack(snapshot.best),
    }


def _samples(snapshot: Snapshot) -> dict[str, Any]:
    """Parameters of the search flights, thinned evenly where there are many."""
    most = max(1, min(MOST_SAMPLES, MOST_VALUES // max(1, snapshot.configuration.first_guess.size)))
    samples = collect(snapshot.ledger, snapshot.configuration.settings.goal, most)
    return {
        "parameters": pack(samples.parameters),
        "accepted": samples.accepted.astype(int).tolist(),
        "completion": pack(samples.completion),
        "succeeded": samples.succeeded.astype(int).tolist(),
        "of": int((snapshot.ledger.streams == int(Stream.SEARCH)).sum()),
    }


def _sensitivity(replay: Replay | None) -> dict[str, Any] | None:
    """How much each parameter matters."""
    if replay is None or replay.sensitivity is None:
        return None
    found = replay.sensitivity
    arrays = {name: pack(getattr(found, name)) for name in ("completion", "complete", "by_segment")}
    return {"factors": found.factors.tolist(), "flights": found.flights, **arrays}


def _configuration(snapshot: Snapshot) -> dict[str, Any]:
    """What it takes to do the same again."""
    asked = snapshot.configuration
    plain, race = asked.dump(), asked.scenario.race
    tuner = {f"tuner.{key}": value for key, value in plain["tuner"].items()}
    settings = {key: value for key, value in plain.items() if key not in {"tuner", "race", "segments", "first_guess"}}
    return {
        "command": snapshot.command,
        "fingerprint": asked.fingerprint,
        "versions": dict(snapshot.openings[-1][1]) if snapshot.openings else {},
        "opened": [moment for moment, _ in snapshot.openings],
        "race_toml": toml_writer.write(race.model_dump(mode="json", exclude_none=True)),
        "settings": {**tuner, **settings},
        "world": asked.world,
        "files": {"study": str(snapshot.folder), "parameters": str(snapshot.folder / PARAMETERS_FILE)},
    }

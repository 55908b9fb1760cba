"""Document: everything that the page shows of a study, as plain JSON (format 1); `page/src/data.ts` declares the same keys."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from hotlap.analysis.remedies import failures_of, what_to_try
from hotlap.analysis.robustness import Robustness
from hotlap.core.seeds import Stream
from hotlap.core.success_rate import Validation, wilson_interval
from hotlap.feasibility.race import mistaken
from hotlap.files.descriptions import PARAMETERS_FILE, to_toml, write_parameters
from hotlap.files.parameters_file import SavedParameters
from hotlap.race.race import GateRule
from hotlap.reference.scenario import Scenario
from hotlap.report.effort import Effort
from hotlap.report.history import CHAINS, collect, succeeded, verdicts, with_parameters
from hotlap.report.page.packing import number, numbers, pack, thin
from hotlap.report.page.replay import BEST, DEFAULT, FIRST, Replay
from hotlap.report.page.standing import dump_structures
from hotlap.report.response import respond
from hotlap.report.scene import Repeats, Trace
from hotlap.study.kept_guess import find_kept_guess
from hotlap.study.snapshot import Snapshot
from hotlap.tuning.goal import Quantity

FORMAT = 1
MOST_SAMPLES, MOST_VALUES = 2000, 150_000  # search flights whose parameters are sent, and numbers in them
IDS = {BEST: "best", FIRST: "first", DEFAULT: "default"}  # of the sets of parameters in the page
SYMBOLS = {  # letters of the paper, where it has them
    "Q_pos_xy": "Q_xy",
    "Q_pos_z": "Q_z",
    "Q_attitude": "Q_q",
    "Q_velocity": "Q_v",
    "horizon": "T",
}
RULES = {GateRule.CLOCK: "clock", GateRule.OPENING: "opening"}
TELLS = ("flat", "cost_tells", "cost_tells_by_segment")  # what of a sensitivity is shown
STREAMS = {Stream.SEARCH: 0, Stream.CONFIRMATION: 1, Stream.VALIDATION: 2, Stream.SELECTION: 2}  # the page shows no flight of 2


def dump_study(snapshot: Snapshot, replay: Replay | None, *, live: bool = False) -> dict[str, Any]:
    """The whole document.

    Args:
        snapshot: of the study.
        replay: the flights of the page; None: nothing was flown again yet.
        live: whether the page asks a server for news.
    """
    traces = [] if replay is None else [dump_trace(*both) for both in zip(replay.scene.traces, replay.efforts, strict=True)]
    return {
        "format": FORMAT,
        "kind": "study",
        "live": live,
        "headline": _headline(snapshot, replay),
        "scenario": dump_scenario(snapshot.configuration.scenario),
        "traces": traces,
        "repeats": [] if replay is None else [dump_repeats(repeats) for repeats in replay.scene.repeats],
        "flights": _flights(snapshot),
        "parameters": _parameters(snapshot),
        "samples": _samples(snapshot),
        "sensitivity": _sensitivity(replay, snapshot.configuration.metric_name),
        "robustness": [] if replay is None else [_robustness(change) for change in replay.robustness],
        "advice": [] if replay is None else list(what_to_try(failures_of(replay.robustness), snapshot.advice)),
        "configuration": _configuration(snapshot),
    }


def _headline(snapshot: Snapshot, replay: Replay | None) -> dict[str, Any]:
    """The result in short: race, goal, lap time, gates passed, success rate."""
    asked, result = snapshot.configuration, snapshot.result
    race, settings = asked.scenario.race, asked.settings
    known = race.control_model.delay if race.controller.predict else 0.0
    guess = find_kept_guess(asked, result, None if replay is None else replay.errors)
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
        "kept": _kept(snapshot),
        "kept_guess": None if guess is None else guess.words,
        "validation": None if result is None or result.validation is None else _validation(result.validation),
        "wall_time": None if result is None else number(result.wall_time),
        "remark": snapshot.remark,
        "plans": [plan.dump() for plan in snapshot.plans],
    }


def _kept(snapshot: Snapshot) -> dict[str, Any]:
    """How many flights the figures of the tuned parameters are means over, their mean cost, and how many more chose among candidates."""
    result = snapshot.result
    if result is None:
        return {"flights": 0, "cost": None, "selection_flights": 0}
    return {"flights": result.best.flights, "cost": number(result.best.cost), "selection_flights": result.selection_flights}


def _validation(validation: Validation) -> dict[str, Any]:
    low, high = validation.interval
    return {"flights": validation.flights, "successes": validation.successes, "rate": validation.rate, "low": low, "high": high}


def _robustness(robustness: Robustness) -> dict[str, Any]:
    return {"change": robustness.change, "asked": robustness.asked, **_validation(robustness.validation), **_reasons(robustness)}


def _reasons(robustness: Robustness) -> dict[str, Any]:
    """What is left of the thrust under a condition, and why flights fail."""
    margin = robustness.margin
    left = None if margin is None else {"thrust": margin.thrust, "rates": margin.rates, "place": margin.place}
    return {"margin": left, "causes": [cause.dump() for cause in robustness.causes]}


def _flights(snapshot: Snapshot) -> dict[str, Any]:
    """Score of every flight, in the order of the ledger."""
    ledger, settings = snapshot.ledger, snapshot.configuration.settings
    return {
        "number": pack(ledger.numbers + 1),
        "cost": pack(ledger.cost),
        "completion": pack(ledger.completion),
        "mean_error": pack(ledger.mean_error),
        "lap_time": pack(ledger.lap_time),
        "stream": [STREAMS[Stream(stream)] for stream in ledger.streams.tolist()],
        "accepted": ledger.accepted.astype(int).tolist(),
        "succeeded": succeeded(ledger, settings.goal).astype(int).tolist(),
        "tuned": with_parameters(ledger, snapshot.best).astype(int).tolist(),
        "chain": _is_chain(snapshot),
        "verdicts": list(verdicts(goal=settings.goal.quantity is not Quantity.NONE)),
        "failed_segment": ledger.failed_segment.tolist(),
        "cost_name": snapshot.configuration.cost_name,
    }


def _is_chain(snapshot: Snapshot) -> bool:
    """Whether what the tuner accepts says where it goes on from."""
    return snapshot.configuration.tuner.partition(":")[0] in CHAINS


def _parameters(snapshot: Snapshot) -> dict[str, Any]:
    """The tunable parameters: names, bounds, default, first guess and best."""
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
        "chain": _is_chain(snapshot),
        "verdicts": list(verdicts(goal=samples.goal)),
        "of": int((snapshot.ledger.streams == int(Stream.SEARCH)).sum()),
    }


def _sensitivity(replay: Replay | None, cost_name: str) -> dict[str, Any] | None:
    """How completion and cost change when one parameter is multiplied by a factor."""
    if replay is None or replay.sensitivity is None:
        return None
    found = replay.sensitivity
    arrays = {name: pack(getattr(found, name)) for name in ("completion", "complete", "by_segment", "cost", "cost_by_segment")}
    return {
        "factors": found.factors.tolist(),
        "flights": found.flights,
        "cost_name": cost_name,
        **arrays,
        **{name: getattr(found, name) for name in TELLS},
    }


def _configuration(snapshot: Snapshot) -> dict[str, Any]:
    """What is needed to repeat the study: command, seed, versions, settings."""
    asked = snapshot.configuration
    plain, race = asked.dump(), asked.scenario.race
    tuner = {f"tuner.{key}": value for key, value in plain["tuner"].items()}
    settings = {key: value for key, value in plain.items() if key not in {"tuner", "race", "segments", "first_guess", "rival"}}
    return {
        "command": snapshot.command,
        "fingerprint": asked.fingerprint,
        "versions": dict(snapshot.openings[-1][1]) if snapshot.openings else {},
        "opened": [moment for moment, _ in snapshot.openings],
        "race_toml": to_toml(race),
        "parameters_toml": _parameters_toml(snapshot),
        "settings": {**tuner, **settings},
        "world": asked.world,
        "files": {"study": str(snapshot.folder), "parameters": str(snapshot.folder / PARAMETERS_FILE)},
    }


def _parameters_toml(snapshot: Snapshot) -> str:
    """The tuned parameters as they lie beside the page; while the search runs those so far, without their provenance."""
    file, scenario = snapshot.folder / PARAMETERS_FILE, snapshot.configuration.scenario
    if snapshot.finished and file.is_file():
        return file.read_text(encoding="utf-8")
    return write_parameters(SavedParameters(scenario.race.name, scenario.space.names, scenario.segments, snapshot.best))


def dump_scenario(scenario: Scenario) -> dict[str, Any]:
    """Gates, segments, reference, limits of the inputs, and rotor positions."""
    race, segments = scenario.race, scenario.segments
    pieces = [{"class": str(piece.kind), "start": piece.start, "end": piece.end, "segment": piece.segment} for piece in segments.pieces]
    vehicle, settings = race.vehicle, race.controller
    return {
        "duration": float(scenario.reference.duration),
        "lap_time": scenario.reference.lap_time,
        "gate_distance": race.judge.distance,
        "rule": RULES.get(race.judge.rule, "approach"),
        "floor": race.track.floor,
        **dump_structures(scenario),
        "gates": pack(race.track.gate_positions),
        "gate_numbers": list(race.track.gate_numbers),
        "gate_times": pack(scenario.reference.gate_times),
        "gate_segments": scenario.gate_segments.tolist(),
        "pieces": pieces,
        "segment_names": [f"{i + 1} {kind}" for i, kind in enumerate(segments.segment_classes)],
        "reference": _reference(scenario),
        "limits": {"thrust": list(scenario.thrust_limits), "rates": list(settings.rates), "rotor_thrust": list(vehicle.rotor_thrust)},
        "rotors": vehicle.rotor_positions.tolist(),
    }


def _reference(scenario: Scenario) -> dict[str, Any]:
    """The planned states and inputs, without the rows after the end of the plan."""
    reference, planned = scenario.reference, scenario.reference.planned_rows
    rows = slice(0, planned, thin(planned).step)
    arrays = {name: getattr(reference, name)[rows] for name in ("position", "attitude", "thrust", "rates")}
    speed = np.linalg.norm(reference.velocity[rows], axis=1)
    return {name: pack(values) for name, values in {"time": reference.times[rows], "speed": speed, **arrays}.items()}


def _estimates(trace: Trace, rows: slice) -> dict[str, Any]:
    """What the controller has estimated: thrust effectiveness, and the size of the disturbance; None where it estimates nothing."""
    if trace.estimates is None:
        return {"thrust_effectiveness": None, "disturbance": None}
    size = np.linalg.norm(trace.estimates[rows, 1:], axis=1)
    return {"thrust_effectiveness": pack(trace.estimates[rows, 0]), "disturbance": pack(size)}


def dump_trace(trace: Trace, efforts: tuple[Effort, Effort]) -> dict[str, Any]:
    """One flight in full: time series up to its end, distances from the gates, and its effort beside that of the reference."""
    rows = thin(len(trace.times))
    series = {
        "time": trace.times,
        "position": trace.position,
        "attitude": trace.attitude,
        "speed": trace.speed,
        "error": trace.error,
        "rates": trace.rates,
        "rotor_thrusts": trace.rotor_thrusts,
        "command_thrust": trace.commands[:, 0],
        "command_rates": trace.commands[:, 1:],
    }
    own, reference = map(_effort, efforts)
    return {
        "id": IDS.get(trace.label, trace.label),
        "label": trace.label,
        "ending": trace.ending,
        "failed": trace.failed,
        "seed": trace.seed,
        "lap_time": number(trace.lap_time),
        "end_time": number(trace.end_time),
        "end_position": numbers(trace.end_position),
        **{name: pack(values[rows]) for name, values in series.items()},
        **_estimates(trace, rows),
        "gate_distance": pack(trace.gate_distance),
        "seen_times": pack(trace.seen_times),
        "effort": {**own, "reference": reference},
        "response": _response(trace),
    }


def _response(trace: Trace) -> dict[str, Any] | None:
    """Spectrum and step response of the rate commands; None where the flight is too short."""
    found = respond(trace)
    return None if found is None else {name: pack(values) for name, values in vars(found).items()}


def _effort(effort: Effort) -> dict[str, Any]:
    return {
        "thrust_activity": effort.thrust_activity,
        "rate_activity": effort.rate_activity,
        "saturated": effort.saturated,
        "oscillation": {"frequency": effort.frequency or None, "share": effort.share},
    }


def dump_repeats(repeats: Repeats) -> dict[str, Any]:
    """Success rate of flights with the same parameters, and where and how the others failed."""
    low, high = wilson_interval(repeats.complete, repeats.flights)
    return {
        "id": IDS.get(repeats.label, repeats.label),
        "label": repeats.label,
        "flights": repeats.flights,
        "complete": repeats.complete,
        "low": low,
        "high": high,
        "failures": pack(repeats.failures.reshape(-1, 3)),
        "failed_gates": repeats.failed_gates.tolist(),
        "ends": list(repeats.ends),
    }


def write_json(document: dict[str, Any]) -> str:
    """The document as one line of JSON that may stand inside an HTML element: it contains no `<`."""
    return (
        json.dumps(document, allow_nan=False, separators=(",", ":"), ensure_ascii=False)
        .replace("<", "\\u003c")
        .encode("utf-8", "replace")
        .decode()
    )

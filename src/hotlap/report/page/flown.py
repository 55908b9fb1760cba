"""Flown: a scenario and its flights as plain JSON."""

from __future__ import annotations

from typing import Any

import numpy as np

from hotlap.core.success_rate import wilson_interval
from hotlap.race.race import GateRule
from hotlap.reference.scenario import Scenario
from hotlap.report.demonstration import BEST, DEFAULT, FIRST
from hotlap.report.effort import Effort
from hotlap.report.page.encoding import number, numbers, pack, thin
from hotlap.report.scene import Repeats, Trace

IDS = {BEST: "best", FIRST: "first", DEFAULT: "default"}  # as the page knows them


def describe_scenario(scenario: Scenario) -> dict[str, Any]:
    """Gates, segments, reference and limits."""
    race, segments = scenario.race, scenario.segments
    pieces = [{"class": str(piece.kind), "start": piece.start, "end": piece.end, "segment": piece.segment} for piece in segments.pieces]
    vehicle, settings = race.vehicle, race.controller
    return {
        "duration": float(scenario.reference.duration),
        "lap_time": scenario.reference.lap_time,
        "gate_distance": race.judge.distance,
        "rule": "clock" if race.judge.rule is GateRule.CLOCK else "approach",
        "floor": race.track.floor,
        "gates": pack(race.track.gate_positions),
        "gate_times": pack(scenario.reference.gate_times),
        "gate_segments": scenario.gate_segments.tolist(),
        "pieces": pieces,
        "segment_names": [f"{i + 1} {kind}" for i, kind in enumerate(segments.segment_classes)],
        "reference": _reference(scenario),
        "limits": {"thrust": list(settings.thrust), "rates": list(settings.rates), "rotor_thrust": list(vehicle.rotor_thrust)},
        "arm": vehicle.arm,
        "layout": str(vehicle.layout),
    }


def _reference(scenario: Scenario) -> dict[str, Any]:
    """The planned rows."""
    reference, planned = scenario.reference, scenario.reference.planned_rows
    rows = slice(0, planned, thin(planned).step)
    arrays = {name: getattr(reference, name)[rows] for name in ("position", "attitude", "thrust", "rates")}
    speed = np.linalg.norm(reference.velocity[rows], axis=1)
    return {name: pack(values) for name, values in {"time": reference.times[rows], "speed": speed, **arrays}.items()}


def describe_trace(trace: Trace, efforts: tuple[Effort, Effort]) -> dict[str, Any]:
    """One flight in full."""
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
        "gate_distance": pack(trace.gate_distance),
        "seen_times": pack(trace.seen_times),
        "effort": {**own, "reference": reference},
    }


def _effort(effort: Effort) -> dict[str, Any]:
    return {
        "thrust_activity": effort.thrust_activity,
        "rate_activity": effort.rate_activity,
        "saturated": effort.saturated,
        "oscillation": {"frequency": effort.frequency or None, "share": effort.share},
    }


def describe_repeats(repeats: Repeats) -> dict[str, Any]:
    """How flights with the same parameters ended."""
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
        "ends": ["crashed" if crashed else "missed" for crashed in repeats.crashed.tolist()],
    }

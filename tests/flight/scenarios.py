"""A small scenario without a planner: a circle flown ever faster, whose reference follows from its own acceleration."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from hotlap.core.records import Flights
from hotlap.files.descriptions import load_race
from hotlap.flight.fly import fly_batch
from hotlap.flight.numbers import Numbers, best_numbers
from hotlap.race.race import Race
from hotlap.race.track import Gate, Track
from hotlap.reference.attitude import follow_axes, turn_rates
from hotlap.reference.reference import PERIOD, Reference
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentClass, Segments

TUNED = (33.5, 357.0, 44.0, 7.1, 6.0)  # weights that fly every built-in race
GATE_TIMES = np.array([0.995, 1.6, 2.213, 2.8, 3.4])  # s, some of them between two control periods
BORDER = 1.5  # s, where the second segment begins
RADIUS, RAMP, SPEED = 5.0, 2.5, 7.0  # m, s until the speed is full, m/s
GRAVITY = 9.81
QUIET = dict.fromkeys(("thrust", "rates", "thrust_bias", "position", "velocity", "attitude"), 0.0)


@cache
def make_reference(period: float = PERIOD) -> Reference:
    """From rest at the origin around a circle, rising a little; the table goes on behind the last gate.

    Args:
        period: [s] between rows.
    """
    t = np.arange(0.0, 8.0, period)
    share = np.clip(t / RAMP, 0.0, 1.0)
    speed = SPEED * share**2 * (3 - 2 * share)
    along = SPEED * np.where(t < RAMP, RAMP * (share**3 - share**4 / 2), t - RAMP / 2)
    angle, growth = along / RADIUS, SPEED * 6 * share * (1 - share) / RAMP
    out, forward = np.stack([np.sin(angle), -np.cos(angle), 0 * t], 1), np.stack([np.cos(angle), np.sin(angle), 0 * t], 1)
    up = np.array([0.0, 0.0, 0.2])
    position = RADIUS * (out + [0, 1, 0]) + along[:, None] * up + [0, 0, 1]
    velocity = speed[:, None] * (forward + up)
    acceleration = growth[:, None] * (forward + up) - (speed**2 / RADIUS)[:, None] * out
    thrust = acceleration + [0, 0, GRAVITY]
    size = np.linalg.norm(thrust, axis=1)
    attitude = follow_axes(thrust / size[:, None], np.array([1.0, 0.0, 0.0, 0.0]))
    turns = turn_rates(attitude, period)
    rates = np.vstack([turns[:1], (turns[1:] + turns[:-1]) / 2, turns[-1:]])
    unknown, duration = np.full((len(t), 4), np.nan), float(GATE_TIMES[-1])
    return Reference(position, attitude, velocity, rates, size, unknown, GATE_TIMES, duration, period=period)


def make_race(vehicle: dict[str, Any] | None = None, **settings: dict[str, Any]) -> Race:
    """The hummingbird of the built-in races on the small scenario: no dead time, no drag, known to its controller, no noise.

    Args:
        vehicle: what is different about it; the controller goes on believing in a vehicle without.
        settings: what is different about parts of the race: model, controller, noise, judge.
    """
    race, reference = load_race("circle-34"), make_reference()
    gates = tuple(Gate(position=tuple(place)) for place in reference.position_at(GATE_TIMES).tolist())
    track = Track(name="small", start=tuple(reference.position[0].tolist()), gates=gates)
    plain = race.vehicle.model_copy(update={"delay": 0.0, "rotor_drag": 0.0})
    changes: dict[str, Any] = {
        "track": track,
        "vehicle": plain.model_copy(update=vehicle),
        "model": plain.model_copy(update=settings.pop("model", None)),
        "noise": race.noise.model_copy(update={**QUIET, **settings.pop("noise", {})}),
    }
    changes |= {name: getattr(race, name).model_copy(update=update) for name, update in settings.items()}
    return race.model_copy(update=changes)


def make_scenario(vehicle: dict[str, Any] | None = None, **settings: dict[str, Any]) -> Scenario:
    """The small race with its reference, in two segments."""
    segments = Segments(np.array([0.0, BORDER]), (SegmentClass.FLAT, SegmentClass.ASCENT), float(GATE_TIMES[-1]))
    return Scenario(make_race(vehicle, **settings), make_reference(), segments)


def parameters(flights: int, values: tuple[float, ...] = TUNED) -> np.ndarray:
    """The same parameters in both segments of every flight."""
    return np.tile(np.array(values), (flights, 2, 1))


def fly(scenario: Scenario, flights: int | np.ndarray = 1, *, numbers: str = "", seeds: Any = None, **options: Any) -> Flights:
    """Fly so many flights with the tuned parameters, or given parameters, in one thread, as users fly them."""
    asked = parameters(flights) if isinstance(flights, int) else flights
    seeds = np.arange(len(asked)) if seeds is None else np.asarray(seeds)
    return fly_batch(scenario, asked, seeds, numbers=Numbers(numbers) if numbers else best_numbers(), **{"threads": 1, **options})[0]

"""Margin: what thrust and body rates a vehicle can give, over what a reference needs of them, under any condition.

The controller's model has the mass m, the vehicle has the mass m_v: a command T accelerates by k T, where k = m / m_v is the thrust
effectiveness. With R the thrust of all rotors per m, and L the controller's thrust limit, what the controller can give is

    k min(L, R)                              of a controller that does not know k,
    min(L, k min(max(L, 0.9 R), R))          of one that estimates it: it may command more than L, but leaves the rotors a tenth for torque.

What is needed of both is |T z - d|, of the reference's thrust T along its axis z, with the drags that were planned with, and the
wind's acceleration d in its worst horizontal direction. What is needed of the rotors alone, k R, is |f - d|: the thrust f that the
accelerations need of a vehicle with its own drags (`demands.needed_vectors`). It is more than T where a plan brakes with a drag that its
vehicle has not (`planning.v_max`): what the controller's limit cuts of such a peak costs some distance, but rotors that give everything
cannot turn the drone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.shown import Shown
from hotlap.feasibility.demands import HELD, needed_vectors, running_mean
from hotlap.race.battery import MOST_LOST
from hotlap.race.conditions import DEFAULT_CONDITIONS, UNCHANGED, Condition
from hotlap.race.race import Race
from hotlap.race.vehicle_parameters import VEHICLE_PARAMETERS, vehicle_parameters_of
from hotlap.reference.attitude import thrust_axis
from hotlap.reference.reference import Reference

ENOUGH = 1.05  # reserve from which on flights hold whose controller knows its thrust; measured, see docs/failures.md
FOR_TORQUE = 0.9  # of the rotors' thrust: all of it leaves none to turn with
AT_GATE = 0.15  # s around its time
SAME = 0.005  # difference of two margins that says nothing

Floats = NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Margin(Shown):
    """What is there over what a reference needs, where that is least.

    Attributes:
        condition: under which.
        available: [m/s^2] thrust per mass that the vehicle can give there.
        needed: [m/s^2] that the reference needs there, for 0.1 s.
        time: [s] of that moment.
        place: the same in words: "at gate 3".
        rates: body rates that the controller may command over those of the reference, of the axis with the least left [-].
        passing: whether that is so for a while alone: in the worst direction of a wind, at the end of a battery, or where the vehicle has
            less drag to brake with than the plan.
        reserve: as `thrust`, but a tenth of what the rotors give is left to turn with [-].
        shrink: what the thrust of the plan would have to be multiplied by to leave enough [-].
        limit: [m/s^2] `controller.thrust` that would leave enough, where the rotors have it; None where they have not.
    """

    condition: Condition
    available: float
    needed: float
    time: float
    place: str
    rates: float
    passing: bool = False
    reserve: float = math.inf
    shrink: float = 1.0
    limit: float | None = None

    def dump(self) -> dict[str, Any]:
        """As plain JSON, in the keys of `margin` of `hotlap tune --json`."""
        names = ("thrust", "reserve", "available", "needed", "time", "place", "rates")
        return {name: getattr(self, name) for name in names}

    @property
    def change(self) -> str:
        """What is different, in words."""
        return self.condition.name

    @property
    def thrust(self) -> float:
        """Thrust that is there over thrust that is needed [-]."""
        return self.available / self.needed

    @property
    def lacking(self) -> bool:
        """Whether the thrust does not suffice, and not for a while alone: no weights help."""
        return self.thrust < 1 and not self.passing

    @property
    def enough(self) -> bool:
        """Whether thrust is left to correct with."""
        return self.reserve >= ENOUGH

    @property
    def figure(self) -> str:
        """The share of thrust in two digits, never rounded up."""
        return f"{math.floor(100 * self.thrust + 1e-9) / 100:.2f}"


@dataclass(frozen=True)
class _Side:
    """Thrust per mass that is needed and that is there, each of shape (rows,) [m/s^2].

    Attributes:
        needed: in a wind, held.
        calm: without it.
        there: what can be given.
        turning: that where a tenth of what the rotors give is left to turn with.
    """

    needed: Floats
    calm: Floats
    there: Floats
    turning: Floats

    @staticmethod
    def of(vectors: Floats, wind: float, steps: int, there: Floats, turning: Floats) -> _Side:
        """What thrust vectors, shape (rows + steps - 1, 3), ask for where each has to be held for so many steps."""
        needed, calm = (running_mean(in_wind(vectors, push), steps) for push in (wind, 0.0))
        return _Side(needed, calm, there, turning)

    @property
    def worst(self) -> int:
        """Row where least is left."""
        return int((self.there / self.needed).argmin())

    @property
    def thrust(self) -> float:
        """What is there over what is needed, where that is least [-]."""
        return float((self.there / self.needed).min())

    @property
    def reserve(self) -> float:
        """The same with a tenth left to turn with [-]."""
        return float((self.turning / self.needed).min())

    @property
    def shrink(self) -> float:
        """What the thrust that is needed without wind would have to be multiplied by to leave enough [-]."""
        worst = int((self.turning / self.needed).argmin())
        return float((self.turning[worst] / ENOUGH - self.needed[worst]) / self.calm[worst]) + 1


def margin(
    race: Race,
    reference: Reference,
    condition: Condition = UNCHANGED,
    *,
    offset_free: bool = False,
    vectors: Floats | None = None,
    until: float = math.inf,
) -> Margin:
    """What a vehicle can give over what a reference needs, under a condition.

    Steady wind counts in its worst direction, gusts with their standard deviation, a battery's sag with what it has taken by then.

    Args:
        race: its vehicle and noise, the control model and the limits of its controller count.
        reference: planned or read.
        condition: what is different from the race.
        offset_free: whether the controller estimates its thrust and what pushes it.
        vectors: `needed_vectors` of the race's vehicle and the reference; None: they are computed here.
        until: [s] what the reference needs later does not count.
    """
    noise, vehicle = condition.noise(race.noise), _by_name(condition.vehicle_parameters(vehicle_parameters_of(race.vehicle)))
    wind, steps = noise.steady_wind + noise.wind, round(HELD / reference.period)
    vectors = needed_vectors(race.vehicle, reference) if vectors is None else vectors
    planned, lost = planned_vectors(reference)[:-1], _lost(vehicle, in_wind(vectors, wind), reference.period)
    rows = slice(int(min(max(until / reference.period + steps / 2, steps), reference.planned_rows)))
    vectors, planned, left = vectors[rows], planned[rows], running_mean(1 - lost[rows], steps)
    effectiveness = left * race.control_model.mass / vehicle["mass"]
    rotors = race.vehicle.rotor_count * vehicle["rotor_thrust_max"] / race.control_model.mass
    most, turning = race.controller.thrust[1], FOR_TORQUE * rotors
    available = _available(most, rotors, effectiveness, offset_free=offset_free)
    reserved = np.minimum(most, effectiveness * turning) if offset_free else effectiveness * min(most, turning)
    both = _Side.of(planned, wind, steps, available, reserved)
    alone = _Side.of(vectors, wind, steps, effectiveness * rotors, effectiveness * turning)
    side = min(both, alone, key=lambda one: one.thrust)
    time = (side.worst + 0.5 * (len(vectors) + 1 - len(left))) * reference.period
    return Margin(
        condition=condition,
        available=float(side.there[side.worst]),
        needed=float(side.needed[side.worst]),
        time=time,
        place=place_of(race, reference, time),
        rates=_rates(race, reference, rows),
        passing=bool(wind > 0 or left[-1] < left[0] or both.thrust >= 1),
        reserve=min(both.reserve, alone.reserve),
        shrink=min(both.shrink, alone.shrink),
        limit=_limit(both, float(effectiveness[both.worst]), turning, offset_free=offset_free) if alone.reserve >= ENOUGH else None,
    )


def _limit(side: _Side, effectiveness: float, turning: float, *, offset_free: bool) -> float | None:
    """`controller.thrust` [m/s^2] that leaves enough; None where the rotors have not that much and a tenth to turn with."""
    limit = ENOUGH * float(side.needed[side.worst])
    limit = limit if offset_free and effectiveness * turning >= limit else limit / min(effectiveness, 1.0)
    return limit if limit <= turning else None


def planned_vectors(reference: Reference) -> Floats:
    """Thrust per mass of each planned row, as the reference has it, shape (rows, 3) [m/s^2] (world)."""
    rows = slice(0, reference.planned_rows)
    return thrust_axis(reference.attitude[rows]) * reference.thrust[rows, None]


def in_wind(vectors: Floats, wind: float) -> Floats:
    """Length of thrust vectors, shape (rows, 3), in the worst horizontal direction of a wind, an acceleration [m/s^2]; shape (rows,)."""
    return np.hypot(np.linalg.norm(vectors[:, :2], axis=1) + wind, vectors[:, 2])


def margins(race: Race, reference: Reference, *, offset_free: bool = False) -> tuple[Margin, ...]:
    """Margins as the race is, then under those conditions that every controller is asked to bear and that cost thrust.

    Args:
        race: that is flown.
        reference: planned or read.
        offset_free: whether the controller estimates its thrust and what pushes it.
    """
    vectors, every = needed_vectors(race.vehicle, reference), (UNCHANGED, *DEFAULT_CONDITIONS)
    found = [margin(race, reference, condition, offset_free=offset_free, vectors=vectors) for condition in every]
    return tuple(one for one in found if one is found[0] or one.thrust < found[0].thrust - SAME)


def place_of(race: Race, reference: Reference, time: float) -> str:
    """Where on the track a moment is, in words: "at gate 2", "between gate 2 and gate 3"."""
    names = [point.name for point in race.track.route if point.counts]
    nearest = int(np.abs(reference.gate_times - time).argmin())
    if abs(reference.gate_times[nearest] - time) <= AT_GATE:
        return f"at {names[nearest]}"
    passed = int((reference.gate_times < time).sum())
    if passed == 0:
        return f"before {names[0]}"
    return f"after {names[-1]}" if passed == len(names) else f"between {names[passed - 1]} and {names[passed]}"


def _available(limit: float, rotors: float, effectiveness: Floats, *, offset_free: bool) -> Floats:
    """Thrust per mass [m/s^2] that controller and rotors together can give, for each thrust effectiveness, shape (rows,)."""
    if offset_free:
        return np.minimum(limit, effectiveness * min(max(limit, FOR_TORQUE * rotors), rotors))
    return effectiveness * min(limit, rotors)


def _lost(vehicle: Mapping[str, float], needed: Floats, period: float) -> Floats:
    """Share of the thrust that the battery has lost by each row where it gives what is needed, shape (rows,); see `race.battery`."""
    drawn = period * np.cumsum((vehicle["mass"] * needed) ** 1.5)
    return np.minimum(vehicle["sag"] * np.linspace(0, 1, len(needed)) + vehicle["charge_sag"] * drawn, MOST_LOST)


def _by_name(vehicle_parameters: Floats) -> Mapping[str, float]:
    """The physical parameters of one vehicle, shape (P,), by their names."""
    return dict(zip(VEHICLE_PARAMETERS, vehicle_parameters.tolist(), strict=True))


def _rates(race: Race, reference: Reference, rows: slice) -> float:
    """Rates that the controller may command over those of planned rows, of the axis with the least left [-]."""
    largest = np.abs(reference.rates[: reference.planned_rows][rows]).max(axis=0)
    return float((np.array(race.controller.rates) / np.maximum(largest, 1e-9)).min())

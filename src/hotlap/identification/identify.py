"""Identification: logs and a base in, the vehicle's numbers with intervals out, and how well they predict what was not fitted."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hotlap.core.shown import Shown
from hotlap.identification.estimates import Estimate, estimates_of, hover_throttle
from hotlap.identification.evidence import Evidence, lay_out
from hotlap.identification.fit import Fit, fit, search
from hotlap.identification.held_out import Prediction, held_out, predictions, signals_of
from hotlap.identification.model import Model, Numbers
from hotlap.identification.motor_lag import with_lag_of_thrust
from hotlap.identification.unknowns import AXES, BATTERY_POWER, moved, unknowns_of
from hotlap.logs.flight_log import FlightLog, Signal
from hotlap.logs.hotlap_csv import FULL_THRUST
from hotlap.logs.plausibility import check_units
from hotlap.race.quadrotor import Quadrotor

STAGES = 4  # that are told
SURE = 2.5  # intervals from 0, from which on a quadratic drag is taken to be one


@dataclass(frozen=True)
class ThrustMap:
    """T / m = full ((1 - curvature) u + curvature u^2) (V / voltage)^power.

    Attributes:
        full: [m/s^2] thrust per mass at throttle 1.
        curvature: [-] 0: straight, 1: a parabola.
        hover: throttle that carries the weight.
        power: of the voltage; NaN where no battery was logged.
        voltage: [V] at which the rest holds; NaN likewise.
    """

    full: float
    curvature: float
    hover: float
    power: float
    voltage: float


@dataclass(frozen=True, repr=False)
class Identification(Shown):
    """What logs say of a vehicle.

    Attributes:
        base: what it was believed to be.
        logs: their names.
        seconds: of flight that were used.
        known: what of the base was taken to be right: "mass" or "thrust", or with "rate loop".
        estimates: of its numbers.
        thrust_map: from throttle to thrust per mass.
        predictions: where the logs were not fitted.
        notes: what was assumed.
    """

    base: Quadrotor
    logs: tuple[str, ...]
    seconds: float
    known: str
    estimates: tuple[Estimate, ...]
    thrust_map: ThrustMap
    predictions: tuple[Prediction, ...]
    notes: tuple[str, ...]

    @property
    def untold(self) -> tuple[Estimate, ...]:
        """What the logs cannot tell."""
        return tuple(one for one in self.estimates if not one.told)

    def to_dict(self) -> dict[str, Any]:
        """The keys of `--json`."""
        return {
            "base": self.base.name,
            "logs": list(self.logs),
            "seconds": self.seconds,
            "known": self.known,
            "estimates": [one.dump() for one in self.estimates],
            "thrust_map": vars(self.thrust_map),
            "held_out": [one.dump() for one in self.predictions],
            "notes": list(self.notes),
        }


def identify(
    logs: Sequence[FlightLog],
    base: Quadrotor,
    *,
    thrust_known: bool = False,
    loop_known: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> Identification:
    """Find a vehicle's numbers in logs of its flights.

    Args:
        logs: of one vehicle, one or more.
        base: whose geometry, mass and form of rate loop it has.
        thrust_known: whether the base's thrust is right, and its mass is to be found; else the other way round.
        loop_known: whether its rate loop is right, as where a firmware's gains were copied.
        say: told when a stage, of `STAGES`, has ended.

    Raises:
        InputError: a log lacks what no identification can do without, or cannot be right.
    """
    for log in logs:
        check_units(log)
    evidence = [lay_out(_in_throttle(log, base)) for log in logs]
    voltage = _voltage(evidence)
    models = [Model(base, one, k, voltage, thrust_known) for k, one in enumerate(evidence)]
    straight = all(FULL_THRUST in log.facts or "thrust_command" not in log.signals for log in logs)
    unknowns = unknowns_of(base, evidence, straight=straight, loop_known=loop_known)
    unknowns = moved(unknowns, search(models, unknowns))
    say("searched for dead time and gains")
    fitted = [
        {
            name: model.evidence.counts[name] & ~held_out(signal.times, float(model.evidence.grid[0]))
            for name, signal in signals_of(model).items()
        }
        for model in models
    ]
    first = fit(models, unknowns, np.array([one.start for one in unknowns]), fitted)
    say("fitted three quarters of the log")
    curved = with_lag_of_thrust(models, _curved(models, base, evidence, first, fitted, straight=straight, loop_known=loop_known), fitted)
    say("looked for drag that grows with the square of the speed")
    seen = predictions(models, curved.numbers, _believed(base))
    counts = [one.counts for one in evidence]
    last = with_lag_of_thrust(models, fit(models, curved.unknowns, curved.theta, counts, rounds=2), counts)
    say("fitted all of it")
    numbers = last.numbers
    known = ThrustMap(
        numbers["full"],
        numbers.get("curvature", 0.0),
        hover_throttle(numbers, base.gravity),
        numbers.get("battery", math.nan),
        voltage,
    )
    seconds = sum(one.seconds for one in evidence)
    notes = tuple(dict.fromkeys(note for one in (*logs, *evidence) for note in one.notes))
    estimates = estimates_of(last, base, evidence, thrust_known=thrust_known)
    which = f"{'thrust' if thrust_known else 'mass'}{' and rate loop' * loop_known}"
    return Identification(base, tuple(log.name for log in logs), seconds, which, estimates, known, seen, notes)


def _in_throttle(log: FlightLog, base: Quadrotor) -> FlightLog:
    """A log whose throttle 1 is the base's largest thrust, where it says what thrust it stands for."""
    if FULL_THRUST not in log.facts or "thrust_command" not in log.signals:
        return log
    thrust = log.signals["thrust_command"]
    share = float(log.facts[FULL_THRUST]) / base.max_acceleration
    return replace(log, signals={**log.signals, "thrust_command": Signal(thrust.times, thrust.values * share)})


def _voltage(evidence: Sequence[Evidence]) -> float:
    """[V] in the first second of the first log that has a battery."""
    for one in evidence:
        if one.has_battery and one.thrust_command is not None:
            return float(one.thrust_command.means(np.array([one.grid[0], one.grid[0] + 1.0]))[0, 1])
    return math.nan


def _curved(
    models: Sequence[Model], base: Quadrotor, evidence: Sequence[Evidence], first: Fit, counts: Sequence[Any], **known: bool
) -> Fit:
    """The fit with quadratic drag along the axes where it shows."""
    if not any(one.name.startswith("drag") for one in first.unknowns):
        return first
    starts = dict(zip((one.name for one in first.unknowns), first.theta.tolist(), strict=True))

    def with_axes(axes: Sequence[str], rounds: int) -> Fit:
        unknowns = unknowns_of(base, evidence, axes, **known)
        beliefs = {one.name: one.start for one in first.unknowns}
        theta = np.array([starts.get(one.name, one.start) for one in unknowns])
        return fit(models, moved(unknowns, beliefs), theta, counts, rounds=rounds)

    tried = with_axes(AXES, 1)
    shown = [axis for axis in AXES if tried.numbers[f"body_drag_{axis}"] > SURE * tried.error(f"body_drag_{axis}")]
    return with_axes(shown, 2) if shown else first


def _believed(base: Quadrotor) -> Numbers:
    """The numbers of the base, as a fit has them."""
    up, down = (max(time, 1e-4) for time in base.motor_time)
    numbers = {"full": base.max_acceleration, "lag": math.sqrt(up * down), "lag_ratio": down / up, "delay": base.delay}
    numbers |= {"battery": BATTERY_POWER, "rotor_drag": base.rotor_drag}
    for k, axis in enumerate(AXES):
        numbers |= {f"gain_{axis}": base.rate_gain[k], f"drag_{axis}": base.drag[k], f"body_drag_{axis}": base.body_drag[k]}
    return numbers

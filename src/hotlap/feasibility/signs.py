"""Signs: what the logs of failed flights show: commands at their limits, how far from the reference and where, thrust and dead time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from hotlap.core.records import Log
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import Race
from hotlap.reference.attitude import thrust_axis
from hotlap.reference.reference import Reference
from hotlap.reference.scenario import Scenario
from hotlap.reference_files.thrust_vectors import with_drag

BEFORE = 1.0  # s before the end of a flight that are looked at
BEGINNING = 0.5  # s at the start of a flight
AT_LIMIT = 0.98  # share of a limit that counts as all of it
SETTLED = 0.2  # s from the start within which commands before the flight still act
LONGEST, FINE = 0.16, 0.005  # s: dead times that are looked for
PAD = 256  # rows: the equations of motion are prepared for multiples of them
WEAK = 0.1  # of the largest thrust: less says little about thrust

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Signs:
    """What the log of a failed flight shows, or the medians over several.

    Attributes:
        saturated: share of the last second in which thrust was commanded at its limit [-].
        saturated_first: the same of the first half second.
        rates_limited: share of the last second in which roll or pitch rate was commanded at its limit [-].
        jumps: how often a second, in the last one, the commanded roll or pitch rate jumped by more than its limit [1/s].
        along: [m] distance from the clocked reference along its path at the end; negative: behind.
        aside: [m] the same across it.
        above: [m] the same upwards.
        growing: share of the final error that was there half a second before [-].
        effectiveness: thrust that acted over thrust that was commanded [-]; NaN where there was too little to tell.
        dead_time: [s] that body rates took to answer their commands, beyond the lag of a known rate loop.
    """

    saturated: float
    saturated_first: float
    rates_limited: float
    jumps: float
    along: float
    aside: float
    above: float
    growing: float
    effectiveness: float
    dead_time: float

    @property
    def behind(self) -> bool:
        """Whether the drone is behind on its path rather than beside it."""
        return self.along < 0 and -self.along > self.aside

    @staticmethod
    def median(signs: Sequence[Signs]) -> Signs:
        """The medians over at least one flight."""
        columns = {field.name: np.array([getattr(one, field.name) for one in signs]) for field in fields(Signs)}
        known = {name: values[np.isfinite(values)] for name, values in columns.items()}
        return Signs(**{name: float(np.median(values)) if len(values) else float("nan") for name, values in known.items()})


def signs_of(scenario: Scenario, log: Log, end_time: float) -> Signs | None:
    """What the log of a flight shows; None where it ended at once.

    Args:
        scenario: that was flown.
        log: of a flight.
        end_time: [s] of its miss or crash.
    """
    race, rows = scenario.race, int((log.times <= end_time + 1e-9).sum())
    if rows < SETTLED / race.controller.period:
        return None
    log = Log(log.times[:rows], log.states[:rows], log.rotor_thrusts[:rows], log.commands[:rows])
    last, first = log.times >= log.times[-1] - BEFORE, log.times <= log.times[0] + BEGINNING
    turning = log.commands[:, 1:3] / np.array(race.controller.rates[:2])
    turned: Floats = np.abs(turning).max(axis=1)
    most = min(race.controller.thrust[1], race.control_model.max_acceleration)
    full = np.greater_equal(log.commands[:, 0], AT_LIMIT * most)
    jumped: Floats = np.abs(np.diff(turning, axis=0, prepend=turning[:1])).max(axis=1)
    along, aside, above, growing = _error(scenario.reference, log)
    return Signs(
        saturated=float(full[last].mean()),
        saturated_first=float(full[first].mean()),
        rates_limited=float((turned[last] >= AT_LIMIT).mean()),
        jumps=float((jumped[last] > 1).sum() / min(BEFORE, max(log.times[-1] - log.times[0], 1e-9))),
        along=along,
        aside=aside,
        above=above,
        growing=growing,
        effectiveness=_effectiveness(race, log),
        dead_time=_dead_time(race.control_model, log),
    )


def _error(reference: Reference, log: Log) -> tuple[float, float, float, float]:
    """Distance from the clocked reference at the end: along its path, across it and upwards [m]; the share of it half a second before."""
    errors = log.states[:, :3] - reference.position_at(log.times)
    velocity = np.array([np.interp(log.times[-1], reference.times, column) for column in reference.velocity.T])
    error, ahead = errors[-1], velocity / max(float(np.linalg.norm(velocity)), 1e-9)
    along = float(error @ ahead)
    earlier = np.linalg.norm(errors[np.searchsorted(log.times, log.times[-1] - BEGINNING)])
    growing = float(earlier / max(float(np.linalg.norm(error)), 1e-9))
    return along, float(np.linalg.norm(error - along * ahead)), float(error[2]), growing


def _effectiveness(race: Race, log: Log) -> float:
    """Thrust that acted over thrust that was commanded, by least squares; NaN where too little was commanded.

    Rows in which the rotors could not give what was commanded are left out: they say nothing about the thrust of a command.
    """
    model, period = race.control_model, race.controller.period
    rows = -(-len(log.times) // PAD) * PAD
    pad = [(0, rows - len(log.times)), (0, 0)]
    attitude, velocity = (np.pad(log.states[:, part], pad, mode="edge") for part in (slice(3, 7), slice(7, 10)))
    acceleration = np.gradient(velocity, period, axis=0)
    acted = (with_drag(model, velocity, acceleration, attitude) * thrust_axis(attitude)).sum(axis=1)[: len(log.times)]
    late = race.vehicle.delay + sum(model.motor_time) / 2 + period / 2
    sent = np.interp(log.times - late, log.times, log.commands[:, 0])
    told = (log.times > SETTLED) & (sent < AT_LIMIT * model.max_acceleration) & (sent > WEAK * model.max_acceleration)
    return float((acted * sent)[told].sum() / (sent**2)[told].sum()) if told.sum() > SETTLED / period else float("nan")


def _dead_time(model: Quadrotor, log: Log) -> float:
    """[s] by which commanded roll and pitch rates, behind the lag of the rate loop, have to be shifted to be those that were flown."""
    period = float(log.times[1] - log.times[0])
    share, following = 1 - np.exp(-period / max(model.lag, 1e-6)), np.zeros(2)
    lagged = np.empty((len(log.times), 2))
    for row, command in enumerate(log.commands[:, 1:3]):
        following = following + share * (command - following)
        lagged[row] = following
    late, shifts = log.times > SETTLED, np.arange(0.0, LONGEST, FINE)
    gaps = [_shifted(lagged, log.times, shift) - log.states[:, 10:12] for shift in shifts]
    return float(shifts[int(np.argmin([(gap[late] ** 2).mean() for gap in gaps]))])


def _shifted(values: Floats, times: Floats, shift: float) -> Floats:
    """Columns that come so much later, shape (rows, 2)."""
    return np.stack([np.interp(times - shift, times, column) for column in values.T], axis=1)

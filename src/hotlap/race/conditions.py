"""Conditions: how the day of a flight may differ from the race as it is described: another mass, less thrust, wind, a battery that sags.

A condition changes the vehicle (numbers a flight, `vehicle_parameters`) and the noise; the controller does not know of it.
`hold.parse_hold` reads conditions from words such as `mass=+-10%, wind=3`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.core.shown import Shown
from hotlap.race.battery import MOST_LOST
from hotlap.race.quadrotor import MOST_DELAY
from hotlap.race.race import NoiseSettings, Race
from hotlap.race.vehicle_parameters import COLUMNS, DRAGS, FORCES, MASSES, VEHICLE_PARAMETERS, scale, vehicle_parameters_of

Floats = NDArray[np.float64]

AS_TUNED = "as tuned"
TIMES = ("time", "wind_time")  # of the noise, which stay whatever its size


class Quantity(StrEnum):
    """What a condition may change."""

    MASS = "mass"
    THRUST = "thrust"
    DELAY = "delay"
    DRAG = "drag"
    MOTOR = "motor"
    INERTIA = "inertia"
    RATE_GAIN = "rate_gain"
    NOISE = "noise"
    WIND = "wind"
    GUSTS = "gusts"
    SAG = "sag"


WORDS: Mapping[Quantity, tuple[str, str]] = {  # of less, and of more
    Quantity.MASS: ("lighter", "heavier"),
    Quantity.THRUST: ("less thrust", "more thrust"),
    Quantity.DELAY: ("less dead time", "more dead time"),
    Quantity.DRAG: ("less drag", "more drag"),
    Quantity.MOTOR: ("faster motors", "slower motors"),
    Quantity.INERTIA: ("less inertia", "more inertia"),
    Quantity.RATE_GAIN: ("softer rate loop", "stiffer rate loop"),
}
SCALED: Mapping[Quantity, tuple[str, ...]] = {
    Quantity.MASS: MASSES,
    Quantity.THRUST: FORCES,  # a share of the thrust at every command, of the largest too
    Quantity.DRAG: DRAGS,
    Quantity.MOTOR: COLUMNS["motor_time"],
    Quantity.INERTIA: COLUMNS["inertia"],
    Quantity.RATE_GAIN: COLUMNS["rate_gain"],
}
"""Columns of `VEHICLE_PARAMETERS` that a share multiplies; more thrust divides them."""


@dataclass(frozen=True)
class Change:
    """One thing that is different.

    Attributes:
        quantity: what.
        amount: by how much: a share [-] of what a quadrotor has (-0.1: 10 % less); seconds more of `delay`; a factor of the noise; an
            acceleration [m/s^2] of wind (steady) and gusts (standard deviation); the share [-] of thrust lost by a battery's sag.
    """

    quantity: Quantity
    amount: float

    @property
    def name(self) -> str:
        """In words."""
        quantity, amount = self.quantity, self.amount
        match quantity:
            case Quantity.DELAY:
                return f"{1e3 * abs(amount):g} ms {WORDS[quantity][amount > 0]}"
            case Quantity.NOISE:
                return "twice the noise" if amount == 2 else f"{amount:g} times the noise"
            case Quantity.WIND:
                return f"steady push of {amount:g} m/s^2 as of wind"
            case Quantity.GUSTS:
                return f"gusts that push with {amount:g} m/s^2"
            case Quantity.SAG:
                return f"battery sag of {100 * amount:g} %"
        return f"{100 * abs(amount):g} % {WORDS[quantity][amount > 0]}"

    def scaled(self, severity: float) -> Change:
        """The same kind of change, so many times as severe, as far as a vehicle can bear it at all."""
        if self.quantity is Quantity.NOISE:
            return Change(self.quantity, max(0.0, 1 + severity * (self.amount - 1)))
        amount = severity * self.amount
        if self.quantity is Quantity.SAG:
            amount = min(amount, MOST_LOST)
        return Change(self.quantity, max(amount, -MOST_LOST) if self.quantity in SCALED else amount)

    def vehicle_parameters(self, rows: Floats) -> Floats:
        """Rows of vehicle parameters, shape (..., P), with this change."""
        if self.quantity in SCALED:
            factor = 1 / (1 + self.amount) if self.quantity is Quantity.THRUST else 1 + self.amount
            return scale(rows, SCALED[self.quantity], factor)
        changed = rows.copy()
        if self.quantity is Quantity.DELAY:
            changed[..., VEHICLE_PARAMETERS.index("delay")] += self.amount
        elif self.quantity is Quantity.SAG:
            changed[..., VEHICLE_PARAMETERS.index("sag")] = self.amount
        return changed

    def noise(self, noise: NoiseSettings) -> NoiseSettings:
        """The noise of a race with this change."""
        match self.quantity:
            case Quantity.NOISE:
                values = {name: value if name in TIMES else self.amount * value for name, value in noise.model_dump().items()}
                return NoiseSettings(**values)
            case Quantity.WIND:
                return noise.model_copy(update={"steady_wind": self.amount})
            case Quantity.GUSTS:
                return noise.model_copy(update={"wind": self.amount})
        return noise


@dataclass(frozen=True, repr=False)
class Condition(Shown):
    """What is different from the race as it is described; nothing, where there are no changes.

    Attributes:
        changes: all of them at once.
        text: as it may be asked for: `mass=+10%`.
    """

    changes: tuple[Change, ...] = ()
    text: str = ""

    @property
    def name(self) -> str:
        """In words."""
        return " and ".join(change.name for change in self.changes) or AS_TUNED

    def vehicle_parameters(self, rows: Floats) -> Floats:
        """Rows of vehicle parameters, shape (..., P), under this condition."""
        for change in self.changes:
            rows = change.vehicle_parameters(rows)
        return rows

    def scaled(self, severity: float) -> Condition:
        """The same condition, so many times as severe: 0 is no condition at all, 2 twice as far from the race as described."""
        return Condition(tuple(change.scaled(severity) for change in self.changes), self.text)

    def noise(self, noise: NoiseSettings) -> NoiseSettings:
        """The noise of a race under this condition."""
        for change in self.changes:
            noise = change.noise(noise)
        return noise


UNCHANGED = Condition()
DEFAULT_CONDITIONS = tuple(
    Condition((Change(quantity, amount),), text)
    for quantity, amount, text in (
        (Quantity.MASS, -0.1, "mass=-10%"),
        (Quantity.MASS, 0.1, "mass=+10%"),
        (Quantity.THRUST, -0.15, "thrust=-15%"),
        (Quantity.DELAY, 0.02, "delay=+20ms"),
        (Quantity.NOISE, 2.0, "noise=x2"),
    )
)
"""What every tuned controller is asked to bear."""


def check_conditions(conditions: Sequence[Condition], race: Race) -> None:
    """Refuse conditions that a race cannot be flown under.

    Raises:
        InputError: dead time would be negative or longer than a quadrotor may have.
    """
    before = vehicle_parameters_of(race.vehicle)
    for condition in conditions:
        delay = float(condition.vehicle_parameters(before)[VEHICLE_PARAMETERS.index("delay")])
        if not -1e-9 <= delay <= MOST_DELAY + 1e-9:
            has = f"{race.vehicle.name} has {1e3 * race.vehicle.delay:g} ms"
            raise InputError("", "hold", f"'{condition.text}': {has}, and dead time must stay between 0 and {1e3 * MOST_DELAY:g} ms")


def join_conditions(*lists: Sequence[Condition]) -> tuple[Condition, ...]:
    """All conditions of some lists in order; of those that change the same, the first."""
    joined: dict[tuple[Change, ...], Condition] = {}
    for conditions in lists:
        for condition in conditions:
            joined.setdefault(condition.changes, condition)
    return tuple(joined.values())

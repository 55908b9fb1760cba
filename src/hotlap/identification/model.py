"""Model: what a vehicle with given numbers would have measured in the flight of a log.

T / m = full ((1 - c) u + c u^2) (V / V0)^n           thrust per mass of the throttle u and the voltage V
rates, thrust = replay of the commands, `delay` late   nothing that was measured enters: its noise cannot bend the fit
force = T / m e_z - drag(velocity in the body)
velocity = integral of R force - g                     where the force is not measured
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import lfilter

from hotlap.core.records import Floats
from hotlap.identification.evidence import Evidence, stretches
from hotlap.identification.replay import RATES, ROOTS, THRUST, replay
from hotlap.identification.unknowns import AXES, BATTERY_POWER, SIMULATED
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import PLANT_STEP
from hotlap.race.rate_loop import RateLoop

WASHOUT = 1.0  # s after which errors of a velocity are forgotten, with those of the attitude that cause them
SETTLED = 10  # samples whose mean is where a velocity begins
RUN_UP = 0.6  # share of the largest rotor thrust below which the least one lies, whatever a fit tries

Numbers = Mapping[str, float]


def with_numbers(base: Quadrotor, numbers: Numbers, *, thrust_known: bool) -> Quadrotor:
    """The base with thrust, lag, and rate gain of a fit; geometry and the form of its rate loop are its own.

    Args:
        base: the vehicle.
        numbers: by name of the unknown, logarithms undone.
        thrust_known: whether its thrust is its own, too, and its mass is of the fit; else the other way round.
    """
    half = math.sqrt(numbers["lag_ratio"])
    mass = base.rotor_count * base.rotor_thrust[1] / numbers["full"] if thrust_known else base.mass
    most = numbers["full"] * mass / base.rotor_count
    change: dict[str, Any] = {
        "mass": mass,
        "rotor_thrust": base.rotor_thrust if thrust_known else thrust_range(base, most),
        "motor_time": (numbers["lag"] / half, numbers["lag"] * half),
        "inflow": 0.0,
    }
    gains = tuple(numbers.get(f"gain_{axis}", own) for axis, own in zip(AXES, base.rate_gain, strict=True))
    if base.rate_loop is None:
        change["rate_gain"] = gains
    else:
        factors = [gain / own for gain, own in zip(gains, base.rate_gain, strict=True)]
        change["rate_loop"] = scaled(base.rate_loop, factors, numbers)
    return base.model_copy(update=change)


def thrust_range(base: Quadrotor, most: float) -> tuple[float, float]:
    """[N] least and largest thrust of a rotor whose largest is found: the least is the base's, unless it comes too near."""
    return min(base.rotor_thrust[0], RUN_UP * most), most


def scaled(loop: RateLoop, factors: Sequence[float], numbers: Numbers) -> RateLoop:
    """A rate loop with all gains of each axis multiplied, and besides those of the integral and derivative parts.

    Args:
        loop: of the base.
        factors: of roll, pitch and yaw.
        numbers: "integral" of roll and pitch, "integral_z" and "damping" are further factors, 1 where they are missing.
    """
    integral = [numbers.get(name, 1.0) for name in ("integral", "integral", "integral_z")]
    more = {"p": [1.0] * 3, "i": integral, "d": [numbers.get("damping", 1.0)] * 3}
    parts = {name: tuple(np.multiply(getattr(loop, name), np.multiply(factors, times)).tolist()) for name, times in more.items()}
    return loop.model_copy(update=parts)


def thrust_map(numbers: Numbers, throttle: Floats, voltage_share: Floats | float = 1.0) -> Floats:
    """Thrust per mass [m/s^2] of a throttle from 0 to 1, at a share of the reference voltage."""
    c = numbers.get("curvature", 0.0)
    curve = (1 - c) * throttle + c * throttle**2
    return np.asarray(numbers["full"] * curve * voltage_share ** numbers.get("battery", BATTERY_POWER), dtype=np.float64)


@dataclass
class Model:
    """A log's outputs as a function of the unknowns.

    Attributes:
        base: the vehicle.
        evidence: of a log.
        place: of the log among those that are fitted.
        voltage: [V] at which the thrust map holds; NaN where no battery is logged.
        thrust_known: as of `with_numbers`.
    """

    base: Quadrotor
    evidence: Evidence
    place: int
    voltage: float
    thrust_known: bool = False

    def __post_init__(self) -> None:
        self._kept: dict[tuple[float, ...], Floats] = {}

    def replayed(self, numbers: Numbers) -> Floats:
        """Rates, thrust per mass and roots at the edges of the grid, shape (N + 1, 5)."""
        key = tuple(numbers.get(name, 0.0) for name in SIMULATED)
        if key not in self._kept:
            if len(self._kept) > 1:
                self._kept.clear()
            self._kept[key] = replay(self._vehicle(numbers), self._commands(numbers))
        return self._kept[key]

    def _vehicle(self, numbers: Numbers) -> Quadrotor:
        return with_numbers(self.base, numbers, thrust_known=self.thrust_known)

    def _commands(self, numbers: Numbers) -> Floats:
        edges, known = self.evidence.grid - numbers["delay"], self.evidence.thrust_command
        rates = self.evidence.rate_command.means(edges)
        if known is None:
            return np.column_stack([np.full(len(rates), self.base.gravity), rates])
        share = known.values[:, 1] / self.voltage if self.evidence.has_battery else 1.0
        thrust = np.maximum(thrust_map(numbers, known.values[:, 0], share), 0.0)
        return np.column_stack([known.means(edges, thrust[:, None]), rates])

    def force(self, numbers: Numbers, rows: Floats) -> Floats:
        """Specific force in the body at the edges of the grid, shape (N + 1, 3) [m/s^2]."""
        force = np.zeros((len(rows), 3))
        force[:, 2] = rows[:, THRUST]
        air = self.evidence.air
        if air is None:
            return force
        mass = self._vehicle(numbers).mass
        force -= air * [numbers.get(f"drag_{axis}", 0.0) for axis in AXES]
        force -= air * np.abs(air) * [numbers.get(f"body_drag_{axis}", 0.0) / mass for axis in AXES]
        force[:, :2] -= numbers.get("rotor_drag", 0.0) / mass * rows[:, ROOTS, None] * air[:, :2]
        return force

    def predicted(self, numbers: Numbers) -> dict[str, Floats]:
        """Outputs at the times of their samples, shape (samples, 3) each; of a velocity, up to what is forgotten."""
        rows, found = self.replayed(numbers), {"rates": self.evidence.rates}
        outputs = {"rates": rows[:, RATES] + self._bias("gyroscope", numbers)}
        if self.evidence.force is not None:
            outputs["force"] = self.force(numbers, rows) + self._bias("accelerometer", numbers)
            found["force"] = self.evidence.force
        elif self.evidence.velocity is not None and self.evidence.rotations is not None:
            force, rotations = self.force(numbers, rows), self.evidence.rotations
            force[1:, :2] = (force[1:, :2] + force[:-1, :2]) / 2  # drag of the mean velocity; thrust acts as it is after a step
            steps = np.einsum("kij,kj->ki", (rotations[1:] + rotations[:-1]) / 2, force[1:]) - [0, 0, self.base.gravity]
            outputs["velocity"] = np.vstack([np.zeros(3), np.cumsum(PLANT_STEP * steps, axis=0)])
            found["velocity"] = self.evidence.velocity
        return {name: _at(self.evidence.grid, rows, found[name].times) for name, rows in outputs.items()}

    def rates_left(self, numbers: Numbers) -> Floats:
        """Measured less predicted rates, of the samples that count, shape (samples, 3) [rad/s]."""
        rates = self.evidence.rates
        left = rates.values - _at(self.evidence.grid, self.replayed(numbers)[:, RATES], rates.times)
        return left[self.evidence.counts["rates"]]

    def left(self, numbers: Numbers) -> dict[str, Floats]:
        """What was measured less what is predicted, shape (samples, 3) each; of a velocity, what is not forgotten."""
        predicted = self.predicted(numbers)
        left = {"rates": self.evidence.rates.values - predicted["rates"]}
        if self.evidence.force is not None:
            left["force"] = self.evidence.force.values - predicted["force"]
        elif "velocity" in predicted and self.evidence.velocity is not None:
            error, which = self.evidence.velocity.values - predicted["velocity"], stretches(self.evidence.counts["velocity"])
            kept = WASHOUT / (WASHOUT + self.evidence.velocity.step)
            left["velocity"] = np.vstack([_forgetting(error[which == one], kept) for one in range(which[-1] + 1)])
        return left

    def _bias(self, of: str, numbers: Numbers) -> list[float]:
        return [numbers.get(f"{of}_{axis}.{self.place}", 0.0) for axis in AXES]


def _forgetting(error: Floats, kept: float) -> Floats:
    """An error of velocity without what is older than a while, from 0 on."""
    return np.asarray(lfilter([kept, -kept], [1.0, -kept], error - error[:SETTLED].mean(axis=0), axis=0))


def _at(grid: Floats, rows: Floats, times: Floats) -> Floats:
    """Rows between the edges of a grid."""
    place = np.clip((times - grid[0]) / PLANT_STEP, 0, len(grid) - 1)
    k = np.minimum(place.astype(np.int64), len(grid) - 2)
    share = (place - k)[:, None]
    return rows[k] * (1 - share) + rows[k + 1] * share

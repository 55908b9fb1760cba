"""Flights of vehicles whose numbers are known, and what identification should find in their logs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hotlap.files.descriptions import load_quadrotor
from hotlap.identification import draws
from hotlap.identification.identify import Identification
from hotlap.identification.rehearsal import Noise, rehearse
from hotlap.logs.flight_log import FlightLog
from hotlap.race.quadrotor import Quadrotor
from hotlap.worlds.plant_simulator import PlantSimulator

NOISE = Noise(rates=0.05, acceleration=1.0, velocity=0.05, attitude=0.01, position=0.02)
BASE = load_quadrotor("five-inch")
WITHIN = 0.05  # what is asked for
TOLD = ("mass", "motor lag up", "motor lag down", "rate gain roll", "rate gain pitch", "rate gain yaw", "dead time")


@dataclass(frozen=True)
class Truth:
    """A vehicle of another mass, lag, rate loop, dead time and drag than the base."""

    vehicle: Quadrotor
    delay: float

    @property
    def numbers(self) -> dict[str, float]:
        """By the names of the estimates."""
        own = self.vehicle
        found = {"mass": own.mass, "motor lag up": own.motor_time[0], "motor lag down": own.motor_time[1], "dead time": self.delay}
        found |= {f"rate gain {turn}": gain for turn, gain in zip(("roll", "pitch", "yaw"), own.rate_gain, strict=True)}
        return found | {f"drag {axis}": drag for axis, drag in zip("xyz", own.drag, strict=True)}

    def fly(self, seed: int, **settings: Any) -> FlightLog:
        """The suggested flight, by a pilot who believes in the base."""
        return rehearse(PlantSimulator(self.vehicle, BASE), BASE, seed=seed, delay=self.delay, **{"noise": NOISE, **settings})


def drawn(seed: int) -> Truth:
    """A vehicle around the base."""
    return Truth(*draws.drawn(BASE, seed))


def errors(found: Identification, truth: Truth) -> dict[str, float]:
    """By what share each estimate that is told is off."""
    return {one.name: abs(one.value / truth.numbers[one.name] - 1) for one in found.estimates if one.name in truth.numbers and one.told}

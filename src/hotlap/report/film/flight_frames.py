"""Flight frames: states of flights at the times of the frames; a drone that missed a gate is followed until it crashes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hotlap.core.records import Flights
from hotlap.reference.scenario import Scenario
from hotlap.report.page.replay import ParameterSet
from hotlap.report.scene import trace
from hotlap.worlds.world import World

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class FlightFrames:
    """The states of one flight, one row for each frame.

    Attributes:
        label: of the parameters.
        rotors: shape (r, 2) [-] where the drone's rotors sit, in arms.
        position: shape (n, 3) [m] (world), one row a frame.
        attitude: shape (n, 4) (w, x, y, z), body to world.
        speed: shape (n,) [m/s].
        passed: shape (n,) gates passed in a row so far.
        judged: frame at which it was decided how the flight ended.
        failed: whether a gate was not passed.
        ending: how it ended, in a few words.
    """

    label: str
    rotors: Floats
    position: Floats
    attitude: Floats
    speed: Floats
    passed: NDArray[np.int64]
    judged: int
    failed: bool
    ending: str

    def __len__(self) -> int:
        """n, the number of frames."""
        return len(self.position)


def film_flights(scenario: Scenario, world: World, sets: Sequence[ParameterSet], seed: int, interval: float) -> tuple[FlightFrames, ...]:
    """Fly each set of parameters once with the same noise.

    Args:
        scenario: that is flown.
        world: where its flights happen.
        sets: at least one.
        seed: of the noise.
        interval: [s] of the flight between frames.
    """
    judge = scenario.race.judge.model_copy(update={"fly_on": True})
    onward = replace(scenario, race=scenario.race.model_copy(update={"judge": judge}))
    parameters = np.stack([one.parameters for one in sets])
    flown = world.fly(onward, parameters, np.full(len(sets), seed), log=range(len(sets)))
    return tuple(cut(onward, flown, i, one.label, interval) for i, one in enumerate(sets))


def cut(scenario: Scenario, flights: Flights, index: int, label: str, interval: float) -> FlightFrames:
    """One flight of a batch at the times of the frames."""
    log, flight = flights.logs[index], trace(scenario, flights, index, label)
    known = np.isfinite(log.states[:, :10]).all(axis=1)
    times, states = log.times[known], log.states[known, :10]
    last = float(times.max(initial=0.0)) if flight.failed else min(float(times.max(initial=0.0)), scenario.reference.duration)
    frames = np.arange(math.ceil(last / interval - 1e-9) + 1) * interval
    rows = np.array([np.interp(frames, times, column) for column in states.T]).T if len(times) else np.zeros((1, 10))
    gates = flight.seen_times[: flight.gates_passed]
    return FlightFrames(
        label=label,
        rotors=scenario.race.vehicle.rotor_positions / scenario.race.vehicle.arm,
        position=rows[:, :3],
        attitude=rows[:, 3:7] / np.maximum(np.linalg.norm(rows[:, 3:7], axis=1, keepdims=True), 1e-9),
        speed=np.linalg.norm(rows[:, 7:10], axis=1),
        passed=np.searchsorted(np.sort(gates), frames[: len(rows)] + 1e-9),
        judged=_frame_at(flight.end_time, interval, len(rows)),
        failed=flight.failed,
        ending=flight.ending if flight.failed else f"{flight.ending}, {flight.lap_time:.2f} s",
    )


def _frame_at(time: float, interval: float, frames: int) -> int:
    """The first frame at or after a time [s]; the last of so many frames where there is none, or no time."""
    return min(math.ceil(time / interval - 1e-9), frames - 1) if math.isfinite(time) else frames - 1

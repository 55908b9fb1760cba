"""A world whose flights follow the reference at an offset that grows with the distance of the parameters from an optimum."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hotlap.core.parameters import Parameters
from hotlap.core.records import End, Flights, Log
from hotlap.reference.scenario import Scenario

OPTIMUM = np.array([80.0, 400.0, 40.0, 6.0, 4.5])


class PlausibleWorld:
    """Flies by a formula, in full.

    Args:
        reach: [m] of error per unit of logarithmic distance from the optimum.
        noise: [m] of error by chance.
        crash: end failed flights as crashes.
    """

    name, takes_vehicle_parameters = "plausible", False

    def __init__(self, reach: float = 1.2, noise: float = 0.25, *, crash: bool = False) -> None:
        self.reach, self.noise, self.crash = reach, noise, crash

    def fly(
        self,
        scenario: Scenario,
        parameters: Parameters,
        seeds: np.ndarray,
        *,
        vehicle_parameters: np.ndarray | None = None,
        log: Sequence[int] = (),
    ) -> Flights:
        assert vehicle_parameters is None
        reference, gates = scenario.reference, scenario.race.track.gate_positions
        times = reference.times[: reference.planned_rows]
        offsets = np.array([self._offset(scenario, values, int(seed), times) for values, seed in zip(parameters, seeds, strict=True)])
        rows = np.minimum(np.round(reference.gate_times / reference.period).astype(int), len(times) - 1)
        position = reference.position[None, : len(times)] + offsets
        distance = np.linalg.norm(position[:, rows] - gates, axis=2)
        passed = np.cumprod(distance <= scenario.race.judge.distance, axis=1).sum(axis=1)
        stop = np.minimum(passed, len(gates) - 1)
        complete = passed == len(gates)
        seen = np.where(np.arange(len(gates)) <= stop[:, None], distance, np.nan)
        error = np.linalg.norm(offsets, axis=2)
        return Flights(
            seeds=seeds,
            gates_passed=passed,
            end=np.where(complete, int(End.FINISHED), int(End.CRASHED if self.crash else End.MISSED)),
            cause=np.zeros(len(seeds), dtype=np.int64),
            cause_index=np.full(len(seeds), -1),
            end_time=reference.gate_times[stop],
            end_position=position[np.arange(len(seeds)), rows[stop]],
            lap_time=np.where(complete, reference.lap_time, np.nan),
            clock_distance=seen,
            closest_distance=0.5 * seen,
            closest_time=np.where(np.isnan(seen), np.nan, reference.gate_times),
            rim_distance=0.5 * seen - scenario.race.judge.distance,
            mean_error=error.mean(axis=1),
            max_error=error.max(axis=1),
            rooms=np.full(len(gates), scenario.race.judge.distance),
            gate_positions=gates,
            gate_times=reference.gate_times,
            gate_segments=scenario.gate_segments,
            logs={i: self._log(reference, times, position[i]) for i in log},
        )

    def _offset(self, scenario: Scenario, values: np.ndarray, seed: int, times: np.ndarray) -> np.ndarray:
        """Shape (rows, 3) [m]: slow swings, larger where the reference is fast."""
        chance = np.random.default_rng(seed)
        distance = np.sqrt(np.mean(np.log(values / OPTIMUM) ** 2, axis=1))[scenario.segments.at(times)]
        size = self.reach * distance + self.noise * abs(chance.standard_normal())
        phases = chance.uniform(0, 2 * np.pi, (3, 3))
        swings = sum(np.sin(np.outer(times, [0.9 * k, 1.1 * k, 1.3 * k]) + phases[k - 1]) / k for k in (1, 2, 3))
        speed = np.linalg.norm(scenario.reference.velocity[: len(times)], axis=1)
        return 0.6 * swings * (size * (0.3 + speed / max(1.0, speed.max())))[:, None]

    @staticmethod
    def _log(reference, times: np.ndarray, position: np.ndarray) -> Log:
        velocity = np.gradient(position, times, axis=0)
        count = len(times)
        states = np.hstack([position, reference.attitude[:count], velocity, reference.rates[:count]])
        return Log(times, states, np.full((count, 4), 2.0), np.zeros((count, 4)))

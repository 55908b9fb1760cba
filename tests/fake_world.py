"""A world without physics: gates are passed as far as parameters lie near an optimum, give or take the noise of the seed."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from hotlap.core.parameters import Parameters
from hotlap.core.records import End, Flights
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import JudgeSettings, PlanningSettings, Race
from hotlap.race.track import Gate, Track
from hotlap.reference.reference import Reference
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentClass, Segments

GATES = 5
OPTIMUM = np.array([80.0, 400.0, 40.0, 6.0, 4.5])


def make_scenario(judge: JudgeSettings | None = None, name: str = "straight") -> Scenario:
    """Five gates in a line, two metres and one second apart, in two segments."""
    gates = tuple(Gate(position=(2.0 * (k + 1), 0.0, 1.0)) for k in range(GATES))
    track = Track(name=name, start=(0.0, 0.0, 1.0), gates=gates)
    vehicle = Quadrotor(name="box", mass=1.0, inertia=(0.01, 0.01, 0.02), arm=0.2, rotor_thrust=(0.0, 5.0), torque_ratio=0.02)
    planning = PlanningSettings(thrust_share=0.75)
    race = Race(name=name, track=track, vehicle=vehicle, planning=planning, judge=judge or JudgeSettings())
    rows = 701
    position = np.zeros((rows, 3))
    position[:, 0], position[:, 2] = 0.02 * np.arange(rows), 1.0
    zeros, velocity = np.zeros((rows, 3)), np.tile([2.0, 0.0, 0.0], (rows, 1))
    attitude = np.tile([1.0, 0.0, 0.0, 0.0], (rows, 1))
    thrust, rotors = np.full(rows, 9.81), np.full((rows, 4), 2.4525)
    reference = Reference(position, attitude, velocity, zeros, thrust, rotors, gate_times=np.arange(1.0, GATES + 1), duration=float(GATES))
    return Scenario(race, reference, Segments(np.array([0.0, 2.5]), (SegmentClass.FLAT, SegmentClass.ASCENT), float(GATES)))


@dataclass
class FakeWorld:
    """Flies by a formula; `batches` tells what it was asked for.

    Attributes:
        noise: standard deviation of the tracking error that a seed adds [m].
        reach: [m] of error per unit of logarithmic distance from the optimum.
        pause: [s] before each batch, to be killed in.
    """

    name: str = "fake"
    takes_vehicle_parameters: bool = False
    noise: float = 0.25
    reach: float = 2.2
    pause: float = 0.0
    batches: list[int] = field(default_factory=list)

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
        assert not log
        time.sleep(self.pause)
        self.batches.append(len(seeds))
        chances = np.array([np.random.default_rng(int(seed)).standard_normal(GATES) for seed in seeds])
        distance = np.sqrt(np.mean(np.log(parameters / OPTIMUM) ** 2, axis=2))[:, scenario.gate_segments]
        error = np.abs(self.reach * distance + self.noise * chances)
        passed = np.cumprod(error <= scenario.race.judge.distance, axis=1).sum(axis=1)
        complete, stop = passed == GATES, np.minimum(passed, GATES - 1)
        seen = np.where(np.arange(GATES) <= stop[:, None], error, np.nan)
        gates, times = scenario.race.track.gate_positions, scenario.reference.gate_times
        offset = np.zeros((len(seeds), 3))
        offset[:, 1] = np.take_along_axis(error, stop[:, None], 1)[:, 0]
        return Flights(
            seeds=seeds,
            gates_passed=passed,
            end=np.where(complete, int(End.FINISHED), int(End.MISSED)),
            cause=np.zeros(len(seeds), dtype=np.int64),
            cause_index=np.full(len(seeds), -1),
            end_time=times[stop],
            end_position=gates[stop] + offset,
            lap_time=np.where(complete, times[-1], np.nan),
            clock_distance=seen,
            closest_distance=0.5 * seen,
            closest_time=np.where(np.isnan(seen), np.nan, times),
            rim_distance=0.5 * seen - scenario.race.judge.distance,
            mean_error=np.nanmean(seen, axis=1),
            max_error=np.nanmax(seen, axis=1),
            rooms=np.full(len(gates), scenario.race.judge.distance),
            gate_positions=gates,
            gate_times=times,
            gate_segments=scenario.gate_segments,
            logs={},
        )

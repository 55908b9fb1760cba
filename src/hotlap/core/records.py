"""Flights: what happened in a batch of flights. Scores: costs, completion and errors of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.shown import Framed, Shown, by_column

Floats = NDArray[np.float64]


class End(IntEnum):
    """How a flight ended."""

    FINISHED = 0
    MISSED = 1
    CRASHED = 2


class Cause(IntEnum):
    """Why a flight crashed; NONE where it did not.

    NUMBERS: a state that is not a number. DISTANCE: too far from the clocked reference. RATE: turned too fast. FLOOR, CEILING: hit them.
    OUTSIDE: left the track's box. FRAME, POLE, SPHERE, BOX: touched the frame of a gate, or an obstacle. LOST: the simulator was lost in
    mid-flight, and nobody knows what became of the drone.
    """

    NONE = 0
    NUMBERS = 1
    DISTANCE = 2
    RATE = 3
    FLOOR = 4
    CEILING = 5
    OUTSIDE = 6
    FRAME = 7
    POLE = 8
    SPHERE = 9
    BOX = 10
    LOST = 11


@dataclass(frozen=True, repr=False)
class Log(Shown, Framed):
    """The full record of one flight.

    Attributes:
        times: shape (steps,) [s].
        states: shape (steps, 13): position, attitude, velocity (world), rates (body).
        rotor_thrusts: shape (steps, n) [N], of n rotors.
        commands: shape (steps, 4): thrust per mass [m/s^2] and rates [rad/s] as the controller gave them.
        estimates: shape (steps, 4): thrust effectiveness [-] and disturbance [m/s^2] (world) as the controller's observer estimated them;
            1 and 0 where it estimates none, None where the world has no log of them.
    """

    times: Floats
    states: Floats
    rotor_thrusts: Floats
    commands: Floats
    estimates: Floats | None = None

    @property
    def table(self) -> Floats:
        """All of it, shape (steps, columns), in the order of `columns_of`."""
        estimates = np.full((len(self.times), 4), np.nan) if self.estimates is None else self.estimates
        return np.column_stack([self.times, self.states, self.rotor_thrusts, self.commands, estimates])

    def records(self) -> list[dict[str, Any]]:
        """A row for each step, in the columns of `hotlap fly --log`; NaN where a world logs no estimates."""
        return by_column(dict(zip(columns_of(self.rotor_thrusts.shape[1]), self.table.T, strict=True)))


def columns_of(rotors: int) -> tuple[str, ...]:
    """The columns of the log of a flight with so many rotors."""
    return (
        *("t", "p_x", "p_y", "p_z", "q_w", "q_x", "q_y", "q_z", "v_x", "v_y", "v_z", "w_x", "w_y", "w_z"),
        *(f"u_{k + 1}" for k in range(rotors)),
        *("command_thrust", "command_w_x", "command_w_y", "command_w_z"),
        *("thrust_effectiveness", "disturbance_x", "disturbance_y", "disturbance_z"),
    )


@dataclass(frozen=True, repr=False)
class Flights(Shown, Framed):
    """What happened in B flights over M gates.

    Attributes:
        seeds: shape (B,).
        gates_passed: shape (B,), consecutive from the first.
        end: shape (B,) of `End`.
        cause: shape (B,) of `Cause`: why the flight crashed.
        cause_index: shape (B,) index in the track of the pole, sphere or box that was touched, or of the gate whose frame was; else -1.
        end_time: shape (B,) [s] of the last passed gate, the miss or the crash.
        end_position: shape (B, 3) [m] (world) at that time.
        lap_time: shape (B,) [s] at the last gate; NaN where it was not reached.
        clock_distance: shape (B, M) [m] from each gate at the reference's time; NaN where the flight did not get there.
        closest_distance: shape (B, M) [m] closest approach in the judge's window; NaN likewise.
        closest_time: shape (B, M) [s] of the closest approach; NaN likewise.
        rim_distance: shape (B, M) [m] under the rule "opening": signed distance from the rim of the opening less the vehicle's size, where
            the flight crossed the plane, negative inside; the closest distance from its centre where it did not cross it in time; NaN
            where the flight did not get there, and under other rules.
        mean_error, max_error: shape (B,) [m] distance from the clocked reference until the end.
        rooms: shape (M,) [m] radius of the largest circle in the opening less the vehicle's size; the judge's distance for a point, and
            under other rules.
        gate_positions: shape (M, 3) [m] (world).
        gate_times: shape (M,) [s] of the reference.
        gate_segments: shape (M,) index of the segment that each gate lies in.
        logs: full records by index in the batch, of the flights asked for.
    """

    seeds: NDArray[np.int64]
    gates_passed: NDArray[np.int64]
    end: NDArray[np.int64]
    cause: NDArray[np.int64]
    cause_index: NDArray[np.int64]
    end_time: Floats
    end_position: Floats
    lap_time: Floats
    clock_distance: Floats
    closest_distance: Floats
    closest_time: Floats
    rim_distance: Floats
    mean_error: Floats
    max_error: Floats
    rooms: Floats
    gate_positions: Floats
    gate_times: Floats
    gate_segments: NDArray[np.int64]
    logs: dict[int, Log]

    def __len__(self) -> int:
        """B, the number of flights."""
        return len(self.seeds)

    def records(self) -> list[dict[str, Any]]:
        """A row for each flight: how it ended, where and when."""
        return by_column(
            {
                "seed": self.seeds,
                "end": [End(end).name.lower() for end in self.end.tolist()],
                "cause": [Cause(cause).name.lower() if cause else None for cause in self.cause.tolist()],
                "gates_passed": self.gates_passed,
                "lap_time": self.lap_time,
                "end_time": self.end_time,
                **{f"end_{axis}": self.end_position[:, i] for i, axis in enumerate("xyz")},
                "mean_error": self.mean_error,
                "max_error": self.max_error,
            }
        )


@dataclass(frozen=True, repr=False)
class Scores(Shown, Framed):
    """Costs, completion and errors of B flights.

    Attributes:
        cost: shape (B,), less is better: the metric m of the paper by default.
        completion: shape (B,), gates passed / gates, 0 to 1.
        failed_segment: shape (B,) segment of the first missed gate; -1 where all were passed.
        gate_distance: shape (B, M) [m] as the rule measures it; NaN where the flight did not get there.
        gate_miss: shape (B, M), log(gate_distance / the judge's distance, or the room of the opening): negative where the gate was passed,
            NaN where the flight did not get there. In the scores reported to a tuner it is the mean over those flights of a candidate that
            got there. Shape (B, 0)
            where the cost is not computed from gates.
        gate_segment: shape (B, M), the segment that each gate lies in; shape (B, 0) likewise.
        mean_error, max_error: shape (B,) [m].
        lap_time: shape (B,) [s] of complete flights; NaN for the others.
        dense: shape (B,), less is better: a cost that depends on the distance from every gate, not only from the first that was missed.
    """

    cost: Floats
    completion: Floats
    failed_segment: NDArray[np.int64]
    gate_distance: Floats
    gate_miss: Floats
    gate_segment: NDArray[np.int64]
    mean_error: Floats
    max_error: Floats
    lap_time: Floats
    dense: Floats

    def __len__(self) -> int:
        """B, the number of flights."""
        return len(self.cost)

    def records(self) -> list[dict[str, Any]]:
        """A row for each flight."""
        names = ("cost", "completion", "failed_segment", "lap_time", "mean_error", "max_error", "dense")
        return by_column({name: getattr(self, name) for name in names})

    def rows(self, rows: slice | NDArray[np.int64]) -> Scores:
        """The scores of some of the flights."""
        return Scores(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})

    @staticmethod
    def join(parts: Sequence[Scores]) -> Scores:
        """The scores of one batch behind the other; at least one."""
        return Scores(**{field.name: np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Scores)})

    @staticmethod
    def of_costs(costs: Floats) -> Scores:
        """Scores of evaluations that are no flights, from costs of shape (B,), less is better; no gates and no failed segment."""
        costs = np.asarray(costs, dtype=np.float64)
        none = np.full(len(costs), np.nan)
        return Scores(
            cost=costs,
            completion=np.zeros(len(costs)),
            failed_segment=np.full(len(costs), -1),
            gate_distance=np.empty((len(costs), 0)),
            gate_miss=np.empty((len(costs), 0)),
            gate_segment=np.empty((len(costs), 0), dtype=np.int64),
            mean_error=none,
            max_error=none,
            lap_time=none,
            dense=costs,
        )

    def with_costs(self, costs: Floats) -> Scores:
        """The same flights with other costs, shape (B,), which are not computed from gates."""
        return replace(self, cost=costs, dense=costs, gate_miss=self.gate_miss[:, :0], gate_segment=self.gate_segment[:, :0])

    @property
    def complete(self) -> NDArray[np.bool_]:
        """Shape (B,), whether every gate was passed."""
        return self.completion >= 1.0

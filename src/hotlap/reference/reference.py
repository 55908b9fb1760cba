"""Reference: the flight that a controller is asked to repeat, as a table in time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.shown import Framed, Shown, by_column

AXES, QUATERNION = "xyz", "wxyz"
PERIOD = 0.01  # s between the rows of references that are planned, or read from files


def row_times(duration: float) -> NDArray[np.float64]:
    """Times of the rows of such a reference up to a duration, shape (rows,) [s]; a row at the duration itself counts."""
    return np.arange(int(np.floor(duration / PERIOD + 1e-9)) + 1, dtype=np.float64) * PERIOD


@dataclass(frozen=True, repr=False)
class Reference(Shown, Framed):
    """States and inputs in rows of equal time, from rest at the start to beyond the end.

    Rows from `duration` on are the run-out: smooth, never judged.

    Attributes:
        position: shape (rows, 3) [m] (world).
        attitude: shape (rows, 4) (w, x, y, z), body to world, without sign jumps.
        velocity: shape (rows, 3) [m/s] (world).
        rates: shape (rows, 3) [rad/s] (body).
        thrust: shape (rows,) [m/s^2] collective thrust per mass.
        rotor_thrusts: shape (rows, n) [N] of the planning model; NaN in the run-out.
        gate_times: shape (gates,) [s] when the reference passes each gate.
        duration: [s] to the end of the plan (the authors' T).
        cpu_time: [s] of the planner; 0 for a reference that was read.
        period: [s] between rows.
    """

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    velocity: NDArray[np.float64]
    rates: NDArray[np.float64]
    thrust: NDArray[np.float64]
    rotor_thrusts: NDArray[np.float64]
    gate_times: NDArray[np.float64]
    duration: float
    cpu_time: float = 0.0
    period: float = PERIOD

    def records(self) -> list[dict[str, Any]]:
        """The rows up to its end: time [s], position [m], attitude, velocity [m/s], thrust [m/s^2], rates [rad/s]."""
        columns = {
            "t": self.times,
            **{f"p_{axis}": self.position[:, i] for i, axis in enumerate(AXES)},
            **{f"q_{part}": self.attitude[:, i] for i, part in enumerate(QUATERNION)},
            **{f"v_{axis}": self.velocity[:, i] for i, axis in enumerate(AXES)},
            "thrust": self.thrust,
            **{f"w_{axis}": self.rates[:, i] for i, axis in enumerate(AXES)},
        }
        return by_column({name: values[: self.planned_rows] for name, values in columns.items()})

    @property
    def lap_time(self) -> float:
        """[s] at the last gate."""
        return float(self.gate_times[-1])

    @property
    def times(self) -> NDArray[np.float64]:
        """[s] of the rows, shape (rows,)."""
        return np.arange(len(self.position), dtype=np.float64) * self.period

    @property
    def planned_rows(self) -> int:
        """Number of rows before the run-out."""
        return int(np.floor(self.duration / self.period + 1e-9)) + 1

    @property
    def speeds(self) -> NDArray[np.float64]:
        """[m/s] of the planned rows."""
        return np.linalg.norm(self.velocity[: self.planned_rows], axis=1)

    @property
    def max_speed(self) -> float:
        """[m/s] largest speed of the planned rows."""
        return float(self.speeds.max())

    @property
    def mean_speed(self) -> float:
        """[m/s] mean over time of the planned rows."""
        return float(self.speeds.mean())

    @property
    def table(self) -> NDArray[np.float64]:
        """Shape (rows, 14): position, attitude, velocity, thrust per mass, rates: what the flight core reads."""
        return np.hstack([self.position, self.attitude, self.velocity, self.thrust[:, None], self.rates])

    def position_at(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Interpolated positions, shape (times, 3) [m] (world)."""
        return np.stack([np.interp(times, self.times, column) for column in self.position.T], axis=1)

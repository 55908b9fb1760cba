"""Track: where to start, which gates to pass in which order, where the plan ends."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from hotlap.schema import Described, Vector3

REACH = 1e5  # m: beyond this a coordinate is a mistake of units


class Gate(Described):
    """A waypoint that counts.

    Attributes:
        position: [m] (world) its centre.
        yaw: [rad] heading of its normal, for pictures and for worlds that draw gates; the plan does not use it.
    """

    position: Vector3
    yaw: float | None = None


class Track(Described):
    """An ordered list of gates. World frame: x forward, y left, z up.

    Attributes:
        name: what it is called.
        start: [m] (world) position at rest.
        attitude: (w, x, y, z) body to world at the start, normalised on reading.
        gates: the waypoints that count, in order.
        end: [m] (world) where the plan ends; passed like a gate but not counted. None: at the last gate.
        floor: [m] (world) height below which the drone has crashed. None: there is none.
        provenance: where the numbers come from.
    """

    name: str = Field(min_length=1)
    start: Vector3
    attitude: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    gates: tuple[Gate, ...] = Field(min_length=1)
    end: Vector3 | None = None
    floor: float | None = None
    provenance: str = ""

    @field_validator("gates", mode="before")
    @classmethod
    def _bare_positions(cls, gates: Any) -> Any:
        """A gate may be written as a bare [x, y, z]."""
        if not isinstance(gates, (list, tuple)):
            return gates
        return tuple({"position": gate} if isinstance(gate, (list, tuple)) else gate for gate in gates)

    @field_validator("attitude")
    @classmethod
    def _unit(cls, attitude: tuple[float, ...]) -> tuple[float, ...]:
        norm = float(np.linalg.norm(attitude))
        if not 0.9 < norm < 1.1:
            raise ValueError(f"a quaternion (w, x, y, z) has norm 1, this one {norm:.3g}")
        return tuple(value / norm for value in attitude)

    @model_validator(mode="after")
    def _apart(self) -> Track:
        points = np.vstack([self.start, self.waypoints])
        if np.abs(points).max() > REACH:
            raise ValueError(f"a coordinate of {np.abs(points).max():.3g} m: coordinates are in metres")
        gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if gaps.min() < 1e-6:
            i = int(gaps.argmin())
            names = ["start", *(f"gate {k}" for k in range(len(self.gates))), "end"]
            raise ValueError(f"{names[i]} and {names[i + 1]} are the same point")
        if self.floor is not None and points[:, 2].min() < self.floor:
            raise ValueError(f"floor = {self.floor:g} m lies above a point of the track at z = {points[:, 2].min():g} m")
        return self

    @property
    def gate_positions(self) -> NDArray[np.float64]:
        """Shape (gates, 3) [m] (world)."""
        return np.array([gate.position for gate in self.gates])

    @property
    def waypoints(self) -> NDArray[np.float64]:
        """Gates and, where there is one, the end: shape (waypoints, 3) [m] (world)."""
        return self.gate_positions if self.end is None else np.vstack([self.gate_positions, self.end])

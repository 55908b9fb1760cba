"""Track: where to start, which gates to pass in which order, where the plan ends."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from hotlap.race.schema import Described, Vector3

REACH = 1e5  # m: beyond this a coordinate is a mistake of units


class Gate(Described):
    """A waypoint that a flight has to pass; waypoints that are no gates are only planned."""

    position: Vector3
    """[m] (world) its centre."""
    yaw: float | None = None
    """[rad] heading of its normal, for pictures and for worlds that draw gates; the plan does not use it."""

    @model_validator(mode="before")
    @classmethod
    def _bare_position(cls, gate: Any) -> Any:
        """A gate may be written as a bare [x, y, z]."""
        table = {"position": gate} if isinstance(gate, (list, tuple)) else gate
        if isinstance(table, dict) and isinstance(table.get("position"), list):
            return {**table, "position": tuple(table["position"])}
        return table


class Track(Described):
    """An ordered list of gates. World frame: x forward, y left, z up."""

    name: str = Field(min_length=1)
    """what it is called."""
    start: Vector3
    """[m] (world) position at rest."""
    attitude: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    """(w, x, y, z) body to world at the start, normalised on reading."""
    gates: tuple[Gate, ...] = Field(min_length=1)
    """the waypoints that count, in order."""
    end: Vector3 | None = None
    """[m] (world) where the plan ends; passed like a gate but not counted. None: at the last gate."""
    floor: float | None = None
    """[m] (world) height below which the drone has crashed. None: there is none."""
    provenance: str = ""
    """where the numbers come from."""

    @field_validator("attitude")
    @classmethod
    def _unit(cls, attitude: tuple[float, ...]) -> tuple[float, ...]:
        norm = float(np.linalg.norm(attitude))
        if not 0.9 < norm < 1.1:
            raise ValueError(f"a quaternion (w, x, y, z) has norm 1, this one {norm:.3g}")
        return attitude if abs(norm - 1) < 1e-12 else tuple(value / norm for value in attitude)  # reading twice changes no bit

    @model_validator(mode="after")
    def _apart(self) -> Track:
        points = np.vstack([self.start, self.waypoints])
        names = ["start", *(f"gates[{k}]" for k in range(len(self.gates))), "end"]
        extents = np.abs(points).max(axis=1)
        if extents.max() > REACH:
            raise ValueError(f"{names[int(extents.argmax())]}: a coordinate of {extents.max():.3g} m; coordinates are in metres")
        gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if gaps.min() < 1e-6:
            i = int(gaps.argmin())
            raise ValueError(f"{names[i + 1]}: the same point as {names[i]}, just before it")
        if self.floor is not None and points[:, 2].min() < self.floor:
            lowest = int(points[:, 2].argmin())
            raise ValueError(f"floor: {self.floor:g} m lies above {names[lowest]} at z = {points[lowest, 2]:g} m")
        return self

    @property
    def gate_positions(self) -> NDArray[np.float64]:
        """Shape (gates, 3) [m] (world)."""
        return np.array([gate.position for gate in self.gates])

    @property
    def waypoints(self) -> NDArray[np.float64]:
        """Gates and, where there is one, the end: shape (waypoints, 3) [m] (world)."""
        return self.gate_positions if self.end is None else np.vstack([self.gate_positions, self.end])

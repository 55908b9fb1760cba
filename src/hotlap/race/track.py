"""Track: where to start, which gates to pass in which order, what stands in the way, where the plan ends."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from hotlap.race.gate import Gate, Opening
from hotlap.race.obstacles import Box, Pole, Sphere
from hotlap.race.schema import LARGEST, Described, Vector3

__all__ = ["Gate", "Track", "Waypoint"]

SHORTEST = 0.1  # m: a track below this is a mistake of units
MOST_LAPS = 50
MOST_GATES = 1000  # of all laps: what takes a flight of an hour
MOST_OBSTACLES = 1000  # of a kind


@dataclass(frozen=True)
class Waypoint:
    """A point that a flight goes through, in the order flown.

    Attributes:
        name: for messages: "gate 3" (of those that count, from 1), "gate 2 of lap 3", "point 4", "the end".
        key: where the file says it: "gates[2]", "end".
        gate: with the track's opening, where it has none of its own; a bare point for the end.
        counts: whether a flight has to pass it.
    """

    name: str
    key: str
    gate: Gate
    counts: bool


class Track(Described):
    """An ordered list of gates. World frame: x forward, y left, z up."""

    name: str = Field(min_length=1)
    """what it is called."""
    start: Vector3
    """[m] (world) where a flight starts: at rest, unless start_velocity says otherwise."""
    attitude: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    """(w, x, y, z) body to world at the start, normalised on reading."""
    start_velocity: Vector3 = (0.0, 0.0, 0.0)
    """[m/s] (world) at the start, for a flying start."""
    gates: tuple[Gate, ...] = Field(min_length=1)
    """what is passed, in order."""
    opening: Opening | None = None
    """what holds for every gate that has an orientation and does not say otherwise: size, depth, frame. None: nothing."""
    laps: int = Field(default=1, ge=1, le=MOST_LAPS)
    """how often the gates are flown."""
    closed: bool = False
    """whether the last lap ends at the first gate, which is passed and counted once more."""
    end: Vector3 | None = None
    """[m] (world) where the plan ends; passed like a gate but not counted. None: at the last gate."""
    end_at_rest: bool = False
    """whether the plan ends at rest, level; else at any speed."""
    floor: float | None = None
    """[m] (world) height below which the drone has crashed, once it has taken off. None: there is none."""
    ceiling: float | None = None
    """[m] (world) height above which the drone has crashed. None: there is none."""
    box: Box | None = None
    """what the flight must not leave. None: it may go anywhere."""
    poles: tuple[Pole, ...] = ()
    """vertical cylinders that must not be touched."""
    spheres: tuple[Sphere, ...] = ()
    """balls that must not be touched."""
    boxes: tuple[Box, ...] = ()
    """boxes that must not be touched."""
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
        if len(self.gates) * self.laps > MOST_GATES:
            raise ValueError(f"gates: there are {len(self.gates) * self.laps} in all laps, and may be {MOST_GATES}")
        for kind in ("poles", "spheres", "boxes"):
            if len(getattr(self, kind)) > MOST_OBSTACLES:
                raise ValueError(f"{kind}: there are {len(getattr(self, kind))}, and may be {MOST_OBSTACLES}")
        points, keys = np.vstack([self.start, self.waypoints]), ["start", *(point.key for point in self.route)]
        names = ["the start", *(point.name for point in self.route)]
        extents = np.abs(points).max(axis=1)
        if extents.max() > LARGEST:
            raise ValueError(f"{keys[int(extents.argmax())]}: a coordinate of {extents.max():.3g} m; coordinates are in metres")
        gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if gaps.min() < 1e-6:
            i = int(gaps.argmin())
            raise ValueError(f"{keys[i + 1]}: {names[i + 1]} is at the same point as {names[i]}, just before it")
        if gaps.sum() < SHORTEST:
            raise ValueError(f"gates: the whole track is {gaps.sum():.2g} m long; coordinates are in metres, not in degrees")
        if not any(gate.counts for gate in self.gates):
            raise ValueError("gates: none of them counts")
        self._within(points, names)
        self._open()
        return self

    def _open(self) -> None:
        """Refuse depths and frames around nothing, and an opening that no gate has."""
        if self.opening is not None and not any(gate.oriented for gate in self.gates):
            raise ValueError(
                "opening: no gate has it, for none has an orientation; give them the heading in which they are passed, yaw [rad]"
            )
        for point in self.route:
            key = next((name for name in ("depth", "frame") if getattr(point.gate, name)), None)
            if key and not point.gate.shaped:
                raise ValueError(f"{point.key}.{key}: needs an opening: radius, side, width and height, or corners")

    def _within(self, points: NDArray[np.float64], names: list[str]) -> None:
        """Refuse points below the floor, above the ceiling or outside of the box."""
        lowest, highest = int(points[:, 2].argmin()), int(points[:, 2].argmax())
        if self.floor is not None and points[lowest, 2] < self.floor:
            raise ValueError(f"floor: {self.floor:g} m lies above {names[lowest]} at z = {points[lowest, 2]:g} m")
        if self.ceiling is not None and points[highest, 2] > self.ceiling:
            raise ValueError(f"ceiling: {self.ceiling:g} m lies below {names[highest]} at z = {points[highest, 2]:g} m")
        if self.floor is not None and self.ceiling is not None and self.floor >= self.ceiling:
            raise ValueError(f"ceiling: {self.ceiling:g} m does not lie above the floor at {self.floor:g} m")
        if self.box is not None:
            outside = ((points < self.box.low) | (points > self.box.high)).any(axis=1)
            if outside.any():
                raise ValueError(f"box: {names[int(outside.argmax())]} lies outside of it")

    @property
    def route(self) -> tuple[Waypoint, ...]:
        """Everything that is planned through, in the order flown: gates of all laps, points that do not count, and the end."""
        found: list[Waypoint] = []
        for lap in range(self.laps):
            of_lap = f" of lap {lap + 1}" if self.laps > 1 else ""
            counted = 0
            for k, gate in enumerate(self.gates):
                counted += gate.counts
                name = f"gate {counted}" if gate.counts else f"point {k + 1}"
                found.append(Waypoint(name + of_lap, f"gates[{k}]", gate.completed(self.opening), gate.counts))
        if self.closed:
            found.append(replace(found[0], name=f"{found[0].name.removesuffix(' of lap 1')} at the end"))
        if self.end is not None:
            found.append(Waypoint("the end", "end", Gate(position=self.end), counts=False))
        return tuple(found)

    @property
    def counted(self) -> tuple[Gate, ...]:
        """The gates that a flight has to pass, in the order flown, those of all laps."""
        return tuple(point.gate for point in self.route if point.counts)

    @property
    def gate_numbers(self) -> tuple[int, ...]:
        """By which they are called, from 1 in each lap, in the order flown."""
        of_lap = sum(gate.counts for gate in self.gates)
        return tuple(k % of_lap + 1 for k in range(len(self.counted)))

    @property
    def gate_positions(self) -> NDArray[np.float64]:
        """Of the gates that a flight has to pass, in the order flown, shape (gates, 3) [m] (world)."""
        return np.array([gate.position for gate in self.counted])

    @property
    def waypoints(self) -> NDArray[np.float64]:
        """Of everything that is planned through, shape (waypoints, 3) [m] (world)."""
        return np.array([point.gate.position for point in self.route])

    @property
    def has_openings(self) -> bool:
        """Whether a gate that counts has an opening or an orientation, so that more than a distance decides about it."""
        return any(gate.shaped or gate.oriented for gate in self.counted)

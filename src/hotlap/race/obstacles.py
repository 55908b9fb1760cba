"""Obstacles: what stands in the way of a flight and must not be touched, and the box that it must not leave."""

from __future__ import annotations

from pydantic import model_validator

from hotlap.race.schema import Coordinate, Described, Place, Size


class Pole(Described):
    """A vertical cylinder."""

    position: tuple[Coordinate, Coordinate]
    """[m] (world) its axis: x and y."""
    radius: Size
    """[m] half of its thickness."""
    top: Coordinate | None = None
    """[m] (world) height of its upper end. None: endless."""
    bottom: Coordinate | None = None
    """[m] (world) height of its lower end. None: endless."""

    @model_validator(mode="after")
    def _upright(self) -> Pole:
        if self.top is not None and self.bottom is not None and self.top <= self.bottom:
            raise ValueError("top: does not lie above bottom")
        return self


class Sphere(Described):
    """A ball."""

    position: Place
    """[m] (world) its centre."""
    radius: Size
    """[m] of it."""


class Box(Described):
    """A box along the axes of the world."""

    low: Place
    """[m] (world) its corner with the least x, y and z."""
    high: Place
    """[m] (world) its corner with the largest x, y and z."""

    @model_validator(mode="after")
    def _ordered(self) -> Box:
        for axis, low, high in zip("xyz", self.low, self.high, strict=True):
            if low >= high:
                raise ValueError(f"low: its {axis} of {low:g} is not below that of high, {high:g}")
        return self

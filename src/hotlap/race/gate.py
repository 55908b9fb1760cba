"""Gate: a point to pass, or an opening in a frame, with its place, orientation and passing direction."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import field_validator, model_validator

from hotlap.race.schema import LARGEST, Described, Size, Thickness, Vector3

MOST_CORNERS = 12
FLAT = 1e-9  # m^2: what an area below counts as nothing
SHAPES = ("radius", "side", "width", "height", "corners")  # keys that give an opening its size


class PassingDirection(StrEnum):
    """The way in which a gate has to be passed.

    FORWARD: along its normal.
    BACKWARD: against its normal.
    EITHER: both count.
    """

    FORWARD = "forward"
    BACKWARD = "backward"
    EITHER = "either"


class Opening(Described):
    """The hole of a gate: a circle, a square, a rectangle or a convex polygon, and the frame around it."""

    radius: Size | None = None
    """[m] of a round opening; without an orientation, of a ball around the position."""
    side: Size | None = None
    """[m] of a square opening."""
    width: Size | None = None
    """[m] of a rectangular opening, to left and right."""
    height: Size | None = None
    """[m] of a rectangular opening, up and down."""
    corners: tuple[tuple[float, float], ...] = ()
    """[m] (gate) of a convex opening: (left, up) from the position, in either order around it."""
    depth: Thickness = 0.0
    """[m] length of a tunnel along the normal, half of it on each side of the position."""
    frame: Thickness = 0.0
    """[m] width of the solid frame around the opening, which must not be touched; 0: no frame."""

    @field_validator("corners")
    @classmethod
    def _convex(cls, corners: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        if not corners:
            return corners
        if not 3 <= len(corners) <= MOST_CORNERS:
            raise ValueError(f"a polygon has 3 to {MOST_CORNERS} corners, not {len(corners)}")
        points = np.array(corners)
        if np.abs(points).max() > LARGEST:
            raise ValueError(f"a corner {np.abs(points).max():.3g} m from the position; corners are in metres")
        along = np.roll(points, -1, axis=0) - points
        offsets = points[None] - points[:, None]
        areas = along[:, None, 0] * offsets[..., 1] - along[:, None, 1] * offsets[..., 0]  # of every corner over every edge
        ends = np.eye(len(points), dtype=bool) | np.roll(np.eye(len(points), dtype=bool), 1, axis=1)
        if not ((areas[~ends] > FLAT).all() or (areas[~ends] < -FLAT).all()):
            raise ValueError("the corners are not those of a convex polygon, one after the other around it")
        inside = points[:, 0] * along[:, 1] - points[:, 1] * along[:, 0]
        if not ((inside > 0).all() or (inside < 0).all()):
            raise ValueError("the gate's position lies outside of its corners")
        return corners

    @model_validator(mode="after")
    def _one_shape(self) -> Opening:
        shapes = {"radius": self.radius, "side": self.side, "width": self.width or self.height, "corners": self.corners or None}
        given = [name for name, value in shapes.items() if value is not None]
        if len(given) > 1:
            raise ValueError(f"{given[1]}: the opening is given by {given[0]} already")
        if (self.width is None) != (self.height is None):
            missing = "height" if self.height is None else "width"
            raise ValueError(f"{missing}: is missing; a rectangular opening has width and height")
        return self

    @property
    def shaped(self) -> bool:
        """Whether size or shape are given."""
        return bool(self.radius or self.side or self.width or self.corners)

    @property
    def polygon(self) -> NDArray[np.float64]:
        """Corners (left, up), counter-clockwise seen against the normal, shape (k, 2) [m] (gate); (0, 2) where it is round or not given."""
        if self.corners:
            points = np.array(self.corners)
            area = float((points[:, 0] * np.roll(points[:, 1], -1) - points[:, 1] * np.roll(points[:, 0], -1)).sum())
            return points if area > 0 else points[::-1]
        width, height = (self.side, self.side) if self.side else (self.width, self.height)
        if not width or not height:
            return np.empty((0, 2))
        return np.array([[width, height], [-width, height], [-width, -height], [width, -height]]) / 2


class Placement(Described):
    """Where a gate stands and how it is turned."""

    position: Vector3
    """[m] (world) its centre."""
    yaw: float | None = None
    """[rad] heading of its normal, the way in which it is passed. None: a point, passed either way, unless it has a pitch or roll."""
    pitch: float = 0.0
    """[rad] turns the normal down, after the yaw; pi/2: a gate that lies flat and is passed downwards."""
    roll: float = 0.0
    """[rad] turns the opening around the normal, last."""

    @field_validator("yaw", "pitch", "roll")
    @classmethod
    def _radians(cls, angle: float | None) -> float | None:
        if angle is not None and abs(angle) > 2 * math.pi:
            raise ValueError(f"{angle:g} rad is more than a full turn; angles are in radians (did you mean {math.radians(angle):.4g}?)")
        return angle

    @property
    def oriented(self) -> bool:
        """Whether it has an orientation."""
        return self.yaw is not None or self.pitch != 0 or self.roll != 0

    @property
    def rotation(self) -> NDArray[np.float64]:
        """World from gate, shape (3, 3): its columns are the normal, left and up."""
        cy, sy = math.cos(self.yaw or 0.0), math.sin(self.yaw or 0.0)
        cp, sp, cr, sr = math.cos(self.pitch), math.sin(self.pitch), math.cos(self.roll), math.sin(self.roll)
        about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1.0]])
        about_y = np.array([[cp, 0, sp], [0, 1.0, 0], [-sp, 0, cp]])
        about_x = np.array([[1.0, 0, 0], [0, cr, -sr], [0, sr, cr]])
        return about_z @ about_y @ about_x


class Gate(Opening, Placement):
    """What a flight has to pass: a bare point, a ball, or an opening with an orientation."""

    direction: PassingDirection = PassingDirection.FORWARD
    """the way in which it has to be passed, where it has an orientation."""
    counts: bool = True
    """whether a flight has to pass it; a point that does not count is only planned through."""

    @model_validator(mode="before")
    @classmethod
    def _bare_position(cls, gate: Any) -> Any:
        """A gate may be written as a bare [x, y, z]."""
        table = {"position": gate} if isinstance(gate, (list, tuple)) else gate
        return {key: _as_tuples(value) for key, value in table.items()} if isinstance(table, dict) else table

    @model_validator(mode="after")
    def _turned(self) -> Gate:
        needing = {
            "direction": self.direction is PassingDirection.BACKWARD,
            "side": self.side,
            "width": self.width,
            "corners": self.corners,
            "depth": self.depth,
            "frame": self.frame,
        }
        key = next((name for name, value in needing.items() if value), None)
        if key and not self.oriented:
            raise ValueError(f"yaw: is missing; a gate with {key} needs the heading [rad] in which it is passed")
        return self

    def completed(self, opening: Opening | None) -> Gate:
        """With what an opening says and the gate does not: its shape, its depth and its frame; only where the gate has an orientation."""
        if opening is None or not self.oriented:
            return self
        said = {name: getattr(self, name) or getattr(opening, name) for name in ("depth", "frame")}
        shape = {} if self.shaped else {name: getattr(opening, name) for name in SHAPES}
        return self.model_copy(update={**shape, **said})


def _as_tuples(value: Any) -> Any:
    """Lists of a file as tuples: strict validation takes no list for them."""
    return tuple(_as_tuples(part) for part in value) if isinstance(value, list) else value

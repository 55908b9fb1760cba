"""Frames of an SDF model: where its links are, by the poses of links, joints and models within the model."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.importers.bodies import Body
from hotlap.importers.markup import Markup
from hotlap.importers.turning import rotation_of

Floats = NDArray[np.float64]
DEEPEST = 20  # frames that may stand on one another
MODEL = "__model__"  # the word of SDF for the model itself


@dataclass(frozen=True)
class Pose:
    """A frame seen from another.

    Attributes:
        rotation: shape (3, 3).
        position: shape (3,) [m].
    """

    rotation: Floats
    position: Floats

    def then(self, inner: Pose) -> Pose:
        """A frame within this one, seen from where this one is seen."""
        return Pose(self.rotation @ inner.rotation, self.position + self.rotation @ inner.position)


HERE = Pose(np.eye(3), np.zeros(3))


def links_of(model: Markup, outer: Pose = HERE) -> dict[str, tuple[Markup, Pose]]:
    """The links of a model and of those within it, by name, with their poses in it.

    Args:
        model: an element <model>.
        outer: the pose of the model itself.

    Raises:
        InputError: a pose is no pose, or leads round in a circle.
    """
    frames = {frame.name: frame for tag in ("joint", "link", "frame", "model") for frame in model.all(tag)}
    found = {link.name: (link, outer.then(_locate(link, frames))) for link in model.all("link")}
    for inner in model.all("model"):
        within = links_of(inner, outer.then(_locate(inner, frames)))
        found |= {f"{inner.name}::{name}": place for name, place in within.items()}
    return found


def body_of(link: Markup, pose: Pose) -> Body | None:
    """Mass and inertia of a link; None where the file gives it none.

    Raises:
        InputError: they are not numbers.
    """
    inertial = link.first("inertial")
    if inertial is None:
        return None
    own = pose.then(own_pose(inertial))
    moments = inertial.one("inertia")
    xx, yy, zz = (moments.number(key) for key in ("ixx", "iyy", "izz"))
    xy, xz, yz = (moments.number(key) if moments.first(key) is not None else 0.0 for key in ("ixy", "ixz", "iyz"))
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Body(inertial.one("mass").content.positive(), own.position, own.rotation @ inertia @ own.rotation.T)


def _locate(frame: Markup, frames: Mapping[str, Markup], depth: int = 0) -> Pose:
    """Where a frame is, seen from its model."""
    if depth > DEEPEST:
        raise frame.fault("its pose stands on itself, by relative_to")
    pose, below = frame.first("pose"), ""
    if pose is not None:
        below = pose.element.get("relative_to", "")
    if not below and frame.tag == "joint":
        below = "".join((frame.one("child").element.text or "").split())
    if below in {"", MODEL}:
        return own_pose(frame)
    if below not in frames:
        raise frame.fault(f"its pose is relative to {below}, which is not there")
    return _locate(frames[below], frames, depth + 1).then(own_pose(frame))


def own_pose(element: Markup) -> Pose:
    """The pose that an element has by itself."""
    pose = element.first("pose")
    if pose is None or not (pose.element.text or "").strip():
        return HERE
    x, y, z, *angles = pose.content.vector(6)
    if pose.element.get("degrees") in {"true", "1"}:
        angles = [math.radians(angle) for angle in angles]
    return Pose(rotation_of(*angles), np.array([x, y, z]))

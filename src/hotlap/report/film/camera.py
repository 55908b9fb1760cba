"""Camera: how a scene in space becomes flat: from above at a slant, along the shorter side of the track, without perspective."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SLANT = math.radians(38)  # of the camera above the horizon
TURN = math.radians(12)  # off the track's long axis, so that straights do not hide behind each other


@dataclass(frozen=True)
class Camera:
    """A direction to look in.

    Attributes:
        right: shape (3,) what runs to the right (world).
        up: shape (3,) what runs up (world).
    """

    right: Floats
    up: Floats

    def project(self, points: Floats) -> Floats:
        """World positions, shape (..., 3) [m], in the picture, shape (..., 2) [m]."""
        return np.stack([points @ self.right, points @ self.up], axis=-1)


def aim(points: Floats) -> Camera:
    """A camera that sees points, shape (n, 3), with their longest horizontal extent across."""
    flat = points[:, :2] - points[:, :2].mean(axis=0)
    along = np.linalg.svd(flat, full_matrices=False)[2][0]
    angle = math.atan2(along[1], along[0])
    if math.cos(angle) < 0:  # x or y to the right, as far as that can be chosen
        angle += math.pi
    angle += TURN
    right = np.array([math.cos(angle), math.sin(angle), 0.0])
    away = np.array([-math.sin(angle), math.cos(angle), 0.0])
    return Camera(right, math.sin(SLANT) * away + math.cos(SLANT) * np.array([0.0, 0.0, 1.0]))


def rings(centres: Floats, normals: Floats, radius: float, points: int = 33) -> Floats:
    """Circles in space, shape (n, points, 3) [m].

    Args:
        centres: shape (n, 3) [m].
        normals: shape (n, 3), of any length; upright circles face along them where they are 0.
        radius: [m]
        points: of each, the last on the first.
    """
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    axes = np.where(lengths > 1e-9, normals / np.maximum(lengths, 1e-9), [1.0, 0.0, 0.0])
    helper = np.where(np.abs(axes[:, 2:]) > 0.9, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    first = np.cross(axes, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(axes, first)
    angles = np.linspace(0, 2 * np.pi, points)[:, None]
    return centres[:, None] + radius * (np.cos(angles) * first[:, None] + np.sin(angles) * second[:, None])

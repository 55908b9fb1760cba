"""Random tracks: drawn from a seed, for experiments that must not use the built-in tracks."""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from hotlap.race.track import Gate, Track

Floats = NDArray[np.float64]

SPACING = (7.0, 16.0)  # m, between gates along the way
GATES = (8, 14)  # least and largest number
SCATTER = 1.5  # m, of each gate around the layout's curve


class TrackStyle(StrEnum):
    """What a random track is like as a whole."""

    FLAT = "flat"
    CLIMB = "climb"
    DROP = "drop"
    LOOP = "loop"
    SPIRAL = "spiral"


def random_track(seed: int, layout: TrackStyle | None = None) -> Track:
    """A track drawn from a seed: the same seed gives the same track.

    Args:
        seed: not negative.
        layout: what it is like; None draws that too.
    """
    rng = np.random.default_rng([seed, 0x7261636B])  # "rack": no other stream begins so
    drawn = list(TrackStyle)[int(rng.integers(len(TrackStyle)))]
    layout = drawn if layout is None else layout
    count = int(rng.integers(GATES[0], GATES[1] + 1))
    points = _curve(layout, count + 2, rng) + SCATTER * rng.standard_normal((count + 2, 3)) * np.array([1.0, 1.0, 0.5])
    points = np.round(points, 3)
    heading = math.atan2(*(points[1] - points[0])[1::-1])
    return Track(
        name=f"{layout}-{seed}",
        start=tuple(points[0].tolist()),
        attitude=(math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)),
        gates=tuple(Gate(position=tuple(point)) for point in points[1:-1].tolist()),
        end=tuple(points[-1].tolist()),
        provenance=f"hotlap.race.random_tracks.random_track({seed}, {layout.value})",
    )


def _curve(layout: TrackStyle, count: int, rng: np.random.Generator) -> Floats:
    """Points along the layout's curve, shape (count, 3)."""
    steps = rng.uniform(*SPACING, count - 1)
    if layout is TrackStyle.LOOP:
        return _vertical_loops(steps, rng)
    turns = (
        rng.uniform(-0.9, 0.9, count - 1)
        if layout is not TrackStyle.SPIRAL
        else np.full(count - 1, rng.choice([-1, 1]) * rng.uniform(0.6, 1.2))
    )
    if layout is TrackStyle.SPIRAL:
        steps = steps * np.linspace(1.4, 0.6, count - 1)
    headings = rng.uniform(0, 2 * np.pi) + np.cumsum(turns)
    slopes = {
        TrackStyle.FLAT: np.zeros(count - 1),
        TrackStyle.CLIMB: rng.uniform(-0.1, 0.7, count - 1),
        TrackStyle.DROP: np.where(rng.random(count - 1) < 0.3, rng.uniform(-1.4, -0.8, count - 1), rng.uniform(-0.1, 0.4, count - 1)),
        TrackStyle.SPIRAL: np.full(count - 1, rng.uniform(-0.2, 0.2)),
    }[layout]
    legs = np.stack([np.cos(headings) * np.cos(slopes), np.sin(headings) * np.cos(slopes), np.sin(slopes)], axis=1) * steps[:, None]
    return np.vstack([np.zeros(3), np.cumsum(legs, axis=0)])


def _vertical_loops(steps: Floats, rng: np.random.Generator) -> Floats:
    """Straight ahead, then up and back over itself, down again, and on."""
    pitch = np.cumsum(np.where(np.arange(len(steps)) % 6 < 2, 0.0, rng.uniform(0.9, 1.4, len(steps))))
    drift = rng.uniform(-0.4, 0.4, len(steps))
    legs = np.stack([np.cos(pitch), drift, np.sin(pitch)], axis=1)
    return np.vstack([np.zeros(3), np.cumsum(legs / np.linalg.norm(legs, axis=1)[:, None] * steps[:, None], axis=0)])

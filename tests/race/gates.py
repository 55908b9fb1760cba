"""Gates and planes of gates that tests draw."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st

from hotlap.race.gate import Gate, PassingDirection

angles = st.floats(-math.pi, math.pi)
sizes = st.floats(0.1, 5.0)
places = st.tuples(*[st.floats(-100.0, 100.0)] * 3)
across = st.tuples(*[st.floats(-8.0, 8.0)] * 2)  # left, up


def regular(corners: int, radius: float, turned: float = 0.0) -> tuple[tuple[float, float], ...]:
    """A regular polygon around the origin, by the radius [m] of its corners."""
    around = turned + 2 * math.pi * np.arange(corners) / corners
    return tuple((float(radius * math.cos(angle)), float(radius * math.sin(angle))) for angle in around)


shapes = st.one_of(
    st.builds(lambda radius: {"radius": radius}, sizes),
    st.builds(lambda side: {"side": side}, sizes),
    st.builds(lambda width, height: {"width": width, "height": height}, sizes, sizes),
    st.builds(lambda *shape: {"corners": regular(*shape)}, st.integers(3, 12), sizes, angles),
)

oriented_gates = st.builds(
    lambda place, yaw, pitch, roll, shape, direction: Gate(position=place, yaw=yaw, pitch=pitch, roll=roll, direction=direction, **shape),
    places,
    angles,
    angles,
    angles,
    shapes,
    st.sampled_from(PassingDirection),
)

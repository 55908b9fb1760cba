"""Manoeuvre: the minute of flight that tells most of a quadrotor's numbers: hover, doublets, thrust steps, fast straights."""

from __future__ import annotations

from dataclasses import dataclass

WORDS = {
    "hover": "5 s of hover",
    "roll": "roll doublets: quick stick left, right and back to the middle, a quarter of a second each, large and small",
    "pitch": "pitch doublets: quick stick forward, back and to the middle",
    "yaw": "yaw doublets: quick stick left and right, half a second each",
    "thrust": "thrust steps: climbs and sinks of half a second with the throttle at once up, at once down",
    "battery": "fly on until the battery is nearly empty, with thrust steps at the end, too",
    "straights": "fast straights forward and back, then left and right, with the nose where it was",
}
"""Parts of the suggested flight, in words for a pilot."""


@dataclass(frozen=True)
class Push:
    """Something that is added to what a controller of position asks for.

    Attributes:
        begin, end: [s].
        axis: 0 thrust, 1 roll rate, 2 pitch rate, 3 yaw rate.
        size: [rad/s], or a share of the weight for thrust.
    """

    begin: float
    end: float
    axis: int
    size: float


def doublets(begin: float, axis: int, sizes: tuple[float, ...], held: float, apart: float) -> list[Push]:
    """There and back, then there again for half the time and back: the attitude ends where it began."""
    pushes, at = [], begin
    for size in sizes:
        pushes += [
            Push(at, at + held, axis, size),
            Push(at + held, at + 3 * held, axis, -size),
            Push(at + 3 * held, at + 4 * held, axis, size),
        ]
        at += 4 * held + apart
    return pushes


def one_minute() -> tuple[Push, ...]:
    """The pushes of the suggested flight; the straights, from second 42 on, are targets of a position controller."""
    steps = [(25.0, 0.8), (25.5, -0.5), (27.5, -0.6), (28.0, 0.8), (30.0, 1.5), (30.3, -0.7), (33.0, -0.7), (33.4, 0.9)]
    steps += [(36.0, 1.0), (36.4, -0.6), (39.0, -0.6), (39.5, 1.0)]
    lengths = [0.5, 0.7, 0.5, 0.4, 0.3, 0.6, 0.4, 0.4, 0.4, 0.6, 0.5, 0.4]
    thrusts = [Push(begin, begin + held, 0, size) for (begin, size), held in zip(steps, lengths, strict=True)]
    roll = doublets(4.0, 1, (1.5, 3.0, -2.5, 1.0), 0.15, 1.0)
    pitch = doublets(11.0, 2, (1.5, 3.0, -2.5, 1.0), 0.15, 1.0)
    yaw = doublets(18.0, 3, (0.8, -1.2), 0.4, 1.2)
    return (*roll, *pitch, *yaw, *thrusts)


STRAIGHTS = 42.0  # s at which they begin
SECONDS = 60.0

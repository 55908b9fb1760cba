"""Ground: stretches of a log in which the drone stands, and no command moves it.

A rotor that does not push leaves a drone in free fall. Who is pushed up with 1 g while the throttle is near zero stands on something.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from hotlap.core.records import Floats
from hotlap.identification.held import Held
from hotlap.logs.flight_log import Signal
from hotlap.race.quadrotor import GRAVITY

Mask = NDArray[np.bool_]

BIN, SPAN = 0.1, 5  # s of a mean, and means that are averaged: half a second
STILL, MOVING = 0.15, 0.3  # rad/s that who stands does not exceed; from which on a drone flies
NEAR_G = 0.15  # share of gravity
SUPPORTED, PUSHED = 0.5 * GRAVITY, 0.3 * GRAVITY  # m/s^2: more than a fall; enough for a ratio of thrust and throttle
IDLE, NOTHING = 0.4, 0.02  # share of the throttle of hover, and throttle, below which nothing flies
LIFTING = 0.9  # share of the throttle of hover that lifts off
LEAST, MOST_RAMP = 1.0, 2.0  # s of a stretch; from idle to lift-off, and from touchdown to idle


def ground(signals: Mapping[str, Signal], start: float, end: float) -> Floats:
    """Stretches on the ground: where it stands with the throttle near zero, before take-off and after landing.

    Args:
        signals: of a log; without thrust or motor commands nothing can be said.
        start: [s] from which on they are looked for.
        end: [s] up to which.

    Returns:
        Begin and end of each, shape (G, 2) [s], in order.
    """
    throttle = _throttle(signals)
    if throttle is None or end - start < LEAST:
        return np.empty((0, 2))
    edges = start + BIN * np.arange(int((end - start) / BIN) + 1, dtype=np.float64)
    share = throttle.means(edges)[:, 0]
    turning = np.sqrt(_smooth((Held(signals["rates"].times, signals["rates"].values).means(edges) ** 2).sum(axis=1)))
    push = _push(signals, edges)
    usual = _smooth(share)
    hover = _hover(usual, turning, push)
    idle, near = usual < max(NOTHING, IDLE * hover), np.abs(push - GRAVITY) < NEAR_G * GRAVITY
    stands = idle & near & (turning < STILL)
    off = idle & (push > SUPPORTED)  # before the first and after the last throttle it may be carried, too
    stands[: _leading(off)] = True
    stands[len(off) - _leading(off[::-1]) :] = True
    ramp, lifting = round(MOST_RAMP / BIN), share >= LIFTING * hover
    found = []
    for first, last in _runs(stands):
        if (last - first) * BIN >= LEAST:
            before = np.flatnonzero(lifting[max(first - ramp, 0) : first])
            after = np.flatnonzero(lifting[last : last + ramp])
            a = max(first - ramp, 0) + int(before[-1]) + 1 if len(before) else max(first - ramp, 0)
            b = last + int(after[0]) if len(after) else min(last + ramp, len(share))
            found.append((start if a == 0 else edges[a], end if b == len(share) else edges[b]))
    return _merged(found)


def _throttle(signals: Mapping[str, Signal]) -> Held | None:
    """What the rotors are asked for: the thrust command, else the mean of the motors."""
    if "thrust_command" in signals:
        return Held(signals["thrust_command"].times, signals["thrust_command"].values)
    if "motor_command" in signals:
        motors = signals["motor_command"]
        return Held(motors.times, motors.values.mean(axis=1, keepdims=True))
    return None


def _push(signals: Mapping[str, Signal], edges: Floats) -> Floats:
    """Size of the mean specific force over half a second [m/s^2]: measured, else by differences of the velocity, else as in hover."""
    if "acceleration" in signals:
        force = Held(signals["acceleration"].times, signals["acceleration"].values).means(edges)
    elif "velocity" in signals:
        velocity = signals["velocity"]
        at = velocity.at(np.clip(edges, velocity.times[0], velocity.times[-1]))
        force = np.diff(at, axis=0) / BIN + [0.0, 0.0, GRAVITY]
    else:
        return np.full(len(edges) - 1, GRAVITY)
    return np.asarray(np.linalg.norm(np.column_stack([_smooth(column) for column in force.T]), axis=1))


def _hover(share: Floats, turning: Floats, push: Floats) -> float:
    """About the throttle that hovers: of what is steady at 1 g the highest, and by how much throttle pushes while it turns."""
    flies = (turning > MOVING) & (push > PUSHED)
    if not np.ptp(push) and flies.any():  # nothing tells it
        return float(np.median(share[flies]))
    steady = share[(turning < MOVING) & (np.abs(push - GRAVITY) < NEAR_G * GRAVITY)]
    found = [float(np.percentile(steady, 95))] if len(steady) else []
    found += [float(np.median(share[flies] * GRAVITY / push[flies]))] if flies.any() else []
    return max(found, default=0.0)


def _smooth(column: Floats) -> Floats:
    return np.asarray(uniform_filter1d(column, SPAN, mode="nearest"))


def _leading(mask: Mask) -> int:
    """How many are true before the first that is not."""
    return len(mask) if mask.all() else int(np.argmin(mask))


def _runs(mask: Mask) -> list[tuple[int, int]]:
    """First and behind the last of each run that is true."""
    turns = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return list(zip(turns[::2].tolist(), turns[1::2].tolist(), strict=True))


def _merged(stretches: list[tuple[float, float]]) -> Floats:
    """Stretches that do not overlap."""
    found = list[list[float]]()
    for begin, end in stretches:
        if found and begin <= found[-1][1]:
            found[-1][1] = max(end, found[-1][1])
        else:
            found.append([begin, end])
    return np.array(found, dtype=np.float64).reshape(-1, 2)

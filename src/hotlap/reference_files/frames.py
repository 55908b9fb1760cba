"""Frames: files in other frames than the track's, told by whether the flight passes the gates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.race.race import GateRule, Race
from hotlap.reference.attitude import product
from hotlap.reference.reference import PERIOD
from hotlap.reference_files.passages import MissedGateError, find_passages, targets_of
from hotlap.reference_files.resampling import between
from hotlap.reference_files.table import ACCELERATION, ATTITUDE, POSITION, RATES, TIME, VELOCITY, YAW, Table

Floats = NDArray[np.float64]

HALF_TURN = np.array([0.0, 1.0, 0.0, 0.0])  # about x
SWAP = np.sqrt(0.5) * np.array([0.0, 1.0, 1.0, 0.0])  # half a turn about x = y


@dataclass(frozen=True)
class _Frame:
    """A frame that a file may be written in.

    Attributes:
        name: in words.
        turn: shape (4,) the track's frame from the file's.
    """

    name: str
    turn: Floats


FRAMES = (
    _Frame("NED (z down): x, -y, -z are the track's x, y, z", HALF_TURN),
    _Frame("NED (z down): y, x, -z are the track's x, y, z", SWAP),
)


def in_track_frame(table: Table, race: Race) -> tuple[Table, Floats]:
    """A table in the frame of the track, and when it passes the gates, shape (gates,) [s] from its first row.

    As it stands, if it passes the gates so; else in the first of the other frames in which it does.

    Args:
        table: with velocities.
        race: its track and judge count.

    Raises:
        InputError: it begins elsewhere, or does not pass a gate, in any frame; what is said is about the file as it stands.
    """
    try:
        return table, _passages(table, race)
    except InputError as error:
        for frame in FRAMES:
            turned = _turned(table, frame)
            try:
                return turned.noted(f"read as {frame.name}"), _passages(turned, race)
            except InputError:
                continue
        raise error from None


def _passages(table: Table, race: Race) -> Floats:
    """When the file passes the gates of the track, shape (gates,) [s]."""
    values = table.values
    times, position, velocity = values[:, TIME] - values[0, TIME], values[:, POSITION], values[:, VELOCITY]
    away = float(np.linalg.norm(position[0] - np.array(race.track.start)))
    if away > race.judge.distance:
        reason = f"begins {away:.2f} m away from the start of {race.track.name}; at most {race.judge.distance:g} m (judge.distance)"
        raise table.error(0, "p_x", reason)
    if race.judge.rule is GateRule.OPENING:  # between coarse rows a straight line would cut corners
        fine = np.append(np.arange(0.0, times[-1], PERIOD), times[-1])
        position, velocity = between(times, position, velocity, fine)
        times = fine
    try:
        return find_passages(times, position, velocity, targets_of(race))
    except MissedGateError as error:
        raise InputError(table.source, error.gate, error.reason) from None


def _turned(table: Table, frame: _Frame) -> Table:
    """A table of world z down and body z down (forward, right, down), as one of z up."""
    values = table.values.copy()
    w, x, y, z = frame.turn
    matrix = 2 * np.outer([x, y, z], [x, y, z]) + (2 * w * w - 1) * np.eye(3)  # of half a turn: w = 0
    for columns in (POSITION, VELOCITY, ACCELERATION):
        values[:, columns] = values[:, columns] @ matrix.T
    values[:, ATTITUDE] = product(product(frame.turn[None], values[:, ATTITUDE]), -HALF_TURN[None])
    values[:, RATES] *= np.array([1.0, -1.0, -1.0])
    heading = matrix[:2, :2] @ np.stack([np.cos(values[:, YAW]), np.sin(values[:, YAW])])
    values[:, YAW] = np.arctan2(heading[1], heading[0])
    return table.with_values(values)

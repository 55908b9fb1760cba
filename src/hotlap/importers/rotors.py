"""Rotors: arm, layout and thrust of a quadrotor from what other programs say of its rotors."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hotlap.files.content import Content
from hotlap.importers.imported import Findings
from hotlap.race.quadrotor import GRAVITY

ROTORS = 4
ON_AXIS = 0.2  # share of the larger lever below which a rotor sits on an axis
UNEQUAL = 0.02  # share by which levers may differ without a word
PER_MINUTE = 2 * math.pi / 60  # rad/s in a revolution a minute


def place_rotors(found: Findings, positions: NDArray[np.float64], where: Content) -> None:
    """Set arm and layout from where the rotors sit.

    Args:
        found: what is set, and told where the vehicle is not as symmetric as ours.
        positions: seen from the centre of mass, shape (rotors, 2) [m]: x forward, y left.
        where: what a fault is said of.

    Raises:
        InputError: there are not four of them, or they sit at the centre.
    """
    count_rotors(len(positions), where)
    levers = np.abs(positions)
    arms = np.linalg.norm(positions, axis=1)
    if not arms.min() > 0:
        raise where.fault("a rotor sits at the centre")
    plus = bool((levers.min(axis=1) < ON_AXIS * levers.max(axis=1)).all())
    arm = float(arms.mean())
    found.table |= {"arm": arm, "layout": "plus" if plus else "x"}
    found.taken.append(
        f"arm is the distance from the centre to a rotor, {arm:.4g} m from the rotors' positions; layout {found.table['layout']}"
    )
    lever = arm / (1 if plus else math.sqrt(2))
    pitching, rolling = (levers.max(axis=0) if plus else levers.mean(axis=0)) / lever
    if max(abs(pitching - 1), abs(rolling - 1)) > UNEQUAL:
        found.lost.append(
            f"rotor positions: levers of {rolling * lever:.4g} m for roll and {pitching * lever:.4g} m for pitch; "
            f"ours has {lever:.4g} m for both"
        )


def count_rotors(count: int, where: Content) -> None:
    """Refuse what has not four rotors.

    Raises:
        InputError: with their number.
    """
    if count != ROTORS:
        raise where.fault(f"has {count} rotor{'s' if count != 1 else ''}; hotlap flies vehicles with {ROTORS}")


def from_lever(found: Findings, lever: float, key: str) -> None:
    """Set arm and layout from the lever of an X, along each axis [m]."""
    found.table |= {"arm": lever * math.sqrt(2), "layout": "x"}
    found.taken.append(f"{key} is the lever along each axis of an X there; arm, from the centre to a rotor, is sqrt(2) times as long")


def from_diagonal(found: Findings, arm: float, key: str) -> None:
    """Set arm and layout from the distance between the centre and a rotor of an X [m]."""
    found.table |= {"arm": arm, "layout": "x"}
    found.taken.append(f"{key} is the distance from the centre to a rotor, as our arm")


def fill_radius(found: Findings, propeller: float, key: str) -> None:
    """Set the radius of the vehicle from that of a propeller [m], where four of that size have room on the arms."""
    arm = found.table["arm"]
    if 0 < propeller < arm * math.sqrt(0.5):
        found.table["radius"] = arm + propeller
        found.taken.append(f"radius, of the ball that the vehicle fills, is arm + {key}")
    elif propeller > 0:
        found.lost.append(f"{key} = {propeller:g} m: propellers of this radius would overlap; radius stays at 1.5 arms")


def squared(found: Findings, factor: float, speeds: Sequence[float], words: str) -> None:
    """Set rotor_thrust from thrust = k w^2.

    Args:
        found: what is set.
        factor: k [N s^2].
        speeds: least and largest w [1/s].
        words: how the largest is written there, for the remark.
    """
    least, largest = (factor * speed * speed for speed in speeds)
    found.table["rotor_thrust"] = [least, largest]
    found.taken.append(f"largest rotor_thrust = {words} = {largest:.4g} N")


def from_weight(found: Findings, ratio: float, words: str) -> None:
    """Set rotor_thrust from the largest thrust over the weight, of the whole vehicle."""
    found.table["rotor_thrust"] = [0.0, ratio * found.table["mass"] * GRAVITY / ROTORS]
    found.taken.append(f"{words} is the ratio of thrust to weight: a rotor's share is a quarter, with g = {GRAVITY} m/s^2")

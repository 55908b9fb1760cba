"""Mixers: what becomes of rotor thrusts beyond the limits of the rotors."""

from __future__ import annotations

from enum import StrEnum

LEAST_THROTTLE = 0.05  # share of the thrust below which the mixer "scale" controls no rates


class Mixer(StrEnum):
    """What becomes of rotor thrusts beyond the limits of the rotors.

    CLIP: each rotor is clipped by itself: collective thrust, torques, or both are not what was asked for.
    SCALE: all are lifted where one would be below the least, then all are scaled down where one would exceed the largest; below a throttle
        of 0.05 rates are not controlled. As AirSim's SimpleFlight does.
    BETAFLIGHT: torques are scaled down where they need more than the whole range, then the throttle moves so that they fit, with airmode;
        roll, pitch and yaw are limited one by one before. As Betaflight does.
    """

    CLIP = "clip"
    SCALE = "scale"
    BETAFLIGHT = "betaflight"

"""Gains: how the firmware is tuned for a vehicle unless its owner's lines say so.

Roll and pitch fly on stock gains. Stock gains of yaw are made for one kind of vehicle and swing on others, whose rotors have more or less
yaw torque over their inertia: yaw gets the gain that the quadrotor's file gives it, and an integral that is critically damped with it.
"""

from __future__ import annotations

import math

from hotlap.race.quadrotor import Quadrotor
from hotlap.worlds.betaflight.settings import IDLE

P_UNIT = 0.001835  # signal of a motor per rad/s of rate error and unit of P: 0.032029 / 1000 over a degree
I_UNIT = 0.01400  # signal of a motor per rad of integrated rate error and unit of I: 0.244381 / 1000 over a degree
HIGHEST_GAIN = 250  # that the command line takes
STOCK_I = 80  # of yaw


def yaw_gain(quadrotor: Quadrotor) -> float:
    """Angular acceleration of yaw per signal of the motors at hover, [rad/s^2]: rotor thrust is the square of output."""
    output = math.sqrt(quadrotor.mass * quadrotor.gravity / (4 * quadrotor.rotor_thrust[1]))
    thrust = 2 * quadrotor.rotor_thrust[1] * output * (1 - IDLE)
    return 4 * quadrotor.torque_ratio * thrust / quadrotor.inertia[2]


def gain_lines(quadrotor: Quadrotor) -> tuple[str, ...]:
    """Lines that tune the firmware for a quadrotor."""
    per_signal, wanted = yaw_gain(quadrotor), quadrotor.rate_gain[2]
    p = min(max(round(wanted / (per_signal * P_UNIT)), 1), HIGHEST_GAIN)
    i = min(max(round((p * P_UNIT) ** 2 * per_signal / (4 * I_UNIT)), 0), STOCK_I)
    return (f"set p_yaw = {p}", f"set i_yaw = {i}")

"""Gains: how the firmware is tuned for a vehicle unless its owner's lines say so.

A quadrotor whose file has a rate loop in signals of motor speed (`rate_loop` with the output "speed") gets the gains of that. Else roll and
pitch fly on stock gains. Stock gains of yaw are made for one kind of vehicle and swing on others, whose rotors have more or less yaw torque
over their inertia: yaw gets the gain that the quadrotor's file gives it, and an integral with which it overshoots little (damping 0.6).
"""

from __future__ import annotations

import math

from hotlap.dynamics.mixers import Mixer
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.rate_loop import LIMITS, Output, RateLoop
from hotlap.worlds.betaflight.settings import IDLE

P_UNIT = 0.001835  # signal of a motor per rad/s of rate error and unit of P: 0.032029 / 1000 over a degree
I_UNIT = 0.01400  # signal of a motor per rad of integrated rate error and unit of I: 0.244381 / 1000 over a degree
I_FACTORS = (1.0, 1.0, 2.5)  # by which the firmware multiplies I of roll, pitch and yaw
D_UNIT = 0.0000303  # signal of a motor per rad/s^2 of measured rates and unit of D: 0.000529 / 1000 over a degree
AXES = ("roll", "pitch", "yaw")
STOCK_P, STOCK_I = (45, 47), (80, 84)  # of roll and pitch
STOCK_D = (35, 40)  # in the middle: Betaflight raises D from 30 and 34 to 40 and 46 in fast turns
RELAXED = 0.1  # of the integral of roll and pitch that acts in flight: iterm_relax holds it while they turn
MOST_YAW_I = 80  # the stock gain
D_CUTOFF = 60.0  # Hz: of one filter in place of its two of 75 to 150 and 150 Hz
HIGHEST_GAIN = 250  # that the command line takes


def yaw_gain(quadrotor: Quadrotor) -> float:
    """Angular acceleration of yaw per signal of the motors at hover, [rad/s^2]: rotor thrust is the square of output."""
    output = math.sqrt(quadrotor.mass * quadrotor.gravity / (4 * quadrotor.rotor_thrust[1]))
    thrust = 2 * quadrotor.rotor_thrust[1] * output * (1 - IDLE)
    return 4 * quadrotor.torque_ratio * thrust / quadrotor.inertia[2]


def gain_lines(quadrotor: Quadrotor) -> tuple[str, ...]:
    """Lines that tune the firmware for a quadrotor."""
    loop = quadrotor.rate_loop
    if loop is not None and loop.output is Output.SPEED:
        return (*_lines_of(loop), f"set motor_idle = {round(1e4 * loop.idle)}")
    p, i = _yaw(quadrotor)
    return (f"set p_yaw = {p}", f"set i_yaw = {i}")


def rate_loop_of(quadrotor: Quadrotor) -> RateLoop:
    """The rate loop of the built-in world that is nearest to the firmware as `gain_lines` tune it; its mixer is "betaflight"."""
    loop = quadrotor.rate_loop
    if loop is not None and loop.output is Output.SPEED:
        return loop
    p, i = _yaw(quadrotor)
    return RateLoop(
        p=_times(P_UNIT, STOCK_P, p),
        i=(I_UNIT * RELAXED * STOCK_I[0], I_UNIT * RELAXED * STOCK_I[1], I_UNIT * I_FACTORS[2] * i),
        d=_times(D_UNIT, STOCK_D, 0),
        d_cutoff=D_CUTOFF,
        limit=LIMITS,
        output=Output.SPEED,
        idle=IDLE,
    )


def as_flown(quadrotor: Quadrotor) -> Quadrotor:
    """The quadrotor as the built-in world must know it to fly as the firmware flies it: with `rate_loop_of` and Betaflight's mixer."""
    return quadrotor.model_copy(update={"mixer": Mixer.BETAFLIGHT, "rate_loop": rate_loop_of(quadrotor)})


def _times(unit: float, both: tuple[int, int], yaw: int) -> tuple[float, float, float]:
    """Gains of roll, pitch and yaw in signals, from Betaflight's numbers."""
    return unit * both[0], unit * both[1], unit * yaw


def _lines_of(loop: RateLoop) -> list[str]:
    """Lines with the gains of a rate loop."""
    integral = (loop.i[0] / RELAXED, loop.i[1] / RELAXED, loop.i[2] / I_FACTORS[2])
    terms = (("p", P_UNIT, loop.p), ("i", I_UNIT, integral), ("d", D_UNIT, loop.d), ("d_max", D_UNIT, loop.d))
    return [
        f"set {term}_{axis} = {min(round(gain / unit), HIGHEST_GAIN)}"
        for term, unit, gains in terms
        for axis, gain in zip(AXES, gains, strict=True)
    ]


def _yaw(quadrotor: Quadrotor) -> tuple[int, int]:
    """P and I of yaw."""
    per_signal, wanted = yaw_gain(quadrotor), quadrotor.rate_gain[2]
    p = min(max(round(wanted / (per_signal * P_UNIT)), 1), HIGHEST_GAIN)
    i = min(round((p * P_UNIT) ** 2 * per_signal / (4 * I_UNIT)), MOST_YAW_I)
    return p, i

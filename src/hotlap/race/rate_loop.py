"""Rate loop and mixer of a flight controller: how it turns body rates that are asked for into rotor thrusts.

Rotor j gets the signal s_j = throttle + sum over the axes of m_ja u_a, from 0 to 1, with m_ja the rotor's lever about roll and pitch over
the longest lever of all, and its spin about yaw: 1 or -1 for four rotors in an X. The axes are PID controllers of the rate error.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from hotlap.race.schema import Described, NotNegative, Positive

Share = Annotated[float, Field(gt=0, le=1)]
LIMITS = (0.5, 0.5, 0.4)  # Betaflight's limits of roll, pitch and yaw: pidsum_limit and pidsum_limit_yaw over 1000
MOST_DELAY = 0.05  # s
THREE_ZEROS = (0.0, 0.0, 0.0)


class Output(StrEnum):
    """What the signal of a rotor, from 0 to 1, is proportional to."""

    THRUST = "thrust"
    SPEED = "speed"


class MotorLag(StrEnum):
    """What follows its command with the motors' time constants: the speed of a rotor, or its thrust."""

    SPEED = "speed"
    THRUST = "thrust"


class RateLoop(Described):
    """A PID rate loop with gains of its own, in signals of the rotors; `rate_gain` and `torque_damping` then do not count."""

    p: tuple[Positive, Positive, Positive]
    """[s/rad] (body) proportional gains: signal over rate error (SimpleFlight: 0.25; Betaflight: 0.001835 times its P)."""
    i: tuple[NotNegative, NotNegative, NotNegative] = THREE_ZEROS
    """[1/rad] (body) integral gains (Betaflight: 0.01400 times its I for yaw, a tenth of that for roll and pitch: iterm_relax)."""
    d: tuple[NotNegative, NotNegative, NotNegative] = THREE_ZEROS
    """[s^2/rad] (body) derivative gains, of the measured rates (Betaflight: 0.0000303 times its D)."""
    d_cutoff: NotNegative = 0.0
    """[Hz] cutoff of the first-order low-pass filter of the derivative; 0: no filter."""
    integral_limit: Positive = 0.4
    """[-] largest signal of the integral part of an axis."""
    limit: tuple[Share, Share, Share] = (1.0, 1.0, 1.0)
    """[-] (body) largest signal of an axis (Betaflight: [0.5, 0.5, 0.4])."""
    output: Output = Output.THRUST
    """what the signal of a rotor is proportional to; with "speed" the gain grows with throttle, as thrust is its square."""
    idle: float = Field(default=0.0, ge=0, lt=0.5)
    """[-] share of full speed at signal 0, for the output "speed" (Betaflight: 0.055)."""

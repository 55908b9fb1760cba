"""Plant kinds: which of the equations of motion a vehicle needs. Each kind has compiled code of its own.

The plain plant is that of most vehicles: four rotors in an X or a plus, a proportional rate loop, a mixer that clips. Of whom more is said
flies a detailed plant, made for its number of rotors, its mixer and its form of rate loop.
"""

from __future__ import annotations

from typing import NamedTuple

from hotlap.dynamics.mixers import Mixer
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.rate_loop import MotorLag

PLAIN = "plain"


class DetailedKind(NamedTuple):
    """What the code of a detailed plant is made for.

    Attributes:
        mixer: of the flight controller.
        pid: whether its rate loop has gains of its own, in signals of the rotors; else it is proportional, in torques.
        rotors: how many.
    """

    mixer: Mixer
    pid: bool
    rotors: int

    def __str__(self) -> str:
        return f"{self.mixer}-{'pid' if self.pid else 'torque'}-{self.rotors}"


def plant_kind_of(quadrotor: Quadrotor) -> str:
    """The name of the plant that flies a vehicle: `PLAIN`, or a `DetailedKind` as text."""
    says_more = (
        quadrotor.rotors is not None,
        quadrotor.mixer is not Mixer.CLIP,
        quadrotor.rate_loop is not None,
        quadrotor.motor_lag is not MotorLag.SPEED,
        quadrotor.rate_delay > 0,
        quadrotor.rotor_inertia > 0,
        quadrotor.inflow > 0,
    )
    return str(DetailedKind(quadrotor.mixer, quadrotor.rate_loop is not None, quadrotor.rotor_count)) if any(says_more) else PLAIN


def detailed_kind(name: str) -> DetailedKind:
    """The inverse of `DetailedKind.__str__`."""
    mixer, loop, rotors = name.split("-")
    return DetailedKind(Mixer(mixer), loop == "pid", int(rotors))

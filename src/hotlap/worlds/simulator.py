"""Simulator: the protocol of everything that is stepped: reset to a state, advance under commands, read the state.

`Stepped` makes a world of it: it keeps the clock, runs the controller, adds the noise and judges. A simulator knows physics alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import HotlapError

Floats = NDArray[np.float64]


class SimulatorError(HotlapError):
    """A simulator cannot be started, is silent, answers what nobody understands, or has ended: one line for people."""


@dataclass(frozen=True)
class Start:
    """How a flight begins.

    Attributes:
        state: shape (13,): position [m], attitude (w, x, y, z), velocity [m/s] (world), body rates [rad/s] (body).
        thrust_factor: by which this flight's thrust differs from the vehicle's, for simulators that can say it.
    """

    state: Floats
    thrust_factor: float = 1.0


class Simulator(Protocol):
    """One or several drones in a simulator, each in a lane of its own; frames and units are those of `race.quadrotor`.

    Attributes:
        lanes: L, drones that are flown at once; 1 for most.
        step: [s] of which every duration is a whole multiple.
        scales_thrust: whether it heeds `Start.thrust_factor`; else the world multiplies what it commands.

    A simulator whose own rate loop answers late may have `delay` besides, that dead time [s]: of the vehicle's the world adds the rest.

    Every method raises `SimulatorError` within its time-out when the simulator is lost; a simulator that has raised is closed and
    opened anew for the next flight.
    """

    lanes: int
    step: float
    scales_thrust: bool

    def reset(self, lane: int, start: Start) -> None:
        """Place a drone, its rotors as in hover, whatever it did before; other lanes stay as they are."""
        ...

    def advance(self, commands: Floats, duration: float) -> None:
        """Let all lanes fly for a duration [s] under commands that are held, shape (L, 4): thrust per mass [m/s^2], body rates [rad/s]."""
        ...

    def states(self) -> Floats:
        """Where the drones are now, shape (L, 13), as in `Start.state`."""
        ...

    def rotor_thrusts(self) -> Floats:
        """What the rotors give now, shape (L, rotors) [N], in the vehicle's order; NaN where the simulator does not tell."""
        ...

    def close(self) -> None:
        """Give back what it holds; may be called twice."""
        ...

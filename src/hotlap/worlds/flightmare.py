"""Flightmare: flightlib's quadrotor, through a small Python module that a user builds beside the library.

The module has a class `Quadrotor` without arguments, with

    reset()                    begin anew, rotors at rest
    set_state(state)           13 numbers: position, attitude (w, x, y, z), velocity, body rates; the rotors stay as they are
    step(thrusts, duration)    fly for a time [s] with four rotor thrusts [N]: front left, front right, back right, back left
    state()                    13 numbers, as above

and may have `rotor_thrusts()`, four numbers [N], and `BOX`, half of the length [m] of the box that flightlib keeps a drone in.
Single-rotor thrusts are sent because flightlib's own rate mode limits the collective thrust to 11.22 m/s^2 and rates to 6 rad/s.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.core.own_code import import_own
from hotlap.core.printable import printable
from hotlap.race.quadrotor import Quadrotor
from hotlap.reference.scenario import Scenario
from hotlap.worlds.rate_loop import RateLoop
from hotlap.worlds.simulator import SimulatorError, Start

Floats = NDArray[np.float64]
STEP = 0.0025  # s, of flightlib's integrator
SPIN_UP = 0.5  # s, ten times the slowest of its motors
HIGH = 10.0  # m, above the floor of its box
BOX = 100.0  # m
CALLS = ("reset", "set_state", "step", "state")


class Flightmare:
    """One quadrotor of a module; a `Simulator`.

    Args:
        name: of the module.
        drone: an instance of its `Quadrotor`.
        quadrotor: the vehicle, whose rate loop is ours.
        known_as: the vehicle as its rate loop knows it; None: as it is.
    """

    lanes, step, scales_thrust = 1, STEP, False

    def __init__(self, name: str, drone: Any, quadrotor: Quadrotor, known_as: Quadrotor | None = None) -> None:
        self._name, self._drone, self._rate_loop = name, drone, RateLoop(quadrotor, known_as)
        self._hover = np.full(4, quadrotor.mass * quadrotor.gravity / 4)
        self._thrusts, self._state = self._hover, np.zeros(13)

    def reset(self, lane: int, start: Start) -> None:  # noqa: ARG002  there is one lane
        """Place the drone, its rotors spun up to hover: flightlib stops them at every reset."""
        self._call("reset")
        self._call("set_state", [0.0, 0.0, HIGH, 1.0, *(0.0,) * 9])
        for _ in range(round(SPIN_UP / STEP)):
            self._call("step", self._hover.tolist(), STEP)
        self._call("set_state", start.state.tolist())
        self._thrusts, self._state = self._hover, self._read()

    def advance(self, commands: Floats, duration: float) -> None:
        """Fly for a duration [s] under a command that is held, shape (1, 4); the rate loop runs at every step."""
        for _ in range(round(duration / STEP)):
            self._thrusts = self._rate_loop(self._state, self._thrusts, commands[0])
            self._call("step", self._thrusts.tolist(), STEP)
            self._state = self._read()

    def states(self) -> Floats:
        """Position, attitude, velocity and body rates, shape (1, 13)."""
        return self._state[None].copy()

    def rotor_thrusts(self) -> Floats:
        """Shape (1, 4) [N]: what the rotors give, or where the module does not tell what they are asked for."""
        if not hasattr(self._drone, "rotor_thrusts"):
            return self._thrusts[None].copy()
        return self._numbers("rotor_thrusts", 4)[None]

    def close(self) -> None:
        """Let it go."""
        self._drone = None

    def _read(self) -> Floats:
        return self._numbers("state", 13)

    def _numbers(self, name: str, size: int) -> Floats:
        """What a call returns, finite numbers."""
        told = self._call(name)
        try:
            numbers = np.array(told, dtype=np.float64).ravel()
        except (TypeError, ValueError):
            numbers = np.empty(0)
        if numbers.shape != (size,) or not np.isfinite(numbers).all():
            raise SimulatorError(f"{self._name}: Quadrotor.{name}() must return {size} finite numbers, not {told!r:.60}")
        return numbers

    def _call(self, name: str, *arguments: Any) -> Any:
        """Call the module; what goes wrong in it is one line."""
        try:
            return getattr(self._drone, name)(*arguments)
        except Exception as error:
            raise SimulatorError(f"{self._name}: Quadrotor.{name}: {_in_words(error)}") from error


def open_simulator(scenario: Scenario, instance: int, argument: str = "") -> Flightmare:  # noqa: ARG001  instances share the module
    """A quadrotor of the user's module.

    Args:
        scenario: what is flown, within the box of the module.
        instance: number of the quadrotor.
        argument: name of the module.

    Raises:
        InputError: there is no such module, it lacks something, or the flight does not fit into its box.
    """
    module = _module(argument)
    make = getattr(module, "Quadrotor", None)
    if make is None:
        raise InputError("", "on", f"the module {argument} has no Quadrotor; see docs/world_flightmare.md")
    missing = [f"Quadrotor.{name}" for name in CALLS if not callable(getattr(make, name, None))]
    if missing:
        raise InputError("", "on", f"the module {argument} lacks {', '.join(missing)}; see docs/world_flightmare.md")
    _fit(scenario, float(getattr(module, "BOX", BOX)), argument)
    try:
        drone = make()
    except Exception as error:
        raise SimulatorError(f"{argument}: Quadrotor: {_in_words(error)}") from error
    return Flightmare(argument, drone, scenario.race.vehicle, scenario.race.control_model)


def _module(name: str) -> ModuleType:
    """The user's module.

    Raises:
        InputError: there is none, or it cannot be loaded.
    """
    if not name:
        raise InputError("", "on", "flightmare needs the module that you have built for flightlib: flightmare:my_module")
    try:
        return import_own(name)
    except Exception as error:
        raise InputError("", "on", f"the module {name} cannot be loaded: {_in_words(error)}") from error


def _fit(scenario: Scenario, box: float, name: str) -> None:
    """Refuse a flight that leaves the box, at whose top flightlib puts a drone back to the floor.

    Raises:
        InputError: names how far it goes.
    """
    furthest = float(np.abs(scenario.reference.position).max())
    if furthest >= box:
        raise InputError("", "on", f"the flight goes {furthest:.0f} m from the origin, and {name} keeps drones within {box:g} m (its BOX)")


def _in_words(error: Exception) -> str:
    """What went wrong in code of the user's, on one line."""
    return printable(f"{type(error).__name__}: {error}")

"""crazyflow (github.com/learnsyslab/crazyflow, MIT): Crazyflies in JAX, many in one compiled step; lsy_drone_racing flies on it."""

from __future__ import annotations

from contextlib import redirect_stdout
from importlib.util import find_spec
from io import StringIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.race.quadrotor import Quadrotor
from hotlap.reference.scenario import Scenario
from hotlap.worlds.separate import Separate
from hotlap.worlds.simulator import SimulatorError, Start

Floats = NDArray[np.float64]

MISSING = "crazyflow is not installed: pip install 'hotlap[crazyflow]'"
OPENING = "compiling crazyflow"
ENVIRONMENT = {"SCIPY_ARRAY_API": "1"}
STEP = 0.0025  # s, of physics and rate loop
LANES = 16
FROM_ORIGIN = Start(np.array([0.0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0]))
TO_XYZW, TO_WXYZ = [0, 1, 2, 4, 5, 6, 3, *range(7, 13)], [0, 1, 2, 6, 3, 4, 5, *range(7, 13)]  # of a state
OUR_ROTORS = [3, 0, 1, 2]  # among those of its drones: front left, front right, back right, back left


def open_simulator(scenario: Scenario, instance: int, argument: str = "") -> Separate:
    """A crazyflow for each instance, in a process of its own: SciPy must be loaded there as crazyflow wants it.

    Args:
        scenario: what is flown.
        instance: number of the simulator.
        argument: name of a drone of crazyflow, which flies as crazyflow describes it, its rate loop too; "": the race's vehicle.

    Raises:
        SimulatorError: crazyflow is not installed, or the vehicle's rotors do not sit in a square.
        UnknownNameError: it has no such drone.
    """
    del instance
    if not installed():
        raise SimulatorError(MISSING)
    return Separate(Crazyflow, scenario.race.vehicle, scenario.race.control_model, argument, environment=ENVIRONMENT)


def installed() -> bool:
    """Whether crazyflow is there."""
    return find_spec("crazyflow") is not None


class Crazyflow:
    """Quadrotors in crazyflow's model of first principles, under thrust and body rates, each in a world of its own.

    Making it compiles its step, for ten seconds; another one in the same process does not. Where SciPy is loaded already, `ENVIRONMENT`
    must have been set before.

    Args:
        vehicle: that flies. Dead time and battery are not crazyflow's.
        autopilot: whose mass, inertia and mixer the rate loop takes to be true; None: the vehicle's.
        drone: of crazyflow, which flies instead of the vehicle; its thrust per mass is still the autopilot's.
        lanes: how many fly at once.

    Attributes:
        lanes: how many fly at once.
        step: [s].
        scales_thrust: False.

    Raises:
        SimulatorError: crazyflow is not installed, or the vehicle's rotors do not sit in a square.
        UnknownNameError: it has no such drone.
    """

    def __init__(self, vehicle: Quadrotor, autopilot: Quadrotor | None = None, drone: str = "", lanes: int = LANES) -> None:
        try:
            with redirect_stdout(StringIO()):  # it says what it does without
                from hotlap.worlds import crazyflow_vehicle as ours  # noqa: PLC0415  optional, and takes seconds
        except ModuleNotFoundError as error:
            raise SimulatorError(MISSING) from error
        self.lanes, self.step, self.scales_thrust = lanes, STEP, False
        self._mass, self._rotors = (autopilot or vehicle).mass, OUR_ROTORS if drone else [0, 1, 2, 3]
        self._sim: Any = ours.build(drone, lanes, STEP)
        if not drone:
            ours.become(self._sim, vehicle, autopilot or vehicle)
        params = self._sim.data.params
        self._hover = ours.rotor_speed(self._sim, float(params.mass[0]) * -float(params.gravity_vec[2]) / 4)
        self._place, self._step = ours.place, ours.stepper(bool(drone))
        for lane in range(lanes):
            self.reset(lane, FROM_ORIGIN)
        self.advance(np.zeros((lanes, 4)), STEP)

    def reset(self, lane: int, start: Start) -> None:
        """Place a drone, its rotors as in hover, and let its rate loop forget."""
        self._sim.data = self._place(self._sim.data, lane, start.state[TO_XYZW], self._hover)

    def advance(self, commands: Floats, duration: float) -> None:
        """Fly all lanes for a duration [s] under commands, shape (L, 4)."""
        order: Any = np.column_stack([commands[:, 1:], self._mass * commands[:, 0]])[:, None].astype(np.float32)
        self._sim.data = self._step(self._sim.data, order, round(duration / STEP))

    def states(self) -> Floats:
        """Where the drones are, shape (L, 13)."""
        s = self._sim.data.states
        return np.concatenate([s.pos, s.quat, s.vel, s.ang_vel], axis=2, dtype=np.float64)[:, 0, TO_WXYZ]

    def rotor_thrusts(self) -> Floats:
        """What the rotors give, shape (L, 4) [N]."""
        speeds = np.asarray(self._sim.data.states.rotor_vel, dtype=np.float64)[:, 0, self._rotors]
        constant, linear, square = np.asarray(self._sim.data.params.rpm2thrust, dtype=np.float64)[0]
        return constant + linear * speeds + square * speeds**2

    def close(self) -> None:
        """It holds nothing."""

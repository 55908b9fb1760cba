"""AirSim as a simulator: paused, and continued step by step between one command and the next.

AirSim knows no steps from outside: `simContinueForTime` lets it run for a time of the wall's clock, and on a busy machine it flies less
than that, or more. So the clock is that of its time stamps: it is continued until the step that is nearest to ours, and what it
has flown too much or too little counts in the next period.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.files.content import Content
from hotlap.worlds.airsim.client import TIMEOUT, CallError, Client
from hotlap.worlds.airsim.frames import kinematics_of, pose_of, state_of
from hotlap.worlds.airsim.moves import Moves
from hotlap.worlds.simulator import SimulatorError, Start

Floats = NDArray[np.float64]
STEP = 0.003  # s, of AirSim's physics
DELAY = 0.0075  # s, dead time of its own rate loop as it looks from outside
MARGIN = 0.001  # s less than whole steps are asked for, so that it ends before another begins
MASS, GRAVITY = 1.0, 9.80665  # kg, m/s^2: of its generic quadrotor
THRUST, SEA_LEVEL = 4 * 4.179446, 1.225  # N at full throttle in air of this density, kg/m^3
LEAST_THROTTLE = 0.06  # below 0.05 its rate loop is off
SETTLING = 0.09  # s of hovering, after which the rotors turn as in hover
FURTHEST_AHEAD = 0.05  # s
PLACED = 0.5  # m within which a drone stands where it was placed
SLOW = 0.5  # m/s that may be missing where a simulator sets poses alone
OURS_FROM_THEIRS = [2, 0, 3, 1]  # its rotors: front right, back left, front left, back right
FAST_CLOCK = 'set "ClockSpeed": 1 in settings.json'


class AirSim:
    """Flies one vehicle of AirSim, Cosys-AirSim or AirSim Drone Racing Lab; a `Simulator`.

    Args:
        client: connection.
        vehicle: its name; "": the only one.
        timeout: [s] in which its clock must go on.

    Raises:
        SimulatorError: there is no such vehicle, or the server is none of these.
    """

    lanes, step, scales_thrust, delay = 1, STEP, False, DELAY

    def __init__(self, client: Client, vehicle: str = "", timeout: float = TIMEOUT) -> None:
        self._client, self._vehicle, self._timeout = client, vehicle, timeout
        self._moves = Moves(client, vehicle)
        self._time, self._due, self._origin = 0.0, 0.0, 0
        self._state, self._newton = np.zeros(13), 0.0
        self._tells_rotors = self._sets_kinematics = True
        client.call("ping")
        self._take_control()
        client.call("cancelLastTask", vehicle)  # of a connection before, that was lost

    def reset(self, lane: int, start: Start) -> None:  # noqa: ARG002  there is one lane
        """Place the drone, its rotors as in hover.

        Raises:
            SimulatorError: it cannot be placed, or the simulator is lost.
        """
        self._moves.stop()
        self._client.call("reset")
        self._take_control()
        self._client.call("simPause", True)
        environment = self._ask("simGetGroundTruthEnvironment")
        with _understood():
            self._newton = SEA_LEVEL / (THRUST * environment["air_density"].positive())
        self._begin()
        self.advance(np.array([[GRAVITY, 0.0, 0.0, 0.0]]), SETTLING)
        self._place(start.state)
        self._begin()

    def advance(self, commands: Floats, duration: float) -> None:
        """Fly for a duration [s] under a command that is held, shape (1, 4); to the nearest of its own steps.

        Raises:
            SimulatorError: the simulator is lost.
        """
        self._due += duration
        behind = self._due - self._time
        if behind < -FURTHEST_AHEAD:
            raise self._client.fault(f"its clock is {-1e3 * behind:.0f} ms ahead of what it was asked to fly: {FAST_CLOCK}")
        if behind > STEP / 2:
            thrust, *rates = (float(number) for number in commands[0])
            throttle = min(max(thrust * MASS * self._newton, LEAST_THROTTLE), 1.0)
            self._moves.send(rates, throttle, behind)
            self._continue()

    def states(self) -> Floats:
        """Where it was at its last time stamp, shape (1, 13)."""
        return self._state[None].copy()

    def rotor_thrusts(self) -> Floats:
        """Shape (1, 4) [N], NaN where the simulator does not tell."""
        if self._tells_rotors:
            try:
                rotors = self._ask("getRotorStates")["rotors"]
                thrusts = [rotor["thrust"].number() for rotor in rotors.entries()]
                return np.array(thrusts)[None, OURS_FROM_THEIRS]
            except (CallError, InputError, IndexError):
                self._tells_rotors = False
        return np.full((1, 4), np.nan)

    def close(self) -> None:
        """Let it run on without us; may be called twice."""
        if not self._client.lost:
            with suppress(SimulatorError):
                self._moves.stop()
                self._client.call("simPause", False)
                self._client.call("enableApiControl", False, self._vehicle)
        self._client.close()

    def _take_control(self) -> None:
        try:
            self._client.call("enableApiControl", True, self._vehicle)
        except CallError as error:
            raise self._without_vehicle(error) from None
        self._client.call("armDisarm", True, self._vehicle)

    def _without_vehicle(self, error: CallError) -> SimulatorError:
        """What is wrong with the vehicle's name, with those there are."""
        with suppress(SimulatorError):
            names = self._client.call("listVehicles")
            if isinstance(names, list) and self._vehicle not in names:
                known = ", ".join(str(name) for name in names)
                return self._client.fault(f"there is no vehicle named '{self._vehicle}'; available: {known} (airsim:host:port:vehicle)")
        return error

    def _place(self, state: Floats) -> None:
        """Set the vehicle's state; its rotors go on turning."""
        if self._sets_kinematics:
            try:
                self._client.call("simSetKinematics", kinematics_of(state), True, self._vehicle)
            except CallError as error:
                if not error.unknown:
                    raise
                self._sets_kinematics = False
        if not self._sets_kinematics:
            speed = float(np.linalg.norm(state[7:10]))
            if speed > SLOW:
                raise self._client.fault(f"has no simSetKinematics, so a flight cannot start at {speed:.3g} m/s: start at rest")
            self._client.call("simSetVehiclePose", pose_of(state), True, self._vehicle)
        self._read()
        if not self._is_at(state[:3]):
            self._continue(STEP)
        if not self._is_at(state[:3]):
            there, asked = (f"({x:.1f}, {y:.1f}, {z:.1f})" for x, y, z in (self._state[:3], state[:3]))
            raise self._client.fault(f"the vehicle is at {there}, not at the start, {asked} m: does something stand in its place?")

    def _is_at(self, position: Floats) -> bool:
        return float(np.linalg.norm(self._state[:3] - position)) < PLACED

    def _begin(self) -> None:
        """Begin to count time."""
        self._time = self._due = 0.0
        self._origin = self._read()

    def _continue(self, further: float = 0.0) -> None:
        """Let it fly until the step that is nearest to our time, or for a time [s] from its own."""
        if further:
            self._due = self._time + further
        deadline = monotonic() + self._timeout
        while self._due - self._time > STEP / 2:
            seconds = max(round((self._due - self._time) / STEP), 1) * STEP - MARGIN
            self._client.call("simContinueForTime", seconds, patience=seconds)
            while not self._is_paused() and monotonic() < deadline + seconds:
                pass
            before, stamp = self._time, self._read()
            self._time = 1e-9 * (stamp - self._origin)
            if self._time > before:
                deadline = monotonic() + self._timeout
            elif self._time < before or monotonic() > deadline:
                raise self._client.fault(f"its clock does not go on: it was at {before:.3f} s, and is at {self._time:.3f} s")

    def _is_paused(self) -> bool:
        """Whether it has stopped again: not every version waits until it has."""
        return self._client.call("simIsPaused") is not False

    def _read(self) -> int:
        """Take over the state; returns its time stamp [ns]."""
        controlled = self._client.send("isApiControlEnabled", self._vehicle)
        told = self._ask("getMultirotorState")
        stamp = told.value.get("timestamp") if isinstance(told.value, dict) else None
        if not isinstance(stamp, int) or isinstance(stamp, bool):
            raise self._client.fault(f"getMultirotorState.timestamp must be a whole number, not {stamp!r:.40}")
        with _understood():
            self._state = state_of(told["kinematics_estimated"])
        if self._client.reply(controlled) is not True:
            raise self._client.fault("API control was lost: does a remote control or another program fly this vehicle?")
        return stamp

    def _ask(self, method: str) -> Content:
        """What a call about the vehicle returns."""
        return Content(self._client.name, self._client.call(method, self._vehicle), method)


@contextmanager
def _understood() -> Iterator[None]:
    """A reply that makes no sense loses the simulator."""
    try:
        yield
    except InputError as error:
        raise SimulatorError(str(error)) from None

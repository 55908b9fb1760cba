"""Betaflight: the real firmware flies a simulated quadrotor, in lockstep; a `Simulator`."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hotlap.flight.motors import UPRIGHT, MotorPlant
from hotlap.flight.verdicts import TAKEN_OFF
from hotlap.race.quadrotor import Quadrotor
from hotlap.worlds.betaflight.console import configured
from hotlap.worlds.betaflight.gains import gain_lines
from hotlap.worlds.betaflight.link import BOOT, PATIENCE, Link
from hotlap.worlds.betaflight.settings import Line, configuration, full_stick_for, motor_idle
from hotlap.worlds.betaflight.sticks import ROTORS, Channels, Sticks, resting
from hotlap.worlds.simulator import SimulatorError, Start

Floats = NDArray[np.float64]

STEP = 0.001  # s between two packets
NANOSECONDS = 1_000_000  # of a step
WITHIN = 4  # steps of the plant in it
CALIBRATING, ARMING, SPINNING = 1.2, 0.1, 0.4  # s of standing still: for the gyro, between two attempts to arm, for motors to hover
ATTEMPTS = 40
TURNING = 0.02  # motor output from which a motor is armed
STILL = np.zeros(3)


class Betaflight:
    """A quadrotor whose rate loop and mixer are Betaflight's.

    It boots and arms once; every flight begins with a copy of that process, so flights repeat bit for bit.

    Args:
        quadrotor: that flies, with the gains of its rate loop; its dead time does not count.
        own: lines of the user for the firmware's command line.
        known_as: the vehicle as its pilot knows it: a thrust per mass is the throttle that gives it there. None: the vehicle itself.
        most_rate: [rad/s] largest body rate that can be commanded; None: what the quadrotor's plans may ask for.
        floor: [m] on which a drone stands that has not taken off.
        patience: [s] after which a firmware that does not answer is lost.

    Raises:
        InputError: the firmware refuses a line of the user.
        SimulatorError: the firmware is not installed, does not start, or does not arm.
    """

    lanes, step, scales_thrust = 1, STEP, True

    def __init__(
        self,
        quadrotor: Quadrotor,
        own: Sequence[Line] = (),
        *,
        known_as: Quadrotor | None = None,
        most_rate: float | None = None,
        floor: float = -math.inf,
        patience: float = PATIENCE,
    ) -> None:
        if quadrotor.rotors is not None:
            raise SimulatorError(f"Betaflight flies four rotors in layout x or plus, not those that {quadrotor.name} lists")
        full_stick = full_stick_for(max(quadrotor.rate_limit) if most_rate is None else most_rate)
        lines = configuration(quadrotor.layout, full_stick, gain_lines(quadrotor), own)
        self._sticks = Sticks(known_as or quadrotor, full_stick, motor_idle(lines))
        self._own = own
        self._hover = np.array([quadrotor.gravity, 0.0, 0.0, 0.0])
        self._rotors, self._floor, self._grounded = ROTORS[quadrotor.layout], floor, False
        self._plant = MotorPlant(quadrotor, STEP / WITHIN)
        self._armed = Link.start(configured(lines, patience), patience=patience)
        self._flying: Link | None = None
        self._clock = self._armed_at = BOOT
        try:
            self._arm()
        except SimulatorError:
            self.close()
            raise

    def reset(self, lane: int, start: Start) -> None:
        """Place the drone, hovering; the firmware is as it was when it had armed."""
        if lane:
            raise ValueError(f"Betaflight flies one drone, so there is no lane {lane}")
        self._land()
        self._flying, self._clock = self._armed.copy(), self._armed_at
        self._plant.place(start.state, start.thrust_factor)
        self._grounded = start.state[2] <= self._floor + TAKEN_OFF

    def advance(self, commands: Floats, duration: float) -> None:
        """Fly for a duration [s] under a command that is held, shape (1, 4)."""
        if self._flying is None:
            raise SimulatorError("Betaflight is not flying")
        channels, plant = self._sticks.channels(commands[0]), self._plant
        for _ in range(round(duration / STEP)):
            self._clock += NANOSECONDS
            answer = self._flying.run(self._clock, channels, plant.state[10:13], plant.force, plant.state[3:7])
            plant.advance(answer.motors[self._rotors], WITHIN)
            if self._grounded:
                self._stand()

    def states(self) -> Floats:
        """Position, attitude, velocity and body rates, shape (1, 13)."""
        return self._plant.state[None, :13].copy()

    def rotor_thrusts(self) -> Floats:
        """Shape (1, 4) [N]."""
        return self._plant.state[None, 13:] ** 2

    @property
    def computing_time(self) -> float:
        """[s] of a processor that the firmware has taken since the drone was placed."""
        if self._flying is None:
            return 0.0
        times = Path(f"/proc/{self._flying.answer.process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[11:13]
        return sum(map(int, times)) / os.sysconf("SC_CLK_TCK")

    def close(self) -> None:
        """End the firmware."""
        self._land()
        self._armed.close()

    def _land(self) -> None:
        """End the flight."""
        if self._flying is not None:
            self._flying.close()
            self._flying = None

    def _arm(self) -> None:
        """Stand still, arm, and spin up as in hover."""
        self._wait(resting(armed=False), CALIBRATING)
        for _ in range(ATTEMPTS):  # a switch that is raised too early counts only when it is raised again
            self._wait(resting(armed=True), ARMING)
            if self._armed.answer.motors.max() > TURNING:
                break
            self._wait(resting(armed=False), ARMING)
        else:
            because = f" with the lines of {self._own[0].source}" if self._own else ""
            raise SimulatorError(f"Betaflight does not arm{because}")
        self._wait(self._sticks.channels(self._hover), SPINNING)
        self._armed_at = self._clock

    def _wait(self, channels: Channels, duration: float) -> None:
        """Hold the drone level and still while the firmware runs."""
        for _ in range(round(duration / STEP)):
            self._clock += NANOSECONDS
            self._armed.answer = self._armed.run(self._clock, channels, STILL, self._plant.force, UPRIGHT)

    def _stand(self) -> None:
        """Keep the drone on the ground until it takes off."""
        state = self._plant.state
        if state[2] < self._floor:
            state[2], state[9] = self._floor, max(float(state[9]), 0.0)
        self._grounded = state[2] <= self._floor + TAKEN_OFF

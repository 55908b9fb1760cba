"""Stand-in: a drone with an autopilot that is none of hotlap's, to be flown over a link before a real one is: our plant, other numbers.

What its file does not say and a link has to cope with: thrust that differs from that of the file, dead time, a battery that sags, and an
autopilot with a will of its own: it arms, follows, holds, lands, and holds or lands by itself when setpoints cease.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from hotlap.core.records import Floats
from hotlap.race.quadrotor import Quadrotor
from hotlap.real_flight.paths import level
from hotlap.reference.attitude import CONJUGATE, rotate, thrust_axis
from hotlap.worlds.plant_simulator import PlantSimulator
from hotlap.worlds.simulator import Start

CELLS, FULL_CELL = 4, 4.1  # V
DRAWN = 0.01  # V/s for each time that the thrust is the weight
LOST_AFTER = 0.5  # s without setpoints, after which it lands: COM_OF_LOSS_T of PX4
HARD = 3.0  # m/s at the ground: a crash
TILTED = 0.8  # cosine of the tilt at the ground below which it is one, too
LANDING_SPEED = 0.7  # m/s


class Mode(StrEnum):
    """What the autopilot does."""

    MANUAL = "manual"
    FOLLOW = "follow"
    HOLD = "hold"
    LAND = "land"


@dataclass
class StandInDrone:
    """A drone that stands on the ground, disarmed, until it is told otherwise.

    Attributes:
        quadrotor: what flies.
        position: shape (3,) [m] (world) where it stands; its height is that of the ground.
        yaw: [rad] in which it looks.
        thrust_share: thrust at a throttle over what the quadrotor's file says [-].
        delay: [s] from a setpoint to the rotors.
        sags: whether thrust goes with the square of a voltage that falls.
        time: [s].
        armed, mode, crashed: how it is.
        last_setpoint: [s] when one came last.
    """

    quadrotor: Quadrotor
    position: Floats
    yaw: float = 0.0
    thrust_share: float = 1.0
    delay: float = 0.0
    sags: bool = True
    time: float = 0.0
    armed: bool = False
    mode: Mode = Mode.MANUAL
    crashed: bool = False
    last_setpoint: float = -math.inf
    voltage: float = CELLS * FULL_CELL
    _waiting: deque[tuple[float, Floats]] = field(default_factory=deque)

    def __post_init__(self) -> None:
        self.ground = float(self.position[2])
        self._simulator = PlantSimulator(self.quadrotor, floor=self.ground)
        self._steps = 0
        self._acting, self._place = np.zeros(4), self.position.copy()
        self._put(np.concatenate([self.position, level(self.yaw), np.zeros(6)]))

    @property
    def state(self) -> Floats:
        """Shape (13,), the true one."""
        return self._simulator.states()[0]

    @property
    def on_ground(self) -> bool:
        """Whether it stands."""
        return bool(self.state[2] <= self.ground + 0.01)

    def hover(self, place: Floats) -> None:
        """Put it into the air at a place, shape (3,) [m], where it holds itself."""
        self.armed, self.mode, self._place = True, Mode.HOLD, np.array(place, dtype=np.float64)
        self._put(np.concatenate([self._place, level(self.yaw), np.zeros(6)]))

    def told(self, throttle: float, rates: Floats) -> None:
        """A setpoint has come: throttle [-] and body rates, shape (3,) [rad/s]."""
        self.last_setpoint = self.time
        self._waiting.append((self.time + self.delay, np.array([throttle, *rates])))

    def change(self, mode: Mode) -> bool:
        """Go over to a mode; whether it does."""
        if mode is Mode.FOLLOW and self.time - self.last_setpoint > LOST_AFTER:
            return False
        if mode is not self.mode:
            self._place = self.state[:3].copy()
        self.mode = mode
        return True

    def arm(self) -> None:
        """Let the motors turn."""
        if not self.crashed:
            self.armed, self._acting = True, np.zeros(4)

    def disarm(self) -> None:
        """Stop the motors."""
        self.armed, self.mode = False, Mode.MANUAL
        if self.on_ground:
            self._stand()

    def advance(self, duration: float) -> None:
        """Fly on for a duration [s], a whole number of steps of the plant."""
        step = self._simulator.step
        for _ in range(round(duration / step)):
            self._steps += 1
            self.time = self._steps * step
            self._step(step)

    def _step(self, step: float) -> None:
        while self._waiting and self._waiting[0][0] <= self.time:
            self._acting = self._waiting.popleft()[1]
        if self.mode is Mode.FOLLOW and self.time - self.last_setpoint > LOST_AFTER:
            self.change(Mode.LAND)
        if not self.armed and self.on_ground:
            return
        share = (self.voltage / (CELLS * FULL_CELL)) ** 2 if self.sags else 1.0
        throttle, *rates = (self._acting if self.mode is Mode.FOLLOW else self._by_itself()).tolist()
        thrust = self.thrust_share * self.quadrotor.max_acceleration * share * min(max(throttle, 0.0), 1.0) if self.armed else 0.0
        self._simulator.advance(np.array([[thrust, *rates]]), step)
        self.voltage -= DRAWN * step * thrust / self.quadrotor.gravity
        self._meet_ground()

    def _by_itself(self) -> Floats:
        """Throttle and rates by which it holds its place, or lands."""
        state, gravity = self.state, self.quadrotor.gravity
        if self.mode is Mode.MANUAL:
            return np.zeros(4)
        wanted = 1.5 * np.clip(self._place - state[:3], -2, 2)
        if self.mode is Mode.LAND:
            wanted[2] = -LANDING_SPEED
        push = 2.0 * np.clip(wanted - state[7:10], -5, 5) + np.array([0.0, 0.0, gravity])
        axis, aim = thrust_axis(state[3:7]), push / np.linalg.norm(push)
        turn = rotate((state[3:7] * CONJUGATE)[None], np.cross(axis, aim)[None])[0]
        full = self.thrust_share * self.quadrotor.max_acceleration
        return np.append(max(float(push @ axis), 0.0) / full, np.clip(5.0 * turn, -4, 4))

    def _meet_ground(self) -> None:
        """Stand, or crash, where it comes down."""
        state = self.state
        if not np.isfinite(state).all() or (state[2] < self.ground and state[9] < 0):
            upright = np.isfinite(state).all() and thrust_axis(state[3:7])[2] > TILTED
            self.crashed = self.crashed or not upright or float(-state[9]) > HARD
            self._stand()
            if self.crashed or self.mode is Mode.LAND:
                self.armed, self.mode = False, Mode.MANUAL

    def _stand(self) -> None:
        """On the ground, level and at rest, where it is."""
        state = np.nan_to_num(self.state)
        _, _, _, w_z = state[3:7].tolist()
        yaw = 2 * math.atan2(w_z, float(state[3])) if state[3] or w_z else 0.0
        self._put(np.concatenate([[state[0], state[1], self.ground], level(yaw), np.zeros(6)]))

    def _put(self, state: Floats) -> None:
        self._simulator.reset(0, Start(state))

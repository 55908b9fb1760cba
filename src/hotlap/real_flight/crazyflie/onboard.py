"""On board: what the firmware of a Crazyflie does with what it is told, as far as a link can see: commander, supervisor, controller.

A stand-in for `stand_in`: it follows full states, or plans of its high-level commander, on hotlap's own plant.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import BPoly

from hotlap.core.records import Floats
from hotlap.real_flight.crazyflie.status import DOWN, Status
from hotlap.real_flight.paths import level, yaw_of
from hotlap.real_flight.stand_in import Mode, StandInDrone
from hotlap.reference.attitude import CONJUGATE, rotate, thrust_axis

LEVELS, STOPS, WATCHED = 0.5, 2.0, 1.0  # s without a setpoint; s without a beat of the watchdog
STILL_FLYING = 2.0  # s after the last thrust
IDLE = 0.05  # of the throttle
POSITION, VELOCITY, SUM, TURN = 12.0, 5.5, 10.0, 9.0  # gains [1/s^2], [1/s], [1/s^3], [1/s] of its controller
MOST_SUM = 0.5  # m s
PUSH, FASTEST = 12.0, 6.0  # m/s^2, rad/s
PIECE = 33  # numbers


@dataclass(frozen=True)
class Aim:
    """A full state.

    Attributes:
        position, velocity, acceleration: shape (3,) (world).
        attitude: shape (4,), of which the heading counts.
        rates: shape (3,) [rad/s] (body).
    """

    position: Floats
    velocity: Floats
    acceleration: Floats
    attitude: Floats
    rates: Floats = field(default_factory=lambda: np.zeros(3))


@dataclass
class OnBoard:
    """A Crazyflie.

    Attributes:
        drone: that it flies.
        arms_itself: as one with brushed motors does.
        refuses: whether its checks before a flight fail.
        memory: of trajectories.
        locked: whether it was stopped for good.
        flying: whether it has had thrust lately.
    """

    drone: StandInDrone
    arms_itself: bool = False
    refuses: bool = False
    memory: bytearray = field(default_factory=lambda: bytearray(4096))
    locked: bool = False
    _wants_arms: bool = False
    _aim: Aim | None = None
    _aimed: float = -math.inf
    _streamed: bool = False
    _plan: Callable[[float], Aim] | None = None
    _begun: float = 0.0
    _lasts: float = math.inf
    _beaten: float = math.inf
    _thrust: float = -math.inf
    _pieces: tuple[int, int] = (0, 0)
    _sum: Floats = field(default_factory=lambda: np.zeros(3))

    @property
    def armed(self) -> bool:
        """Whether motors may turn."""
        return (self._wants_arms or self.arms_itself) and not self.locked and not self.refuses and not self.drone.crashed

    @property
    def flying(self) -> bool:
        """As it says itself."""
        return self.armed and self.drone.time - self._thrust < STILL_FLYING

    @property
    def status(self) -> Status:
        """`supervisor.info`."""
        bits = {
            Status.CAN_ARM: not (self.locked or self.refuses or self.armed),
            Status.ARMED: self.armed,
            Status.AUTO_ARMED: self.arms_itself,
            Status.CAN_FLY: self.armed,
            Status.FLYING: self.flying,
            Status.LOCKED: self.locked,
            Status.CRASHED: self.drone.crashed,
            Status.COMMANDER: self._plan is not None,
        }
        status = Status(0)
        for bit, on in bits.items():
            status |= bit if on else Status(0)
        return status

    def hover(self, place: Floats) -> None:
        """Put it into the air at a place, shape (3,) [m], where its commander holds it."""
        self.drone.hover(place)
        self._wants_arms, self._thrust = True, self.drone.time
        self._follow_plan(lambda _: Aim(place, np.zeros(3), np.zeros(3), level(self.drone.yaw)))

    def arm(self, on: bool) -> bool:
        """Arm or disarm; whether it does."""
        able = not (on and (self.refuses or self.status & DOWN))
        self._wants_arms = on if able else self._wants_arms
        return able

    def stream(self, aim: Aim) -> None:
        """A setpoint has come; its commander forgets its plan."""
        self._aim, self._aimed, self._streamed, self._plan = aim, self.drone.time, True, None

    def give_way(self) -> None:
        """Setpoints give way to the commander: where that has no plan, motors stop."""
        self._streamed = False

    def land(self, height: float, duration: float) -> None:
        """Come down to a height [m] in so many seconds."""
        state = self.drone.state
        below = np.array([state[0], state[1], height])
        self._follow_plan(_way(state[:3], np.zeros(3), below, duration, yaw_of(state[3:7])), duration)

    def go_on(self, offset: Floats, duration: float) -> None:
        """Go to a place by an offset, shape (3,) [m], from here."""
        state = self.drone.state
        self._follow_plan(_way(state[:3], state[7:10], state[:3] + offset, duration, yaw_of(state[3:7])))

    def define(self, offset: int, count: int) -> None:
        """A trajectory of so many pieces lies in the memory."""
        self._pieces = offset, count

    def start(self) -> bool:
        """Fly it; whether there is one."""
        offset, count = self._pieces
        if not count:
            return False
        numbers = np.frombuffer(bytes(self.memory), "<f4", PIECE * count, offset).reshape(count, PIECE).astype(np.float64)
        durations, parts = numbers[:, -1], numbers[:, :-1].reshape(count, 4, 8)
        ends = np.cumsum(durations)

        def aim(now: float) -> Aim:
            row = min(int(np.searchsorted(ends, now)), count - 1)
            local = min(now - (ends[row] - durations[row]), durations[row])
            curves = [np.polynomial.Polynomial(part) for part in parts[row]]
            position, velocity, acceleration = (
                np.array([curve.deriv(n)(local) if n else curve(local) for curve in curves]) for n in range(3)
            )
            if now > ends[-1]:
                velocity, acceleration = np.zeros(4), np.zeros(4)
            return Aim(position[:3], velocity[:3], acceleration[:3], level(position[3]))

        self._follow_plan(aim)
        return True

    def stop(self) -> None:
        """Stop the motors, until it is restarted."""
        self.locked = True

    def beat(self) -> None:
        """A beat of the watchdog."""
        self._beaten = self.drone.time

    def advance(self, duration: float) -> None:
        """Fly on [s]."""
        drone = self.drone
        if drone.time - self._beaten > WATCHED:
            self.locked = True
        drone.armed = self.armed
        if not self.armed:
            self._plan, self._streamed = None, False
            drone.mode = Mode.MANUAL
            drone.advance(duration)
            return
        drone.mode = Mode.FOLLOW
        throttle, rates = self._command(self._wanted(), duration)
        if throttle > IDLE:
            self._thrust = drone.time
        drone.told(throttle, rates)
        drone.advance(duration)

    def _wanted(self) -> Aim | None:
        """What it follows now; None: motors stop."""
        now = self.drone.time
        if self._streamed:
            age, aim = now - self._aimed, self._aim
            if aim is None or age > STOPS:
                return None
            state = self.drone.state
            return aim if age <= LEVELS else Aim(np.array([*state[:2], aim.position[2]]), np.zeros(3), np.zeros(3), state[3:7])
        if self._plan is None:
            return None
        if now - self._begun > self._lasts:
            self._plan = None
            return None
        return self._plan(now - self._begun)

    def _command(self, aim: Aim | None, duration: float) -> tuple[float, Floats]:
        """Throttle and rates: a point mass that follows, whose thrust the body turns into."""
        if aim is None:
            self._sum = np.zeros(3)
            return 0.0, np.zeros(3)
        state, drone = self.drone.state, self.drone
        error = aim.position - state[:3]
        self._sum = np.clip(self._sum + duration * error, -MOST_SUM, MOST_SUM)
        push = POSITION * error + SUM * self._sum + VELOCITY * (aim.velocity - state[7:10])
        force = np.clip(push, -PUSH, PUSH) + aim.acceleration + [0.0, 0.0, drone.quadrotor.gravity]
        axis = thrust_axis(state[3:7])
        back = (state[3:7] * CONJUGATE)[None]
        turn = rotate(back, np.cross(axis, force / np.linalg.norm(force))[None])[0]
        heading = math.remainder(yaw_of(aim.attitude) - yaw_of(state[3:7]), 2 * math.pi)
        rates = np.clip(TURN * turn + [0.0, 0.0, 2.0 * heading], -FASTEST, FASTEST) + aim.rates
        return max(float(force @ axis), 0.0) / (drone.thrust_share * drone.quadrotor.max_acceleration), rates

    def _follow_plan(self, plan: Callable[[float], Aim], lasts: float = math.inf) -> None:
        self._plan, self._begun, self._lasts = plan, self.drone.time, lasts


def _way(start: Floats, velocity: Floats, end: Floats, duration: float, yaw: float) -> Callable[[float], Aim]:
    """A polynomial of degree 7 from a motion to rest."""
    zero = np.zeros(3)
    curve = BPoly.from_derivatives([0.0, duration], [[start, velocity, zero, zero], [end, zero, zero, zero]])

    def aim(now: float) -> Aim:
        at = min(now, duration)
        return Aim(curve(at), curve(at, 1), curve(at, 2), level(yaw))

    return aim

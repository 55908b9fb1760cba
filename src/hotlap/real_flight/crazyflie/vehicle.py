"""A Crazyflie: told full states as they are due, or the whole race beforehand, as a trajectory.

It flies by its own controller, on board. A Crazyflie has no mode in which it follows a computer: it follows whoever speaks. So nothing is
sent to it before it was to follow, and to be armed, where it stands on the ground; one that arms by itself counts as armed only then.
"""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from hotlap.core.records import Floats
from hotlap.real_flight.clocks import FollowedClock, OffsetClock, VehicleClock
from hotlap.real_flight.crazyflie.address import Address
from hotlap.real_flight.crazyflie.packed import MOST, unpack_state
from hotlap.real_flight.crazyflie.process import Process, check_package
from hotlap.real_flight.crazyflie.status import DOWN, Status, complaint
from hotlap.real_flight.crazyflie.trajectory import fit
from hotlap.real_flight.link import LinkError, Request, Seen, Setpoint

PATIENCE, PATIENCE_FOLLOWED = 0.3, 10.0  # s of silence; a simulation may take its time
TICK = 10  # ms, of which the time between states is a multiple
ECHOES, ECHO_WAIT = 5, 0.5  # questions about how long the link takes, and s for all of them
UPLOAD = 10.0  # s
BEAT = 0.1  # s between beats of the watchdog
ASKED_ENOUGH = 3  # requests to land or hold, from which on it counts as not following, whatever it says
LARGEST_ERROR = 0.1  # m of a trajectory from the plan
STAMPS = 1 << 24  # ms after which its stamps begin anew
LEAST_PROTOCOL = 9  # of CRTP


class CrazyflieVehicle:
    """A `Link` to a Crazyflie, through a process of its own.

    Args:
        address: of the vehicle.
        period: [s] of the control loop.
        mute: whether it only listens: states are asked for, and nothing else is sent.

    Raises:
        InputError: the package is missing.
    """

    takes_throttle = False

    def __init__(self, address: Address, period: float, *, mute: bool = False) -> None:
        check_package()
        self.name, self._address, self._mute = f"crazyflie:{address.text}", address, mute
        self._follows = address.follows_clock
        self.patience = PATIENCE_FOLLOWED if self._follows else PATIENCE
        self._period = max(TICK, int(1e3 * period + 1e-6) // TICK * TICK)
        self._clock: VehicleClock = FollowedClock() if self._follows else OffsetClock()
        self._process: Process | None = None
        self._fresh: tuple[float, Floats] | None = None
        self._status, self._protocol, self._voltage = Status(0), 0, math.nan
        self._heard, self._beaten, self._travel = time.monotonic(), -math.inf, math.inf
        self._echoes, self._owed, self._turns, self._stamp = 0, -1.0, 0, -1
        self._failure, self.refusal = "", ""
        self._engaged = self._asked_to_arm = self._in_air = self._started = False
        self._released, self._uploaded = 0, -1

    def open(self, wait: float) -> str:
        """Connect, which takes its tables of names; and ask for states."""
        end = time.monotonic() + wait
        self._process = Process(self._address.uri)
        self._wait(end, lambda: self._protocol > 0, f"no Crazyflie was heard on {self.name} within {wait:g} s")
        if self._protocol < LEAST_PROTOCOL:
            raise LinkError(f"the firmware of {self.name} is too old (CRTP {self._protocol}, {LEAST_PROTOCOL} is needed): update it")
        if not self._follows:
            self._measure_travel()
        self._tell("listen", self._period)
        self._wait(end, lambda: self._fresh is not None, f"the Crazyflie on {self.name} sends no state")
        return f"Crazyflie, CRTP {self._protocol}, on {self.name}{', by trajectory' if self._address.trajectory else ''}"

    def receive(self, wait: float) -> Seen | None:
        """The newest of the states that have come."""
        end, begun = time.monotonic() + wait, self._clock.now()
        while self._fresh is None:
            left = end - time.monotonic()
            if left < 0 or self._clock.now() - begun > wait:
                return None
            self._read(left)
        (stamp, state), self._fresh = self._fresh, None
        age = max(self._clock.now() - stamp, 0.0)
        return Seen(stamp, age, state, self._armed, self._follows_us, not self._status & Status.FLYING, self._voltage)

    @property
    def now(self) -> float:
        """The vehicle's clock."""
        return self._clock.now()

    @property
    def silent_for(self) -> float:
        """Since any state."""
        return math.inf if self._failure else time.monotonic() - self._heard

    @property
    def remark(self) -> str:
        """Whose controller flies, and whether ages are known."""
        known = self._follows or math.isfinite(self._travel)
        ages = "" if known else "; echoes are not answered: states that come earliest count as fresh"
        return f"a Crazyflie flies by its own controller: the plan is flown, weights are not{ages}"

    def prepare(self, times: Floats, states: Floats) -> str:
        """See that its numbers can hold the race; upload it, where it is flown as a trajectory.

        Raises:
            LinkError: they cannot, or it does not take it.
        """
        for name, unit, values in (("position", "m", states[:, :3]), ("speed", "m/s", states[:, 7:10])):
            largest = float(np.abs(values).max())
            if largest > MOST:
                raise LinkError(f"{self.name} knows a {name} of {MOST:.1f} {unit} at most in each axis, and the race has {largest:.1f}")
        if not self._address.trajectory:
            return ""
        made = fit(times, states)
        if made.error > LARGEST_ERROR:
            raise LinkError(f"the race is too long for a trajectory on {self.name}: {made.words}; without ?trajectory it can be flown")
        if not self._mute:
            for duration, coefficients in zip(made.durations.tolist(), made.coefficients, strict=True):
                self._tell("piece", *coefficients.ravel().tolist(), duration)
            self._tell("upload")
            self._wait(time.monotonic() + UPLOAD, lambda: self._uploaded >= 0, f"{self.name} does not take the trajectory")
            if self._uploaded != len(made.durations):
                raise LinkError(f"{self.name} has no memory for a trajectory")
        return f"the trajectory has {made.words}"

    def send(self, setpoint: Setpoint) -> None:
        """A full state; or nothing, where a trajectory is flown, that has just been begun."""
        if not (self._engaged and self._armed) or self._started:
            return
        if self._address.trajectory and setpoint.race_time is not None:
            self._started = True
            self._beat()
            self._tell("start")
            return
        told = setpoint.reference
        attitude = np.roll(told[3:7], -1)
        limited = [np.clip(part, -MOST, MOST) for part in (told[:3], told[7:10], setpoint.acceleration)]
        values = np.concatenate([*limited, attitude, np.clip(told[10:13], -MOST, MOST)])
        self._tell("fly", *(round(value, 6) for value in values.tolist()))

    def request(self, request: Request) -> None:
        """Follow, arm, land, hold or stop."""
        self.refusal = ""
        if request is Request.ENGAGE:
            self._engaged, self._in_air = not self._status & DOWN, bool(self._status & Status.FLYING)
            self.refusal = complaint(self._status)
        elif request is Request.ARM:
            if not self._mute:
                self._asked_to_arm = True
            self._tell("arm", True)
        elif request is Request.DISARM:
            self._tell("stop")
        else:
            self._released += 1
            self._tell("hold" if request is Request.HOLD and not self._started else "land")  # its watchdog lets nobody leave it in the air

    def close(self) -> None:
        """End the process; where a trajectory was begun only when it has landed, for without beats its watchdog would let it fall."""
        if self._process is None:
            return
        if self._started and self._status & Status.FLYING and not self._follows and self.silent_for < self.patience:
            self._process.leave()
        self._process.close()

    @property
    def _armed(self) -> bool:
        """Whether motors may turn because that was asked for, or because it flies; one that arms itself says nothing by that."""
        flies = bool(self._status & Status.FLYING)
        by_itself = bool(self._status & Status.AUTO_ARMED) and not flies
        ours = (self._asked_to_arm or self._in_air) and not self._released
        return bool(self._status & Status.ARMED) and (ours or not by_itself)

    @property
    def _follows_us(self) -> bool:
        """Whether what it flies is ours."""
        return self._engaged and not self._status & DOWN

    def _measure_travel(self) -> None:
        """How long a word takes to it and back; half of that is how old the freshest state is."""
        end = time.monotonic() + ECHO_WAIT
        while self._echoes < ECHOES and time.monotonic() < end:
            before = self._echoes
            self._tell("echo", float(before))
            while self._echoes == before and time.monotonic() < end:
                self._read(end - time.monotonic())

    def _wait(self, end: float, is_done: Any, reason: str) -> None:
        """Read until something has come.

        Raises:
            LinkError: it does not, or the connection fails.
        """
        while not is_done():
            self._read(0.05)
            if self._failure:
                raise LinkError(f"{self.name}: {self._failure}")
            if time.monotonic() > end:
                raise LinkError(reason)

    def _read(self, wait: float) -> None:
        """Take in what has come within so many seconds; do besides what is due."""
        if self._process is None:
            return
        if self._owed >= 0:  # who owns the clock waits for it
            self._tell("echo", self._owed)
            self._owed = -1.0
        if self._started:
            self._beat()
        for word, *values in self._process.hear(min(wait, BEAT)):
            getattr(self, f"_hear_{word}")(*values)
        if self._process.ended and not self._failure:
            self._failure = "the process that speaks to it has ended"

    def _beat(self) -> None:
        """A beat of the watchdog, when it is due: nothing else would stop a trajectory where the link is lost."""
        now = self._clock.now() if self._follows else time.monotonic()
        if now - self._beaten >= BEAT:
            self._beaten = now
            self._tell("beat")

    def _hear_found(self, protocol: int) -> None:
        self._protocol = protocol

    def _hear_failed(self, reason: str) -> None:
        self._failure = reason

    def _hear_lost(self, reason: str) -> None:
        self._failure = reason

    def _hear_state(self, stamp: int, status: int, *values: int) -> None:
        if stamp < self._stamp - STAMPS // 2:
            self._turns += 1
        self._stamp, self._status = stamp, Status(status)
        moment = 1e-3 * (stamp + self._turns * STAMPS)
        self._heard = time.monotonic()
        self._clock.stamped(moment + (self._travel / 2 if math.isfinite(self._travel) else 0.0))
        self._fresh = moment, unpack_state(values)
        if self._follows:
            self._owed = float(stamp)
        if not (self._status & Status.FLYING or self._engaged):
            self._stands_at(float(self._fresh[1][2]))
        if self._released >= ASKED_ENOUGH or (self._released and (self._status & Status.COMMANDER or not self._status & Status.FLYING)):
            self._engaged = False
        if self._released and self._asked_to_arm and self._status & (Status.ARMED | Status.AUTO_ARMED | Status.FLYING) == Status.ARMED:
            self._tell("arm", False)

    def _hear_battery(self, voltage: float) -> None:
        self._voltage = voltage

    def _hear_armed(self, success: bool) -> None:
        if not success and self._asked_to_arm and not self._released:
            self.refusal = f"it does not arm: {complaint(self._status) or 'its checks before a flight are not passed'}"

    def _hear_answer(self, command: int, code: int) -> None:
        if code:
            self.refusal = f"its high-level commander refuses command {command} (error {code})"

    def _hear_uploaded(self, pieces: int) -> None:
        self._uploaded = pieces

    def _hear_echo(self, duration: float) -> None:
        self._echoes += 1
        if not self._follows:
            self._travel = min(self._travel, duration)

    def _stands_at(self, height: float) -> None:
        """Say where the ground is, so that it can be landed there even where hotlap has died."""
        self._tell("ground", round(height, 3))

    def _tell(self, word: str, *values: Any) -> None:
        """A line; who is mute says nothing but what is needed to hear."""
        if self._process is not None and (not self._mute or word in {"listen", "echo", "ground"}):
            self._process.tell(word, *values)

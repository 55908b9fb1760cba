"""A stand-in for PX4 or ArduPilot, over MAVLink: a drone of `real_flight.stand_in` behind a link that loses, delays and shuffles messages.

    python -m hotlap.real_flight.mavlink.stand_in udpout:127.0.0.1:14540 --race my-race.toml

It owns the clock. In real time it sleeps; in lockstep it asks for the time after each step and goes on when that is answered, so that a
link with `?clock=vehicle` flies as fast as both can compute, and each time alike.
"""

from __future__ import annotations

import argparse
import heapq
import math
import select
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count
from typing import Any

import numpy as np

from hotlap.core.errors import HotlapError
from hotlap.core.records import Floats
from hotlap.real_flight.link import Request
from hotlap.real_flight.mavlink.address import Address
from hotlap.real_flight.mavlink.autopilots import ARDUPILOT, ARMED, AUTOPILOTS, CUSTOM, GUIDED_OPTIONS, PX4, THRUST_AS_THRUST
from hotlap.real_flight.mavlink.frames import odometry_of, rates_told
from hotlap.real_flight.mavlink.package import connect
from hotlap.real_flight.stand_in import Mode, StandInDrone
from hotlap.reference.attitude import product

STEP, PERIOD = 0.0025, 0.01  # s between looks at what has arrived, and between states
ANSWER, ASK_AGAIN = 10.0, 0.2  # s of wall time for which lockstep waits, and between its questions
MODES = {Request.ENGAGE: Mode.FOLLOW, Request.LAND: Mode.LAND, Request.HOLD: Mode.HOLD}
UNKNOWN = [math.nan] * 21  # covariances


@dataclass(frozen=True)
class Weather:
    """What the link does to messages, and the estimator to states.

    Attributes:
        loss: share of the messages that are lost, each way.
        latency: [s] at least, each way.
        jitter: [s] more at most, evenly.
        position, velocity, attitude: standard deviations of the states' errors [m], [m/s], [-].
    """

    loss: float = 0.0
    latency: float = 0.0
    jitter: float = 0.0
    position: float = 0.0
    velocity: float = 0.0
    attitude: float = 0.0


@dataclass(frozen=True)
class Told:
    """A setpoint that has come.

    Attributes:
        time: [s].
        throttle: [-].
        state: shape (13,) the true one then.
        engaged: whether it was followed.
    """

    time: float
    throttle: float
    state: Floats
    engaged: bool


@dataclass
class StandIn:
    """An autopilot and its drone at the end of a MAVLink connection.

    Attributes:
        address: where it talks or listens, as pymavlink writes it; port 0 is any that is free.
        drone: that it flies.
        weather: of the link.
        seed: of that.
        autopilot: `PX4` or `ARDUPILOT`.
        odometry: states as ODOMETRY; False: as LOCAL_POSITION_NED and ATTITUDE_QUATERNION.
        lockstep: wait for the other end; False: real time.
        refuses: what it says when it is to be armed; "": it arms.
        options: GUID_OPTIONS of ArduPilot.
        each_step: called with itself before each step; it may change anything.
        silent: whether it sends nothing but the questions of lockstep.
        setpoints, heartbeats, requests: what has come: (time [s], what) each.
        heard: the kinds of all messages that have come.
        path: times and true states of each step.
    """

    address: str
    drone: StandInDrone
    weather: Weather = field(default_factory=Weather)
    seed: int = 0
    autopilot: int = PX4
    odometry: bool = True
    lockstep: bool = True
    refuses: str = ""
    options: int = THRUST_AS_THRUST
    each_step: Callable[[StandIn], None] = lambda _: None
    silent: bool = False
    setpoints: list[Told] = field(default_factory=list)
    heartbeats: list[float] = field(default_factory=list)
    requests: list[tuple[float, str]] = field(default_factory=list)
    heard: set[str] = field(default_factory=set)
    path: list[tuple[float, Floats]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._connection, self._messages = connect(Address(self.address, self.address), 1, 1)
        self._random = np.random.default_rng(self.seed)
        self._coming: list[tuple[float, int, Any]] = []
        self._going: list[tuple[float, int, str, tuple[Any, ...]]] = []
        self._number, self._stop, self._answered = count(), threading.Event(), 0
        self._beaten, self._steps = -math.inf, 0
        self._modes, self.ended = AUTOPILOTS[self.autopilot], False

    @property
    def port(self) -> int:
        """Of UDP, that it listens on."""
        return int(self._connection.port.getsockname()[1])

    @property
    def now(self) -> float:
        """[s] Simulated time."""
        return self.drone.time

    def stop(self) -> None:
        """Let `serve` end."""
        self._stop.set()

    def serve(self, longest: float = math.inf) -> None:
        """Fly until it is stopped, for so many seconds at most; in lockstep, until the other end answers no more."""
        begun = time.monotonic() - self.now
        try:
            while not self._stop.is_set() and self.now < longest and not self.ended:
                self.each_step(self)
                sent = self._step()
                if not self.lockstep:
                    self._listen(max(begun + self.now - time.monotonic(), 0.0))
                elif sent:
                    self._wait_for_answer()
        finally:
            self._connection.close()

    def _step(self) -> bool:
        """Take what has arrived, fly on, and send what is due; whether anything was."""
        self._listen(0.0)
        while self._coming and self._coming[0][0] <= self.now:
            self._take(heapq.heappop(self._coming)[2])
        self.drone.advance(STEP)
        self._steps += 1
        if self._steps % round(PERIOD / STEP) == 0:
            self.path.append((self.now, self.drone.state))
            self._report()
        if not self._going or self._going[0][0] > self.now:
            return False
        if self.lockstep:
            self._send("timesync", 0, self._nanoseconds)
        while self._going and self._going[0][0] <= self.now:
            _, _, kind, values = heapq.heappop(self._going)
            if not self.silent:
                self._send(kind, *values)
        return True

    @property
    def _nanoseconds(self) -> int:
        return max(round(1e9 * self.now), 1)

    def _wait_for_answer(self) -> None:
        """Ask for the time; what was sent before it has been heeded when it is answered."""
        self._answered, asked, begun = 0, -math.inf, time.monotonic()
        while self._answered != self._nanoseconds + 1 and not self._stop.is_set():
            if time.monotonic() - asked > ASK_AGAIN:
                if math.isfinite(asked) and not self.heartbeats and not self.silent:
                    self._send(*self._heartbeat)  # who has only come now knows it by this
                asked = time.monotonic()
                self._send("timesync", 0, self._nanoseconds + 1)
            self._listen(0.05)
            if self.heartbeats and time.monotonic() - begun > ANSWER:
                self.ended = True
                return

    def _report(self) -> None:
        """The state, and now and then what else there is to say."""
        state, w = self.drone.state, self.weather
        state[:3] += w.position * self._random.standard_normal(3)
        state[7:10] += w.velocity * self._random.standard_normal(3)
        state[3:7] = product(state[None, 3:7], np.array([[1.0, *(w.attitude * self._random.standard_normal(3))]]))[0]
        state[3:7] /= np.linalg.norm(state[3:7])
        odometry = odometry_of(state)
        if self.odometry:
            self._say("odometry", round(1e6 * self.now), *odometry.values(), UNKNOWN, UNKNOWN, 0)
        else:
            velocity = rates_told(state[7:10])
            stamp, rates = round(1e3 * self.now), [odometry[f"{name}speed"] for name in ("roll", "pitch", "yaw")]
            self._say("local_position_ned", stamp, odometry["x"], odometry["y"], odometry["z"], *velocity)
            self._say("attitude_quaternion", stamp, *odometry["q"], *rates)
        if self.now - self._beaten >= 1.0 - 1e-9:
            self._beat()
        if round(self.now / PERIOD) % 20 == 0:
            self._say("extended_sys_state", 0, 1 if self.drone.on_ground else 2)
            self._say("sys_status", 0, 0, 0, 0, round(1e3 * self.drone.voltage), -1, -1, 0, 0, 0, 0, 0, 0)

    def _beat(self) -> None:
        """HEARTBEAT: mode, and whether it is armed."""
        self._beaten = self.now
        self._say(*self._heartbeat)

    @property
    def _heartbeat(self) -> tuple[Any, ...]:
        custom = self._modes.custom_mode({mode: request for request, mode in MODES.items()}.get(self.drone.mode, Request.HOLD))
        base = CUSTOM | (ARMED if self.drone.armed else 0)
        return "heartbeat", self._messages.MAV_TYPE_QUADROTOR, self.autopilot, base, custom, self._messages.MAV_STATE_ACTIVE

    def _say(self, kind: str, *values: Any) -> None:
        """Send a message as the weather lets it."""
        if self._random.random() >= self.weather.loss or kind == "heartbeat":
            due = self.now + self.weather.latency + self.weather.jitter * self._random.random()
            heapq.heappush(self._going, (due, next(self._number), kind, values))

    def _send(self, kind: str, *values: Any) -> None:
        getattr(self._connection.mav, f"{kind}_send")(*values)

    def _listen(self, wait: float) -> None:
        """Take in messages for so many seconds of wall time; each arrives when the weather lets it."""
        end = time.monotonic() + wait
        while True:
            message = self._connection.recv_msg()
            if message is not None:
                self._hear(message)
                if self._answered == self._nanoseconds + 1 and self.lockstep:
                    return
                continue
            left = end - time.monotonic()
            if left <= 0:
                return
            select.select([self._connection.fd], [], [], left)
            if self.lockstep:
                end = min(end, time.monotonic())

    def _hear(self, message: Any) -> None:
        """Questions and answers about the time at once, everything else with the weather."""
        self.heard.add(message.get_type())
        if message.get_type() == "TIMESYNC":
            if message.tc1:
                self._answered = message.ts1
            elif not self.silent:
                self._send("timesync", self._nanoseconds, message.ts1)
            return
        if message.get_type() == "COMMAND_LONG" and message.command == self._messages.MAV_CMD_REQUEST_MESSAGE:
            if not self.silent:
                self._send(*self._heartbeat)
            return
        setpoint = message.get_type() == "SET_ATTITUDE_TARGET"
        if setpoint and self._random.random() < self.weather.loss:
            return
        due = self.now + self.weather.latency + self.weather.jitter * self._random.random()
        heapq.heappush(self._coming, (due, next(self._number), message))

    def _take(self, message: Any) -> None:
        """Heed a message."""
        kind = message.get_type()
        if kind == "HEARTBEAT":
            self.heartbeats.append(self.now)
        elif kind == "SET_ATTITUDE_TARGET":
            self.setpoints.append(Told(self.now, message.thrust, self.drone.state, self.drone.mode is Mode.FOLLOW))
            rates = rates_told(np.array([message.body_roll_rate, message.body_pitch_rate, message.body_yaw_rate]))
            self.drone.told(message.thrust, np.array(rates))
        elif kind == "COMMAND_LONG":
            self._obey(message)
        elif kind == "PARAM_REQUEST_READ" and self.autopilot == ARDUPILOT:
            self._say("param_value", GUIDED_OPTIONS.encode(), float(self.options), 6, 1, 0)

    def _obey(self, message: Any) -> None:
        """A command, and its answer."""
        messages, command, accepted = self._messages, message.command, True
        if command == messages.MAV_CMD_DO_SET_MODE:
            requests = [one for one, modes in self._modes.modes.items() if modes == (message.param2, message.param3)]
            accepted = bool(requests) and self.drone.change(MODES[requests[0]])
            self.requests += [(self.now, str(one)) for one in requests]
        elif command == messages.MAV_CMD_COMPONENT_ARM_DISARM:
            self.requests.append((self.now, "arm" if message.param1 else "disarm"))
            accepted = not (message.param1 and self.refuses)
            if not accepted:
                self._say("statustext", messages.MAV_SEVERITY_CRITICAL, self.refuses.encode())
            elif message.param1:
                self.drone.arm()
            else:
                self.drone.disarm()
        self._say("command_ack", command, messages.MAV_RESULT_ACCEPTED if accepted else messages.MAV_RESULT_TEMPORARILY_REJECTED)
        self._beat()


def main() -> None:
    """Serve in real time until Ctrl-C."""
    from hotlap.files.descriptions import load_race  # noqa: PLC0415  it takes its time

    parser = argparse.ArgumentParser(description="A stand-in for PX4 with a drone of hotlap's own, in real time.")
    parser.add_argument("address", help="where it talks: udpout:HOST:PORT")
    parser.add_argument("--race", default="circle-34", help="whose quadrotor it flies, from below its start")
    parser.add_argument("--thrust", type=float, default=0.85, help="thrust over that of the file")
    parser.add_argument("--loss", type=float, default=0.01, help="share of the messages that are lost")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    race = load_race(options.race)
    place = np.array(race.track.start) - np.array([0.0, 0.0, 1.5])
    drone = StandInDrone(race.vehicle, place, thrust_share=options.thrust, delay=race.vehicle.delay)
    weather = Weather(loss=options.loss, latency=0.002, jitter=0.004, position=0.01, velocity=0.02, attitude=0.002)
    StandIn(options.address, drone, weather, options.seed, lockstep=False).serve()


if __name__ == "__main__":
    try:
        main()
    except (KeyboardInterrupt, HotlapError) as error:
        raise SystemExit(str(error)) from None

"""A race that is flown in seconds, and a link to a stand-in without any protocol between."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from hotlap.files.descriptions import load_race
from hotlap.race.gate import Gate
from hotlap.race.race import JudgeSettings, NoiseSettings, Race
from hotlap.race.track import Track
from hotlap.real_flight.link import LinkError, Request, Seen, Setpoint
from hotlap.real_flight.stand_in import Mode, StandInDrone
from hotlap.reference.attitude import continuous, follow_axes, turn_rates
from hotlap.reference.reference import PERIOD, Reference
from hotlap.reference.run_out import extend
from hotlap.reference.scenario import Scenario
from hotlap.reference.segments import SegmentClass, Segments

RADIUS, SPEED, SPEED_UP, DURATION = 3.0, 5.0, 1.2, 3.0  # m, m/s, s, s
DELAY = 0.05  # s
STEP = 0.01  # s
GROUND = 0.4  # m above which the start lies 0.6 m


def make_scenario(delay: float = DELAY, offset_free: bool = False) -> Scenario:
    """An arc of 3 m radius, from rest to 5 m/s in the end, over three gates; the dead time is known."""
    times = np.arange(round(DURATION / PERIOD) + 1) * PERIOD
    share = np.clip(times / SPEED_UP, 0, 1)
    speed = SPEED * share**2 * (3 - 2 * share)
    angle = np.append(0.0, np.cumsum((speed[1:] + speed[:-1]) / 2) * PERIOD) / RADIUS
    position = np.stack([RADIUS * np.sin(angle), RADIUS * (1 - np.cos(angle)), np.full(len(times), 1.0)], axis=1)
    velocity = speed[:, None] * np.stack([np.cos(angle), np.sin(angle), np.zeros(len(times))], axis=1)
    thrusts = np.gradient(velocity, PERIOD, axis=0) + [0.0, 0.0, 9.81]
    norms = np.linalg.norm(thrusts, axis=1)
    attitude = continuous(follow_axes(thrusts / norms[:, None], np.array([1.0, 0.0, 0.0, 0.0])))
    rates = np.vstack([turn_rates(attitude, PERIOD), np.zeros((1, 3))])
    gate_times = np.array([1.5, 2.2, 2.9])
    rows = np.round(gate_times / PERIOD).astype(int)
    built_in = load_race("circle-34")
    vehicle = built_in.vehicle.model_copy(update={"delay": delay})
    race = Race(
        name="arc",
        track=Track(name="arc", start=tuple(position[0]), gates=tuple(Gate(position=tuple(position[row])) for row in rows)),
        vehicle=vehicle,
        controller=built_in.controller.model_copy(update={"offset_free": offset_free}),
        noise=NoiseSettings(),
        judge=JudgeSettings(distance=0.6, crash=3.0),
    )
    plan = Reference(position, attitude, velocity, rates, norms, np.full((len(times), 4), np.nan), gate_times, DURATION)
    reference = extend(plan, 9.81, 0.0)
    return Scenario(race, reference, Segments(np.zeros(1), (SegmentClass.FLAT,), DURATION))


def make_drone(scenario: Scenario, thrust_share: float = 0.85, delay: float = DELAY) -> StandInDrone:
    """On the ground below the start."""
    return StandInDrone(scenario.race.vehicle, np.array([*scenario.reference.position[0, :2], GROUND]), 0.0, thrust_share, delay)


class DirectLink:
    """A link to a stand-in in this process, one state every 10 ms; wall time is the drone's.

    Args:
        drone: that is flown.
        script: called with this link before each state.

    Attributes:
        states: whether states come.
        speaks: whether anything does.
        follows: whether the clock stands while nothing comes.
        period: [s] between states.
        shift: [m] by which positions are wrong.
        frozen: part of the state that is no longer measured, and a state that it is of; None: nothing.
        refuses: why it does not arm.
        sent, requests: what has come, with where the drone was; and with when.
    """

    name, takes_throttle, patience = "direct", True, 0.3

    def __init__(self, drone: StandInDrone, script: Callable[[DirectLink], None] = lambda _: None) -> None:
        self.drone, self._script = drone, script
        self.states = self.speaks = self.there = True
        self.follows, self.period, self.shift = False, STEP, np.zeros(3)
        self.frozen: tuple[slice, np.ndarray] | None = None
        self.refuses, self.refusal, self.remark, self.closed = "", "", "", False
        self.sent: list[tuple[float, Setpoint, np.ndarray]] = []
        self.requests: list[tuple[float, Request]] = []
        self._heard = 0.0
        self.prepared = (np.empty(0), np.empty((0, 13)))

    def prepare(self, times: np.ndarray, states: np.ndarray) -> str:
        self.prepared = times, states
        return ""

    def open(self, wait: float) -> str:
        if not self.there:
            raise LinkError(f"no vehicle was heard on {self.name} within {wait:g} s")
        return "a stand-in"

    def receive(self, wait: float) -> Seen | None:
        assert wait < self.patience
        self._script(self)
        self.drone.advance(self.period)
        self._heard = self.drone.time if self.speaks else self._heard
        if not (self.states and self.speaks):
            return None
        drone, state = self.drone, self.drone.state
        state[:3] += self.shift
        if self.frozen is not None:
            place, known = self.frozen
            state[place] = known[place]
        return Seen(drone.time, 0.0, state, drone.armed, drone.mode is Mode.FOLLOW, drone.on_ground, drone.voltage)

    @property
    def now(self) -> float:
        return self._heard if self.follows else self.drone.time

    @property
    def silent_for(self) -> float:
        return self.drone.time - self._heard

    def send(self, setpoint: Setpoint) -> None:
        self.sent.append((self.drone.time, setpoint, self.drone.state))
        self.drone.told(setpoint.throttle, setpoint.rates)

    def request(self, request: Request) -> None:
        self.requests.append((self.drone.time, request))
        if request is Request.ARM:
            self.refusal = self.refuses
            if not self.refuses:
                self.drone.arm()
        elif request is Request.DISARM:
            self.drone.disarm()
        else:
            self.drone.change({Request.ENGAGE: Mode.FOLLOW, Request.LAND: Mode.LAND, Request.HOLD: Mode.HOLD}[request])

    def close(self) -> None:
        self.closed = True


class PuppetLink(DirectLink):
    """A vehicle that is told a full state, and is there at once."""

    takes_throttle = False

    def __init__(self, drone: StandInDrone) -> None:
        super().__init__(drone)
        self.state, self.armed, self.engaged = drone.state, False, False

    def receive(self, wait: float) -> Seen | None:
        seen = super().receive(wait)
        assert seen is not None
        state = self.state + 1e-9 * np.sin(seen.time)  # no estimate stands still
        return dataclasses.replace(seen, state=state, armed=self.armed, engaged=self.engaged, on_ground=not self.armed)

    def send(self, setpoint: Setpoint) -> None:
        self.sent.append((self.drone.time, setpoint, self.state))
        if self.armed:
            self.state = setpoint.reference

    def request(self, request: Request) -> None:
        self.requests.append((self.drone.time, request))
        self.engaged = request in {Request.ENGAGE, Request.ARM}
        self.armed = request is Request.ARM

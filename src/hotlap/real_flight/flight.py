"""The flight of a real vehicle: wait for it, take off, hover at the start until steady, fly the race, stand, land; and stop for a reason.

    meet     heartbeat and states, how often and how old they are; where the vehicle stands
    engage   setpoints that do nothing are sent until it follows them; it is armed, if that was asked for
    take off a ramp of thrust, until it lifts
    approach to the start, with the controller on a path of its own, which learns there what thrust is worth
    race     the tuned controller on the race, begun from hovering, as it was tuned; its end is braking
    stand    hovering where that has led
    land     the autopilot does

All steps go by the vehicle's own times. Whatever stops a flight, the vehicle is asked for `on_stop`, and no setpoint is sent any more;
where it no longer follows hotlap it is asked for nothing. The autopilot's own failsafe for setpoints that cease is the last line.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from hotlap.core.errors import HotlapError, InputError
from hotlap.core.parameters import Parameters
from hotlap.core.records import Floats
from hotlap.real_flight.geofence import MARGIN, Geofence, geofence_of
from hotlap.real_flight.guard import STALE, Guard, Halt, Reason
from hotlap.real_flight.legs import Guided, Leg, Order, TakeOff
from hotlap.real_flight.link import Link, Request, Seen, Setpoint
from hotlap.real_flight.paths import offset_free, path_from_rest, scenario_of, with_braking, yaw_of
from hotlap.real_flight.place import place_here, read_place
from hotlap.real_flight.record import FlightRecord
from hotlap.real_flight.thrust_map import ThrustMap
from hotlap.reference.scenario import Scenario

RECEIVE = 0.02  # s of wall time between looks at what else may have happened
MEETING, SLOWEST = 1.0, 2.5  # s over which states are counted; control periods between them at most
ASKING = 0.5  # s between requests
ANSWER = 8.0  # s until a request has to be fulfilled
REFUSING = 1.5  # s for which a refusal is not taken for an answer
IDLE = 1.2  # s of setpoints before an autopilot is asked to follow them; PX4 wants a second
HANDING_OVER = 1.0  # s for which the controller that brakes heeds that of the race
STEADY, STEADY_FOR, UNSTEADY = (0.15, 0.15), 1.5, 20.0  # (m, m/s) and s: hovering is steady; s until it has to be
LANDING = 60.0  # s
STOPPING, STOPPING_AGAIN = 1.0, 0.1  # s over which a stop is asked for, and between times
TOLD = 2.0  # s between lines about how it goes
ABOVE_GROUND = 1.5  # m of a start whose track has no floor, where the race is placed above the vehicle


class Phase(StrEnum):
    """What is being done."""

    MEET = "meet"
    ENGAGE = "engage"
    TAKE_OFF = "take off"
    APPROACH = "approach"
    RACE = "race"
    STAND = "stand"
    LAND = "land"


@dataclass(frozen=True)
class FlightSettings:
    """How a real flight is to go.

    Attributes:
        arm: whether hotlap may arm the vehicle.
        on_stop: what it is asked for when something stops the flight.
        geofence: see `geofence`; "": around the path.
        margin: [m] around the path.
        origin: see `place`.
        speed: [m/s] to the start, at most.
        acceleration: [m/s^2] likewise.
        curve: of the throttle; see `thrust_map`.
        with_battery: whether thrust goes with the battery's voltage.
        wait: [s] of wall time for the vehicle.
    """

    arm: bool = False
    on_stop: Request = Request.LAND
    geofence: str = ""
    margin: float = MARGIN
    origin: str = "0, 0, 0, 0"
    speed: float = 1.0
    acceleration: float = 1.0
    curve: float = 0.0
    with_battery: bool = True
    wait: float = 10.0


@dataclass(frozen=True)
class Flown:
    """A real flight.

    Attributes:
        record: of all steps.
        phase: the last.
        halt: what has stopped it; None: it went to its end.
        gain: thrust as hovering showed it, over that of the file [-]; 1 where it never hovered.
        geofence: that held.
        vehicle: what it is, in words.
    """

    record: FlightRecord
    phase: Phase
    halt: Halt | None
    gain: float
    geofence: Geofence | None
    vehicle: str


class RealFlight:
    """One flight of a race.

    Args:
        link: to the vehicle; it is opened and closed here.
        scenario: what is flown.
        parameters: shape (S, K).
        settings: how.
        say: is told how it goes.

    Raises:
        InputError: the race cannot be flown from hovering, or settings are none.
    """

    def __init__(
        self, link: Link, scenario: Scenario, parameters: Parameters, settings: FlightSettings, say: Callable[[str], None] = lambda _: None
    ) -> None:
        if any(scenario.race.track.start_velocity):
            raise InputError("", "race", f"{scenario.race.name} has a flying start, and a real flight begins from hovering")
        self._link, self._settings, self._say = link, settings, say
        self._scenario, self._period = with_braking(scenario), scenario.race.controller.period
        self._vehicle, self._gravity = scenario.race.control_model, scenario.race.control_model.gravity
        self._place = read_place(settings.origin)
        geofence_of(self._scenario.reference.position, scenario.race.track, settings.geofence, settings.margin)
        self._race = Guided(self._scenario, parameters, races=True)
        self._braking = Guided(offset_free(self._scenario), parameters)
        self._default = scenario.space.first_guess(1)
        self._stand = self._hover_leg(self._scenario.reference.position[-1:], (yaw_of(self._scenario.reference.attitude[-1]),) * 2)
        self.thrust_map = ThrustMap(self._vehicle.max_acceleration, settings.curve, with_battery=settings.with_battery)
        self.record, self.phase, self.guard = FlightRecord(), Phase.MEET, Guard(Geofence(np.zeros(3), np.zeros(3)), math.inf)
        self._due, self._spoke, self._words = -math.inf, -math.inf, ""

    def fly(self) -> Flown:
        """Fly it.

        Raises:
            LinkError: there is no vehicle.
            InputError: where it stands, or what it sends, does not do.
            KeyboardInterrupt: by the user; the vehicle has been asked to stop.
        """
        halt = None
        try:
            self._words = self._link.open(self._settings.wait)
            self._say(f"found {self._words}")
            try:
                self._fly()
            except Halt as stopped:
                halt = stopped
                self._stop(halt.reason)
            except BaseException as error:
                self._stop(Reason.INTERRUPTED if isinstance(error, KeyboardInterrupt) else Reason.FAULT)
                raise
        finally:
            self._link.close()
        return Flown(self.record, self.phase, halt, self.thrust_map.gain, self.guard.geofence, self._words)

    def _fly(self) -> None:
        """All phases in order."""
        seen, stands, approach = self._meet()
        self._engage(seen, approach, stands=stands)
        if stands:
            self._take_off(seen, approach)
        self._approach(approach)
        self._fly_race()
        self._stand_still()
        self._land()

    def _meet(self) -> tuple[Seen, bool, Guided]:
        """Count states, find out where the vehicle is, and make ready what is flown.

        Returns:
            Its state (race), whether it stands on the ground, and the way to the start.

        Raises:
            InputError: it cannot be flown from there.
        """
        counted: list[Seen] = []
        for seen in self._received(self._settings.wait + MEETING):
            counted.append(seen)
            if seen.time - counted[0].time >= MEETING:
                break
        spacing = (counted[-1].time - counted[0].time) / (len(counted) - 1)
        age = float(np.median([one.age for one in counted]))
        if spacing > SLOWEST * self._period:
            needed = f"{1 / self._period:.0f} in each are wanted (controller.period), {1 / (SLOWEST * self._period):.0f} are needed"
            raise InputError("", "on", f"{self._link.name} sends {1 / spacing:.0f} states in a second: {needed}")
        seen = counted[-1]
        stands = seen.on_ground if seen.on_ground is not None else not seen.armed
        reference, track = self._scenario.reference, self._scenario.race.track
        if self._place is None:
            floor = track.floor if track.floor is not None else float(reference.position[0, 2]) - ABOVE_GROUND
            self._place = place_here(seen.state, reference.position[0], reference.attitude[0], floor)
        seen = self._place.seen(seen)
        if not seen.armed and not self._settings.arm:
            raise InputError("", "arm", f"{self._link.name} is not armed, and hotlap arms it only when that is asked for")
        path = self._way_to_start(seen.state, stands=stands)
        try:
            everything = np.vstack([path, reference.position])
            self.guard = Guard(
                geofence_of(everything, track, self._settings.geofence, self._settings.margin), self._scenario.race.judge.crash
            )
        except InputError as error:
            place = ", ".join(f"{value:.1f}" for value in seen.state[:3])
            raise InputError(error.source, error.key, f"{error.reason}; the vehicle is at ({place}) m") from None
        approach = self._hover_leg(path, (yaw_of(seen.state[3:7]), yaw_of(reference.attitude[0])))
        battery = f", battery {seen.voltage:.1f} V" if math.isfinite(seen.voltage) else ""
        self._say(f"{1 / spacing:.0f} states a second, {1e3 * age:.0f} ms old{battery}; geofence {self.guard.geofence.words}")
        return seen, stands, approach

    def _way_to_start(self, state: Floats, *, stands: bool) -> Floats:
        """Points from where it is to the start, shape (n, 3): up first, where the start is higher."""
        here, start = state[:3].copy(), self._scenario.reference.position[0]
        if stands:
            here[2] += 0.1  # where it is known to have lifted off
        above = np.array([here[0], here[1], start[2]])
        return np.array([here, above, start] if start[2] > here[2] + 0.3 and np.linalg.norm(start - above) > 0.1 else [here, start])

    def _hover_leg(self, points: Floats, yaws: tuple[float, float]) -> Guided:
        path = path_from_rest(points, yaws, self._settings.speed, self._settings.acceleration, self._gravity)
        return Guided(scenario_of(self._scenario.race, path), self._default)

    def _engage(self, seen: Seen, approach: Guided, *, stands: bool) -> None:
        """Let the vehicle follow setpoints, and arm it.

        Raises:
            Halt: it refuses, or does not answer.
        """
        self._begin(Phase.ENGAGE)
        idle = _idle(seen)
        begun = asked = self._link.now
        for state in self._states():
            if stands:
                self._send(state, idle)
            else:
                self._follow(state, approach)
            if state.engaged and (state.armed or not stands):
                break
            if state.engaged:
                self.guard.engaged = True
            wanted = Request.ARM if state.engaged else Request.ENGAGE
            if state.now - begun < IDLE or state.now - asked < ASKING:
                continue
            if self._link.refusal and state.now - begun > IDLE + REFUSING:
                raise Halt(Reason.REFUSED, self._link.refusal)
            if state.now - begun > ANSWER:
                raise Halt(Reason.REFUSED, f"no answer when asked to {wanted}")
            if wanted is Request.ARM and not self._settings.arm:
                raise Halt(Reason.DISARMED, "and hotlap arms only when that is asked for")
            self._link.request(wanted)
            asked = state.now
        self.guard.engaged = self.guard.armed = True

    def _take_off(self, seen: Seen, approach: Guided) -> None:
        """More and more thrust, until it lifts.

        Raises:
            Halt: it does not.
        """
        self._begin(Phase.TAKE_OFF)
        lag = self._vehicle.delay + sum(self._vehicle.motor_time) / 2
        leg = TakeOff(seen.state, self._gravity, lag)
        for state in self._states():
            if leg.has_lifted(state):
                self.thrust_map.correct(leg.effectiveness(state))
                approach.begin(state.now)
                self._follow(state, approach)
                return
            if leg.has_failed(state):
                raise Halt(Reason.NOT_LIFTED, f"with {100 * self.thrust_map.throttle(leg.order(state).thrust):.0f} % of the throttle")
            self._follow(state, leg)

    def _approach(self, leg: Guided) -> None:
        """Fly to the start, and hover there until that is steady; learn what thrust is worth.

        Raises:
            Halt: it does not become steady, or its thrust is not that of the file.
        """
        self._begin(Phase.APPROACH)
        if self.phase is Phase.APPROACH and math.isnan(leg.begun):
            leg.begin(self._link.now)
        start, steady_since, thrusts = self._scenario.reference.position[0], math.inf, list[float]()
        for seen in self._states():
            order = self._follow(seen, leg)
            self.guard.check_distance(seen, order.reference)
            distance, speed = float(np.linalg.norm(seen.state[:3] - start)), float(np.linalg.norm(seen.state[7:10]))
            self._tell(seen, f"{distance:.2f} m from the start, {speed:.2f} m/s")
            if distance > STEADY[0] or speed > STEADY[1]:
                steady_since, thrusts = math.inf, []
                if leg.time_of(seen) > leg.duration + UNSTEADY:
                    raise Halt(Reason.UNSTEADY, f"{distance:.2f} m from it, with {speed:.2f} m/s, after {UNSTEADY:.0f} s")
                continue
            steady_since = min(steady_since, seen.now)
            thrusts.append(order.thrust * _uprightness(seen.state))
            if seen.now - steady_since >= STEADY_FOR:
                break
        self._learn(thrusts)

    def _learn(self, thrusts: list[float]) -> None:
        """Correct the thrust map by the thrust that was commanded in hover [m/s^2].

        Raises:
            Halt: it is not that of the file.
        """
        try:
            self.thrust_map.correct(self._gravity / float(np.mean(thrusts)))
        except HotlapError as error:
            raise Halt(Reason.THRUST, str(error)) from None
        self._say(
            f"hovers with {100 * self.thrust_map.hover_throttle:.0f} % of the throttle: thrust is {self.thrust_map.gain:.2f} of the file's"
        )

    def _fly_race(self) -> None:
        """The race; then braking, by a controller that learns, for at this speed and tilt drag presses a drone down."""
        self._begin(Phase.RACE)
        race, braking, end = self._race, self._braking, self._scenario.reference.duration
        for seen in self._states():
            if self.record.race_begun is None:
                race.begin(seen.now)
                braking.begin(seen.now)
                self.record.race_begun = seen.now
            time = race.time_of(seen)
            order = self._follow(seen, race if time < end else braking)
            if end - HANDING_OVER <= time < end:
                braking.heed(seen, order)
            self.guard.check_distance(seen, order.reference)
            self._tell(seen, f"{time:.1f} of {end:.1f} s" if time < end else "braking")
            if time >= race.duration - 1.0:
                return

    def _stand_still(self) -> None:
        """Hover where braking has led."""
        self._begin(Phase.STAND)
        for seen in self._states():
            self._follow(seen, self._stand)
            if self._stand.time_of(seen) >= self._stand.duration:
                return

    def _land(self) -> None:
        """Let the autopilot land; it disarms by itself."""
        self._begin(Phase.LAND)
        self.guard.engaged = self.guard.armed = False
        begun, asked = self._link.now, -math.inf
        for seen in self._states():
            if not seen.armed or (seen.on_ground and not seen.engaged):
                return
            if seen.engaged and seen.now - asked >= ASKING:
                self._link.request(Request.LAND)
                asked = seen.now
            self._tell(seen, f"{seen.state[2]:.1f} m high")
            if seen.now - begun > LANDING:
                raise Halt(Reason.REFUSED, f"it has not landed in {LANDING:.0f} s")

    def _begin(self, phase: Phase) -> None:
        self.phase = phase
        self._spoke = self._link.now
        self._say(phase)

    def _tell(self, seen: Seen, words: str) -> None:
        """Say how it goes, now and then."""
        if seen.now - self._spoke >= TOLD:
            self._spoke = seen.now
            self._say(f"{self.phase}: {words}")

    def _follow(self, seen: Seen, leg: Leg) -> Order:
        """Compute a command, and send it."""
        order = leg.order(seen)
        self.record.add(seen, order, self._send(seen, order))
        return order

    def _send(self, seen: Seen, order: Order) -> float:
        """Send a command; gives its throttle."""
        assert self._place is not None, "it is known since the vehicle was met"  # noqa: S101  our own mistake
        throttle = self.thrust_map.throttle(order.thrust) if self._link.takes_throttle else math.nan
        told, acceleration = self._place.told(order.reference), self._place.turned(order.acceleration)
        self._link.send(Setpoint(seen.now, order.thrust, throttle, order.rates, told, acceleration, order.race_time))
        return throttle

    def _states(self) -> Iterator[Seen]:
        """States (race) that a command is due for; each has passed the guard, all between them, too.

        Raises:
            Halt: see `Guard`; or nothing is heard.
        """
        assert self._place is not None, "it is known since the vehicle was met"  # noqa: S101  our own mistake
        for received in self._received(math.inf):
            seen = self._place.seen(received)
            self.thrust_map.hear(seen.now, seen.voltage)
            self.guard.check(seen)
            if seen.now < self._due - 0.25 * self._period:
                continue
            self._due = max(self._due, seen.now - 0.5 * self._period) + self._period
            yield seen

    def _received(self, most: float) -> Iterator[Seen]:
        """States as they come, in the vehicle's world.

        Args:
            most: [s] of wall time that may pass in all.

        Raises:
            Halt: nothing is heard, or no state comes.
        """
        begun, last = time.monotonic(), self._link.now
        while time.monotonic() - begun < most:
            seen = self._link.receive(RECEIVE)
            if self._link.silent_for > self._link.patience:
                raise Halt(Reason.LINK, f"nothing was heard for {self._link.silent_for:.2f} s")
            if seen is not None:
                last = seen.time
                yield seen
            elif self._link.now - last > STALE and self.phase is not Phase.MEET:
                raise Halt(Reason.STALE, f"{self._link.now - last:.2f} s")
        raise Halt(Reason.STALE, f"too few came within {most:.0f} s")

    def _stop(self, reason: Reason) -> None:
        """Ask the vehicle to stop, for a while, unless it is not ours."""
        if self.phase is Phase.MEET or reason in {Reason.TAKEN_OVER, Reason.DISARMED}:
            return
        request = self._settings.on_stop
        self._say(f"stopping: {request}")
        begun = asked = time.monotonic()
        self._link.request(request)
        while time.monotonic() - begun < STOPPING:
            seen = self._link.receive(RECEIVE)
            if seen is not None and not seen.engaged:
                return
            if time.monotonic() - asked >= STOPPING_AGAIN:
                self._link.request(request)
                asked = time.monotonic()


def _idle(seen: Seen) -> Order:
    """What does nothing: no thrust, no turning."""
    return Order(0.0, np.zeros(3), seen.state, np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))


def _uprightness(state: Floats) -> float:
    """Cosine of the tilt of a state, shape (13,)."""
    _, x, y, _ = state[3:7].tolist()
    return 1 - 2 * (x * x + y * y)

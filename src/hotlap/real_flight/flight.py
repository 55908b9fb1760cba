"""The flight of a real vehicle: wait for it, take off, hover at the start until steady, fly the race, stand, land; and stop for a reason.

    meet     heartbeat and states, how often and how old they are; where the vehicle stands
    engage   setpoints that do nothing are sent until it follows them; it is armed, if that was asked for
    take off a ramp of thrust, until it lifts
    approach to the start, with the controller on a path of its own, which learns there what thrust is worth
    race     the tuned controller on the race, begun from hovering, as it was tuned; then braking
    stand    hovering where that has led
    land     the autopilot does

All steps go by the vehicle's own times. Whatever stops a flight, the vehicle is asked for `on_stop`, and no setpoint is sent any more;
where it does not follow hotlap it is asked for nothing: a pilot, or its own landing, has it. The autopilot's own failsafe for setpoints
that cease is the last line.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from hotlap.core.errors import HotlapError, InputError
from hotlap.core.parameters import Parameters
from hotlap.core.records import Floats
from hotlap.real_flight.course import Course
from hotlap.real_flight.guard import Halt, Reason, check_usable
from hotlap.real_flight.legs import Along, TakeOff
from hotlap.real_flight.link import Link, Request, Seen
from hotlap.real_flight.order import Order
from hotlap.real_flight.paths import yaw_of
from hotlap.real_flight.place import Place, read_place
from hotlap.real_flight.settings import FlightSettings, Flown, Phase
from hotlap.real_flight.stream import Stream
from hotlap.real_flight.thrust_map import ThrustMap
from hotlap.reference.scenario import Scenario

MEETING, SLOWEST = 1.0, 2.5  # s over which states are counted; control periods between them at most
ASKING = 0.5  # s between requests
ANSWER, REFUSING = 8.0, 2.5  # s until a request has to be fulfilled, and from which on a refusal is an answer
IDLE = 1.2  # s of setpoints before an autopilot is asked to follow them; PX4 wants a second
MOVED = 1.0  # m from where it was met to where it follows, at most: the way to the start begins there
HANDING_OVER = 1.0  # s for which the controller that brakes heeds that of the race
STEADY, STEADY_FOR, UNSTEADY = (0.15, 0.15), 1.5, 20.0  # (m, m/s) and s: hovering is steady; s until it has to be
STANDING = 1.0  # s at the end of braking
LANDING, LANDED = 60.0, 5.0  # s: until it has landed; on the ground, where it has not disarmed
TOLD = 2.0  # s between lines about how it goes
NOTHING = np.array([1.0, 0.0, 0.0, 0.0])  # estimates of who estimates nothing


class RealFlight:
    """One flight of a race.

    Args:
        link: to the vehicle; it is opened and closed here.
        scenario: what is flown.
        parameters: shape (S, K).
        settings: how.
        say: is told how it goes.

    Attributes:
        settings: how.
        phase: what is being done.
        stream: states and commands.
        thrust_map: what hovering has taught.
        asked_to: what it was asked for when something stopped the flight; None: nothing.

    Raises:
        InputError: the race cannot be flown from hovering, or settings are none.
    """

    def __init__(
        self, link: Link, scenario: Scenario, parameters: Parameters, settings: FlightSettings, say: Callable[[str], None] = lambda _: None
    ) -> None:
        model, self._period = scenario.race.control_model, scenario.race.controller.period
        self._link, self.settings, self._say, self._race = link, settings, say, scenario.race
        self._place, self._course = read_place(settings.origin), Course(scenario, parameters, settings, steers=link.takes_throttle)
        self.thrust_map = ThrustMap(model.max_acceleration, settings.curve, with_battery=settings.with_battery)
        self.phase, self.stream = Phase.MEET, Stream(link, self._period, self.thrust_map, self._place or Place(np.zeros(3)))
        self._spoke, self._asked_to_follow = -math.inf, False
        self.asked_to: Request | None = None

    def fly(self) -> Flown:
        """Fly it.

        Raises:
            LinkError: there is no vehicle.
            InputError: where it stands, or what it sends, does not do.
            KeyboardInterrupt: by the user; the vehicle has been asked to stop, see `asked_to`.
        """
        halt, vehicle = None, ""
        try:
            vehicle = self._link.open(self.settings.wait)
            self._say(f"found {vehicle}")
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
        gain = self.thrust_map.gain if self._link.takes_throttle else math.nan
        return Flown(self.stream.record, self.phase, halt, gain, self.stream.guard.geofence, vehicle)

    def look(self, duration: float) -> None:
        """Say for a while what would be sent to hover where the vehicle is, and send nothing.

        Args:
            duration: [s] of the vehicle's clock.

        Raises:
            LinkError: there is no vehicle.
            InputError: where it stands, or what it sends, does not do.
            Halt: a limit is passed, at which a flight would be stopped.
        """
        try:
            self._say(f"found {self._link.open(self.settings.wait)}")
            seen = self._meet()
            heading = yaw_of(seen.state[3:7])
            here = self._course.hover(seen.state[None, :3], (heading, heading), learns=False)
            begun, self._spoke = seen.now, -math.inf
            for state in self.stream.states():
                place = ", ".join(f"{value:.2f}" for value in state.state[:3])
                self._tell(state, f"at ({place}) m would send {self._words(here.order(state))}")
                if state.now - begun >= duration:
                    return
        finally:
            self._link.close()

    def _words(self, order: Order) -> str:
        """What would be sent for an order, for people."""
        if not self._link.takes_throttle:
            return f"position ({', '.join(f'{value:.2f}' for value in order.reference[:3])}) m, to its own controller"
        rates = ", ".join(f"{rate:.2f}" for rate in order.rates)
        return f"thrust {order.thrust:.2f} m/s^2, throttle {100 * self.stream.throttle(order):.0f} %, rates ({rates}) rad/s"

    def _fly(self) -> None:
        """All phases in order."""
        seen = self._meet()
        if not seen.armed and not self.settings.arm:
            raise InputError("", "arm", f"{self._link.name} is not armed, and hotlap arms it only when that is asked for")
        approach, self.stream.guard.geofence = self._course.approach(seen.state, stands=_stands(seen))
        self.stream.guard.farthest = min(self.settings.stray, self._race.judge.crash)
        self._say(f"geofence {self.stream.guard.geofence.words}")
        reference = self._course.scenario.reference
        states = np.hstack([reference.position, reference.attitude, reference.velocity, reference.rates])
        if told := self._link.prepare(reference.times, self.stream.place.told_all(states)):
            self._say(f"note: {told}")
        self._engage(seen, approach)
        if _stands(seen) and self._link.takes_throttle:
            self._take_off(seen, approach)
        self._approach(approach)
        self._fly_race()
        self._stand_still()
        self._land()

    def _meet(self) -> Seen:
        """Count states, and find out where the vehicle is.

        Returns:
            Its state (race).

        Raises:
            InputError: states are too few.
            Halt: there are none, or they cannot be flown with.
        """
        counted: list[Seen] = []
        for seen in self.stream.received(self.settings.wait + MEETING, math.inf):
            counted.append(seen)
            if seen.time - counted[0].time >= MEETING:
                break
        spacing = (counted[-1].time - counted[0].time) / (len(counted) - 1)
        age = float(np.median([one.age for one in counted]))
        seen = counted[-1]
        battery = f", battery {seen.voltage:.1f} V" if math.isfinite(seen.voltage) else ""
        self._say(f"{1 / spacing:.0f} states a second, {1e3 * age:.0f} ms old{battery}")
        if self._link.remark:
            self._say(f"note: {self._link.remark}")
        if spacing > SLOWEST * self._period:
            needed = f"{1 / self._period:.0f} are wanted (controller.period), {1 / (SLOWEST * self._period):.0f} are needed"
            raise InputError("", "on", f"{self._link.name} sends {1 / spacing:.0f} states in a second: {needed}")
        check_usable(seen)
        if self._place is None:
            self.stream.place = self._course.above(seen.state)
        return self.stream.place.seen(seen)

    def _engage(self, seen: Seen, approach: Along) -> None:
        """Let the vehicle follow setpoints, and arm it.

        Raises:
            Halt: it refuses, does not answer, is disarmed, or has moved meanwhile.
        """
        self._begin(Phase.ENGAGE)
        idle, stands, guard = Order(0.0, np.zeros(3), seen.state, np.zeros(3), NOTHING), _stands(seen), self.stream.guard
        guard.armed = seen.armed or not stands
        begun = asked = self._link.now
        for state in self.stream.states():
            self.stream.send(state, idle if stands else approach.order(state))
            guard.engaged, guard.armed = guard.engaged or state.engaged, guard.armed or state.armed
            if state.engaged and state.armed:
                moved = float(np.linalg.norm(state.state[:3] - seen.state[:3]))
                if moved > MOVED:
                    raise Halt(Reason.JUMP, f"it is {moved:.1f} m from where it was met")
                break
            if state.now - begun < IDLE or state.now - asked < ASKING:
                continue
            wanted = Request.ARM if state.engaged else Request.ENGAGE
            if self._link.refusal and state.now - begun > REFUSING:
                raise Halt(Reason.REFUSED, self._link.refusal)
            if state.now - begun > ANSWER:
                raise Halt(Reason.REFUSED, f"no answer when asked to {wanted}")
            if wanted is Request.ARM and not self.settings.arm:
                raise Halt(Reason.DISARMED, "and hotlap arms only when that is asked for")
            self._link.request(wanted)
            self._asked_to_follow, asked = True, state.now
        approach.begin(self._link.now)

    def _take_off(self, seen: Seen, approach: Along) -> None:
        """More and more thrust, until it lifts.

        Raises:
            Halt: it does not.
        """
        self._begin(Phase.TAKE_OFF)
        model = self._race.control_model
        leg = TakeOff(seen.state, model.gravity, model.delay + sum(model.motor_time) / 2)
        for state in self.stream.states():
            if leg.has_lifted(state):
                self._learn(leg.effectiveness(state))
                approach.begin(state.now)
                self.stream.follow(state, approach)
                return
            if leg.has_tipped(state):
                raise Halt(Reason.NOT_LIFTED, "it tips over")
            throttle = self.stream.send(state, leg.order(state))  # not recorded: the ground carries it
            if leg.has_failed(state):
                raise Halt(Reason.NOT_LIFTED, f"with {100 * throttle:.0f} % of the throttle")

    def _approach(self, leg: Along) -> None:
        """Fly to the start, and hover there until that is steady; learn what thrust is worth.

        Raises:
            Halt: it does not become steady, or its thrust is not that of the file.
        """
        self._begin(Phase.APPROACH)
        since, first, thrusts = self._link.now, 0.0, list[float]()
        for seen in self.stream.states():
            order = self.stream.follow(seen, leg)
            distance, speed = (float(np.linalg.norm(part)) for part in (seen.state[:3] - self._course.start, seen.state[7:10]))
            self._tell(seen, f"{distance:.2f} m from the start, {speed:.2f} m/s")
            if distance > STEADY[0] or speed > STEADY[1]:
                thrusts = []
                if leg.time_of(seen) > leg.duration + UNSTEADY:
                    raise Halt(Reason.UNSTEADY, f"{distance:.2f} m from it, with {speed:.2f} m/s, after {UNSTEADY:.0f} s")
                continue
            if not thrusts:
                since, first = seen.now, float(seen.state[9])
            thrusts.append(order.thrust * _uprightness(seen.state))
            if seen.now - since >= STEADY_FOR:
                acted = self._race.control_model.gravity + (float(seen.state[9]) - first) / (seen.now - since)
                self._learn(acted / float(np.mean(thrusts)))
                break
        throttle, gain = 100 * self.thrust_map.hover_throttle, self.thrust_map.gain
        if self._link.takes_throttle:
            self._say(f"hovers with {throttle:.0f} % of the throttle: thrust is {gain:.2f} of the file's")

    def _learn(self, gain: float) -> None:
        """Correct the thrust map by the thrust that acted over that which was asked for [-].

        Raises:
            Halt: it is not that of the file.
        """
        if not self._link.takes_throttle:
            return
        try:
            self.thrust_map.correct(gain)
        except HotlapError as error:
            raise Halt(Reason.THRUST, str(error)) from None

    def _fly_race(self) -> None:
        """The race; then braking, by a controller that learns, for at this speed and tilt drag presses a drone down."""
        self._begin(Phase.RACE)
        race, braking, end = self._course.race, self._course.braking, self._course.scenario.reference.duration
        for seen in self.stream.states():
            if self.stream.record.race_begun is None:
                self.stream.record.race_begun = seen.now
                race.begin(seen.now)
                braking.begin(seen.now)
            time = race.time_of(seen)
            order = self.stream.follow(seen, race if time < end else braking)
            if end - HANDING_OVER <= time < end:
                braking.heed(seen, order)
            self._tell(seen, f"{time:.1f} of {end:.1f} s" if time < end else "braking")
            if time >= race.duration - STANDING:
                return

    def _stand_still(self) -> None:
        """Hover where braking has led."""
        self._begin(Phase.STAND)
        leg = self._course.stand
        for seen in self.stream.states():
            self.stream.follow(seen, leg)
            if leg.time_of(seen) >= leg.duration:
                return

    def _land(self) -> None:
        """Let the autopilot land; it disarms by itself.

        Raises:
            Halt: it does not.
        """
        self._begin(Phase.LAND)
        self.stream.guard.engaged = self.stream.guard.armed = False
        begun, asked, landed = self._link.now, -math.inf, math.inf
        for seen in self.stream.states():
            landed = min(landed, seen.now) if seen.on_ground else math.inf
            if not seen.armed or seen.now - landed > LANDED:
                return
            if seen.engaged and seen.now - asked >= ASKING:
                self._link.request(Request.LAND)
                asked = seen.now
            self._tell(seen, f"at a height of {seen.state[2]:.1f} m")
            if seen.now - begun > LANDING:
                raise Halt(Reason.REFUSED, f"it has not landed in {LANDING:.0f} s")

    def _begin(self, phase: Phase) -> None:
        self.phase, self._spoke = phase, self._link.now
        self._say(phase)

    def _tell(self, seen: Seen, words: str) -> None:
        """Say how it goes, now and then."""
        if seen.now - self._spoke >= TOLD:
            self._spoke = seen.now
            self._say(f"{self.phase}: {words}")

    def _stop(self, reason: Reason) -> None:
        """Ask the vehicle to stop, unless it is not ours."""
        if not self._is_ours(reason):
            return
        self.asked_to = Request.LAND if self.phase is Phase.LAND else self.settings.on_stop  # who lands is not stopped in the air
        self._say(f"stopping: {self.asked_to}")
        self.stream.stop(self.asked_to)
        if self._link.refusal:
            self._say(f"note: {self._link.refusal}")

    def _is_ours(self, reason: Reason) -> bool:
        """Whether the vehicle follows hotlap, or is about to; whoever else flies it must not be disturbed."""
        last = self.stream.guard.last
        if self.phase is Phase.MEET or reason in {Reason.TAKEN_OVER, Reason.DISARMED}:
            return False
        if last is not None and last.engaged:
            return True
        return self.phase is Phase.ENGAGE and self._asked_to_follow and reason is not Reason.REFUSED


def _stands(seen: Seen) -> bool:
    """Whether it is on the ground; who is armed and does not say so is taken to fly."""
    return seen.on_ground if seen.on_ground is not None else not seen.armed


def _uprightness(state: Floats) -> float:
    """Cosine of the tilt of a state, shape (13,)."""
    _, x, y, _ = state[3:7].tolist()
    return 1 - 2 * (x * x + y * y)

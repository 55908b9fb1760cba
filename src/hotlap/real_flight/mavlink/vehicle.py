"""A vehicle that speaks MAVLink: PX4 or ArduPilot."""

from __future__ import annotations

import math
import time
from collections import deque
from typing import Any

from hotlap.core.records import Floats
from hotlap.real_flight.clocks import FollowedClock, OffsetClock, VehicleClock
from hotlap.real_flight.link import LinkError, Request, Seen, Setpoint
from hotlap.real_flight.mavlink.address import Address
from hotlap.real_flight.mavlink.autopilots import (
    ARDUPILOT,
    ARMED,
    AUTOPILOTS,
    COPTERS,
    CUSTOM,
    GUIDED_OPTIONS,
    RESULTS,
    THRUST_AS_THRUST,
)
from hotlap.real_flight.mavlink.frames import rates_told
from hotlap.real_flight.mavlink.line import Line, Sender
from hotlap.real_flight.mavlink.package import connect
from hotlap.real_flight.mavlink.states import States

OUR_SYSTEM, OUR_COMPONENT = 245, 191  # until the vehicle's system is known; an onboard computer
PATIENCE, PATIENCE_FOLLOWED = 0.3, 10.0  # s of silence; a simulation may take its time
BEAT, ASK = 1.0, 0.5  # s between heartbeats, and between questions about the time
STILL = 0.2  # s between questions whether it still follows, for an autopilot says so once a second only
DRAINING = 0.05  # s for which what has come meanwhile is read before the newest state is flown with
QUESTIONS = 20  # about the time, that an answer may be to
HEARTBEATS = 3.0  # s without one of the vehicle's: it is lost, whatever else comes
ASK_AGAIN = 1.0  # s between requests for messages
RATES_ONLY = 128  # ATTITUDE_TARGET_TYPEMASK: the attitude is to be ignored
FORCED = 21196.0  # what lets motors be stopped in flight
NOWHERE = (1.0, 0.0, 0.0, 0.0)
VOLTAGE_UNKNOWN = 65535  # mV
WARNING = 4  # MAV_SEVERITY: worse ones are smaller
STOPS = (Request.LAND, Request.HOLD, Request.DISARM)
SLOW = {245: 5.0, 1: 2.0}  # [1/s] EXTENDED_SYS_STATE, SYS_STATUS


class MavlinkVehicle:
    """A `Link` over MAVLink 2.

    Args:
        address: of the vehicle.
        period: [s] of the control loop.
        mute: whether it only listens: it sends heartbeats and nothing else.

    Raises:
        LinkError: the connection cannot be opened.
        InputError: the package is missing.
    """

    takes_throttle = True

    def __init__(self, address: Address, period: float, *, mute: bool = False) -> None:
        self.name, self._period, self._follows = f"mavlink:{address.text}", period, address.follows_clock
        self.patience = PATIENCE_FOLLOWED if self._follows else PATIENCE
        self._mute = mute
        connection, self._messages = connect(address, OUR_SYSTEM, OUR_COMPONENT)
        self._line = Line(connection, self._messages)
        self._clock: VehicleClock = FollowedClock() if self._follows else OffsetClock()
        self._states, self._fresh = States(), list[tuple[float, Any]]()
        self._target, self._autopilot, self._kind = (0, 0), AUTOPILOTS[ARDUPILOT], 0
        self._sender: Sender = None
        self._rival, self._questions = "", deque[int](maxlen=QUESTIONS)
        self._armed, self._engaged, self._left, self._on_ground, self._voltage = False, False, False, None, math.nan
        self._heard = self._heartbeat = time.monotonic()
        self._beaten = self._asked = self._asked_still = -math.inf
        self._refusal, self._complaint, self._options = "", "", math.nan

    def open(self, wait: float) -> str:
        """Wait for a heartbeat, ask for states, and see that ArduPilot takes thrust for thrust."""
        self._line.forget()
        end = time.monotonic() + wait
        while not self._kind:
            self._read(0.05)
            if time.monotonic() > end:
                hint = ": does it send to this port?" if ":udpin:" in self.name else ""
                raise LinkError(f"no vehicle was heard on {self.name} within {wait:g} s{hint}")
        asked = -math.inf
        asks = self._kind == ARDUPILOT and not self._mute
        while not self._fresh or (asks and math.isnan(self._options)):
            if time.monotonic() - asked > ASK_AGAIN:
                asked = time.monotonic()
                self._ask_for_messages()
            self._read(0.05)
            if time.monotonic() > end:
                raise LinkError(self._missing())
        self._check_alone()
        if asks and not int(self._options) & THRUST_AS_THRUST:
            told = f"{GUIDED_OPTIONS} is {int(self._options)}: set its bit 3 (+{THRUST_AS_THRUST})"
            raise LinkError(f"{told}, else ArduPilot takes the thrust on {self.name} for a climb rate")
        return f"{self._autopilot.name}, system {self._target[0]}, on {self.name}"

    def receive(self, wait: float) -> Seen | None:
        """The next state; in real time the newest of those that have come."""
        end, begun = time.monotonic() + wait, self._clock.now()
        while not self._fresh:
            left = end - time.monotonic()
            if left < 0 or self._clock.now() - begun > wait:
                return None
            self._read(left)
        end = time.monotonic() + DRAINING
        while not self._follows and time.monotonic() < end and self._read(0.0):
            pass  # whatever has come meanwhile, so that no old state is flown with
        self._check_alone()
        stamp, state = self._fresh[-1]
        self._fresh.clear()
        age = max(self._clock.now() - stamp, 0.0)
        return Seen(stamp, age, state, self._armed, self._engaged, self._on_ground, self._voltage, self._states.resets)

    @property
    def now(self) -> float:
        """The vehicle's clock."""
        return self._clock.now()

    @property
    def silent_for(self) -> float:
        """Since any message; one whose heartbeats have ceased counts as silent, too."""
        now = time.monotonic()
        without = 0.0 if self._follows else now - self._heartbeat - HEARTBEATS + self.patience
        return max(now - self._heard, without)

    @property
    def remark(self) -> str:
        """Whether ages are known."""
        if self._mute or not isinstance(self._clock, OffsetClock) or self._clock.is_synchronised:
            return ""
        return "TIMESYNC is not answered: how old states are is not known, those that come earliest count as fresh"

    @property
    def refusal(self) -> str:
        """What COMMAND_ACK said to the last request, and the last complaint of the autopilot."""
        return f"{self._refusal}{f' ({self._complaint})' if self._complaint else ''}" if self._refusal else ""

    def prepare(self, times: Floats, states: Floats) -> str:
        """Nothing: it follows setpoints."""
        del times, states
        return ""

    def send(self, setpoint: Setpoint) -> None:
        """SET_ATTITUDE_TARGET with rates and thrust."""
        stamp = int(1e3 * setpoint.time) % 2**32
        self._write("set_attitude_target", stamp, *self._target, RATES_ONLY, NOWHERE, *rates_told(setpoint.rates), setpoint.throttle)

    def request(self, request: Request) -> None:
        """A mode, or COMPONENT_ARM_DISARM; who has followed and no longer does is not asked to stop: it is a pilot's now."""
        self._refusal = self._complaint = ""
        self._line.only_kept = True
        if self._left and request in STOPS:
            self._refusal = "it no longer follows hotlap, and is left alone"
            return
        if request in self._autopilot.modes:
            main, sub = self._autopilot.modes[request]
            self._command(self._messages.MAV_CMD_DO_SET_MODE, CUSTOM, main, sub)
        elif request is Request.ARM:
            self._command(self._messages.MAV_CMD_COMPONENT_ARM_DISARM, 1)
        else:
            self._command(self._messages.MAV_CMD_COMPONENT_ARM_DISARM, 0, FORCED)

    def close(self) -> None:
        """Close the connection."""
        self._line.close()

    def _read(self, wait: float) -> bool:
        """Take in one message, if there is one within so many seconds; do besides what is due."""
        self._keep_up()
        heard = self._line.receive()
        if heard is None and wait > 0:
            self._line.wait(min(wait, BEAT / 4))
            heard = self._line.receive()
        if heard is None:
            return False
        self._hear(*heard)
        return True

    def _keep_up(self) -> None:
        """Send a heartbeat, and ask for the time, where that is due."""
        now = self._clock.now() if self._follows else time.monotonic()
        if now - self._beaten >= BEAT or now < self._beaten:
            self._beaten = now
            active = self._messages.MAV_STATE_ACTIVE
            self._write("heartbeat", self._messages.MAV_TYPE_ONBOARD_CONTROLLER, self._messages.MAV_AUTOPILOT_INVALID, 0, 0, active)
        if self._kind and (now - self._asked >= ASK or now < self._asked):
            self._asked = now
            self._questions.append(round(1e9 * self._clock.ours()))
            self._write("timesync", 0, self._questions[-1])
        if self._engaged and (now - self._asked_still >= STILL or now < self._asked_still):
            self._asked_still = now
            self._command(self._messages.MAV_CMD_REQUEST_MESSAGE, self._messages.MAVLINK_MSG_ID_HEARTBEAT)

    def _hear(self, message: Any, sender: Sender) -> None:
        """Take in a message of the vehicle's; of others nothing counts, but that they are there."""
        kind = message.get_type()
        if kind == "HEARTBEAT":
            self._meet(message, sender)
        if not self._kind or (sender, message.get_srcSystem(), message.get_srcComponent()) != (self._sender, *self._target):
            return
        self._heard = time.monotonic()
        if kind == "TIMESYNC":
            self._hear_time(message)
        elif kind == "HEARTBEAT":
            self._heartbeat = self._heard
            self._armed = bool(message.base_mode & ARMED)
            before = self._engaged
            self._engaged = bool(message.base_mode & CUSTOM) and self._autopilot.is_engaged(message.custom_mode)
            self._left = not self._engaged and (before or self._left)
        elif kind == "EXTENDED_SYS_STATE":
            self._on_ground = {1: True, 2: False, 3: False, 4: False}.get(message.landed_state)
        elif kind == "SYS_STATUS":
            self._voltage = math.nan if message.voltage_battery in {0, VOLTAGE_UNKNOWN} else 1e-3 * message.voltage_battery
        elif kind == "COMMAND_ACK":
            self._hear_answer(message)
        elif kind == "STATUSTEXT" and message.severity <= WARNING:
            self._complaint = " ".join(str(message.text).split())
        elif kind == "PARAM_VALUE" and message.param_id == GUIDED_OPTIONS and math.isfinite(message.param_value):
            self._options = float(message.param_value)
        else:
            made = self._states.hear(message)
            if made is not None:
                self._clock.stamped(made[0])
                self._fresh.append(made)

    def _meet(self, message: Any, sender: Sender) -> None:
        """A heartbeat of an autopilot that is known here: the first is the vehicle's; that of another one is no good sign."""
        if message.autopilot not in AUTOPILOTS or message.type not in COPTERS:
            return
        target = message.get_srcSystem(), message.get_srcComponent()
        if not self._kind:
            self._kind, self._autopilot = message.autopilot, AUTOPILOTS[message.autopilot]
            self._target, self._sender = target, sender
            self._line.keep(sender, target[0])  # as a part of the vehicle
        elif (sender, target) != (self._sender, self._target):
            self._rival = _called(target, sender)

    def _check_alone(self) -> None:
        """Look at whether it is clear who is to be flown, before anything is asked for.

        Raises:
            LinkError: there are two.
        """
        if self._rival and not self._line.only_kept:
            both = f"{_called(self._target, self._sender)} and {self._rival}"
            raise LinkError(f"two vehicles are heard on {self.name}: {both}; give each a port of its own")

    def _hear_time(self, message: Any) -> None:
        """A question about the time is answered; an answer is compared."""
        if message.tc1 == 0:
            self._clock.told(1e-9 * message.ts1)
            self._write("timesync", max(round(1e9 * self._clock.ours()), 1), message.ts1)
        elif message.ts1 in self._questions:
            self._clock.answered(1e-9 * message.ts1, 1e-9 * message.tc1)

    def _hear_answer(self, message: Any) -> None:
        modes = {self._messages.MAV_CMD_DO_SET_MODE: "mode", self._messages.MAV_CMD_COMPONENT_ARM_DISARM: "arming"}
        for_us = message.target_system in {0, self._line.system} and message.target_component in {0, OUR_COMPONENT}
        if for_us and message.command in modes and message.result not in {0, 5}:
            result = RESULTS[message.result] if message.result < len(RESULTS) else f"answered {message.result}"
            self._refusal = f"{modes[message.command]} {result}"

    def _ask_for_messages(self) -> None:
        """How often states are wanted, and what else."""
        messages = self._messages
        states = (messages.MAVLINK_MSG_ID_ODOMETRY, messages.MAVLINK_MSG_ID_LOCAL_POSITION_NED, messages.MAVLINK_MSG_ID_ATTITUDE_QUATERNION)
        for number, rate in {**dict.fromkeys(states, 1 / self._period), **SLOW}.items():
            self._command(messages.MAV_CMD_SET_MESSAGE_INTERVAL, number, round(1e6 / rate))
        if self._kind == ARDUPILOT:
            self._write("param_request_read", *self._target, GUIDED_OPTIONS.encode(), -1)

    def _missing(self) -> str:
        """What an opened vehicle does not send."""
        if self._fresh:
            return f"ArduPilot on {self.name} does not tell its parameter {GUIDED_OPTIONS}, which says what thrust means to it"
        if self._states.unknown_frames:
            return f"the frames of ODOMETRY on {self.name} are not known: {self._states.unknown_frames} (MAV_FRAME); NED and FRD are"
        either = "neither ODOMETRY nor LOCAL_POSITION_NED with ATTITUDE_QUATERNION"
        return f"{self._autopilot.name} on {self.name} sends {either}: has it a position?"

    def _command(self, command: int, *values: float) -> None:
        self._write("command_long", *self._target, command, 0, *values, *[0.0] * (7 - len(values)))

    def _write(self, kind: str, *values: Any) -> None:
        """Send a message, unless this end is mute."""
        if not self._mute or kind == "heartbeat":
            self._line.send(kind, *values)


def _called(target: tuple[int, int], sender: Sender) -> str:
    """A vehicle in words."""
    return f"system {target[0]}{'' if sender is None else f' at {sender[0]}:{sender[1]}'}"

"""Bridge: a program of its own between hotlap and cflib.

    python bridge.py URI

cflib is under the GPL, version 3. hotlap never imports it: this program does, which is hotlap's, under the MIT licence, and imports
nothing else of hotlap. Whoever installs cflib beside it combines the two, on that computer. Each way a line is a JSON list: a word and
its values. `vehicle` says what they mean to a flight; here they become packets, and packets become lines.

When its input ends without "close", hotlap has died or left: then a Crazyflie that was flown is told to land.
"""

from __future__ import annotations

import json
import logging
import os
import signal
import struct
import sys
import threading
import time
from contextlib import suppress
from typing import Any

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.mem import MemoryElement, Poly4D
from cflib.crtp.crtpstack import CRTPPacket, CRTPPort

STATE = tuple(f"stateEstimateZ.{name}" for name in ("x", "y", "z", "vx", "vy", "vz", "quat", "rateRoll", "ratePitch", "rateYaw"))
STATUS, BATTERY = "supervisor.info", "pm.vbat"  # with the state 24 bytes, of 26 that a packet has
FLYING = 0x10  # of the status
SLOW = 200  # ms between voltages
TRAJECTORY, PIECE = 1, 33  # its number; values of a piece: four polynomials of eight, and a duration
ECHO = struct.Struct("<Bd")  # what cflib's own questions about latency look like, with another first byte
OURS, ARMING = 1, 0x81
LANDING_SPEED, LEAST_LANDING, HOLDING = 0.5, 2.0, 2.0  # m/s, s, s
LINGER, BEAT = 20.0, 0.1  # s to land where hotlap has died, and between beats


class Bridge:
    """A connection to a Crazyflie, and what it has said last.

    Args:
        out: takes the lines.
    """

    def __init__(self, out: Any) -> None:
        self._out, self._lock, self._asked = out, threading.Lock(), 0.0
        self._pieces: list[Any] = []
        self._ground, self._height, self._status = 0.0, 0.0, 0
        self._flown = self._watched = False
        self._crazyflie = Crazyflie()
        self._crazyflie.connected.add_callback(self._connected)
        self._crazyflie.connection_failed.add_callback(lambda _, reason: self.say("failed", reason.splitlines()[0]))
        self._crazyflie.connection_lost.add_callback(lambda _, reason: self.say("lost", reason.splitlines()[0]))
        self._crazyflie.add_port_callback(CRTPPort.SUPERVISOR, self._supervisor_said)
        self._crazyflie.add_port_callback(CRTPPort.SETPOINT_HL, self._commander_said)
        self._crazyflie.add_header_callback(self._echoed, CRTPPort.LINKCTRL, 0)

    def say(self, *line: Any) -> None:
        """Write a line."""
        with self._lock, suppress(OSError):
            self._out.write(json.dumps(line) + "\n")
            self._out.flush()

    def open(self, uri: str) -> None:
        """Connect; "found" or "failed" is said later."""
        cflib.crtp.init_drivers()
        self._crazyflie.open_link(uri)

    def obey(self, word: str, *values: Any) -> None:
        """Do what a line says."""
        getattr(self, f"do_{word}")(*values)

    def do_listen(self, period: int) -> None:
        """Ask for states, every so many milliseconds, and voltages."""
        state, slow = LogConfig("state", period), LogConfig("battery", SLOW)
        for name in (*STATE, STATUS):
            state.add_variable(name)
        slow.add_variable(BATTERY)
        state.data_received_cb.add_callback(self._hear_state)
        slow.data_received_cb.add_callback(lambda _, data, __: self.say("battery", data[BATTERY]))
        for log in (state, slow):
            log.error_cb.add_callback(lambda _, reason: self.say("failed", f"it does not log: {reason}"))
            try:
                self._crazyflie.log.add_config(log)
                log.start()
            except (KeyError, AttributeError) as error:
                self.say("failed", f"it does not log: {error.args[0] if error.args else error}")
                return

    def do_ground(self, height: float) -> None:
        """Height [m] at which it stood."""
        self._ground = height

    def do_fly(self, *values: float) -> None:
        """A full state: position, velocity, acceleration, attitude (x, y, z, w), rates [rad/s].

        cflib's text says degrees; the packet holds thousandths of a radian.
        """
        self._flown = True
        commander = self._crazyflie.commander
        commander.send_full_state_setpoint(values[:3], values[3:6], values[6:9], values[9:13], *values[13:16])

    def do_arm(self, arm: bool) -> None:
        """Arm, or disarm."""
        self._crazyflie.supervisor.send_arming_request(arm)

    def do_land(self) -> None:
        """Land. The high-level commander is given its order before setpoints give way to it: until then it would stop the motors."""
        duration = max(LEAST_LANDING, (self._height - self._ground) / LANDING_SPEED)
        commander: Any = self._crazyflie.high_level_commander  # its types know no None, by which it keeps its heading
        commander.land(self._ground, duration, yaw=None)
        self._give_way()

    def do_hold(self) -> None:
        """Stay where it is."""
        self._crazyflie.high_level_commander.go_to(0.0, 0.0, 0.0, 0.0, HOLDING, relative=True)
        self._give_way()

    def do_stop(self) -> None:
        """Stop the motors, at once and until it is restarted."""
        self._crazyflie.supervisor.send_emergency_stop()
        self._flown = False

    def do_piece(self, *values: float) -> None:
        """A piece of a trajectory: coefficients of x, y, z and yaw, and its duration [s]."""
        parts = [Poly4D.Poly(list(values[start : start + 8])) for start in range(0, PIECE - 1, 8)]
        self._pieces.append(Poly4D(values[-1], *parts))

    def do_upload(self) -> None:
        """Upload all pieces."""
        memories = self._crazyflie.mem.get_mems(MemoryElement.TYPE_TRAJ)
        if not memories:
            self.say("uploaded", 0)
            return
        memories[0].trajectory = self._pieces
        memories[0].write_data(self._uploaded, lambda _, __: self.say("uploaded", 0))

    def do_start(self) -> None:
        """Fly the trajectory."""
        self._flown = True
        self._crazyflie.high_level_commander.start_trajectory(TRAJECTORY)
        self._crazyflie.commander.send_notify_setpoint_stop()

    def do_beat(self) -> None:
        """A beat of the watchdog: a second without one, and it stops its motors."""
        self._watched = True
        self._crazyflie.supervisor.send_emergency_stop_watchdog()

    def do_echo(self, stamp: float) -> None:
        """Ask for an echo."""
        packet = CRTPPacket()
        packet.set_header(CRTPPort.LINKCTRL, 0)
        packet.data = ECHO.pack(OURS, stamp)
        self._asked = time.monotonic()
        self._crazyflie.send_packet(packet)

    def do_close(self) -> None:
        """End, and send nothing more: cflib's own way to close sends a setpoint of no thrust, which would let it fall."""
        link, self._crazyflie.link = self._crazyflie.link, None
        if link is not None:
            link.close()
        os._exit(0)  # threads of cflib may wait

    def abandoned(self) -> None:
        """Land what hotlap has left in the air, and keep its watchdog content until it has landed."""
        if self._crazyflie.link is not None:
            if self._flown:
                self.do_land()
            end = time.monotonic() + LINGER
            while self._watched and self._status & FLYING and time.monotonic() < end:
                self.do_beat()
                time.sleep(BEAT)
            time.sleep(BEAT)  # what was sent last is on its way
        self.do_close()

    def _give_way(self) -> None:
        self._flown = False
        self._crazyflie.commander.send_notify_setpoint_stop()

    def _connected(self, _: str) -> None:
        self.say("found", self._crazyflie.platform.get_protocol_version())

    def _hear_state(self, stamp: int, data: dict[str, Any], _: Any) -> None:
        self._height, self._status = 1e-3 * data["stateEstimateZ.z"], data[STATUS]
        self.say("state", stamp, data[STATUS], *(data[name] for name in STATE))

    def _supervisor_said(self, packet: Any) -> None:
        if len(packet.data) > 1 and packet.data[0] == ARMING:
            self.say("armed", bool(packet.data[1]))

    def _commander_said(self, packet: Any) -> None:
        if len(packet.data) > 3:
            self.say("answer", packet.data[0], packet.data[3])

    def _uploaded(self, _: Any, __: int) -> None:
        self._crazyflie.high_level_commander.define_trajectory(TRAJECTORY, 0, len(self._pieces))
        self.say("uploaded", len(self._pieces))

    def _echoed(self, packet: Any) -> None:
        if len(packet.data) == ECHO.size and packet.data[0] == OURS:
            self.say("echo", time.monotonic() - self._asked)


def main() -> None:
    """Serve lines until there are no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is hotlap's business
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what cflib prints is no line of ours
    logging.disable()
    bridge = Bridge(out)
    bridge.open(sys.argv[1])
    for line in sys.stdin:
        bridge.obey(*json.loads(line))
    bridge.abandoned()


if __name__ == "__main__":
    main()

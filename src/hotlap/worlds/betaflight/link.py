"""Link: a firmware of our own, in a process of its own, that runs as far as it is told, and the packets to and from it.

It listens on no port: packets go over a pair of sockets that nobody else can reach, and the firmware ends when they close.
"""

from __future__ import annotations

import array
import os
import signal
import socket
import struct
import subprocess
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hotlap.system.text_files import cause_of
from hotlap.worlds.betaflight import built
from hotlap.worlds.simulator import SimulatorError

Floats = NDArray[np.float64]

ORDER: Final = np.dtype(
    [
        ("kind", "<u8"),
        ("until", "<u8"),
        ("sent", "<f8"),
        ("sticks", "<u2", (16,)),
        ("time", "<f8"),
        ("gyro", "<f8", (3,)),
        ("force", "<f8", (3,)),
        ("attitude", "<f8", (4,)),
        ("elsewhere", "<f8", (6,)),
        ("pressure", "<f8"),
    ]
)
REPLY: Final = struct.Struct("<4Q4f")
RUN, COPY, READY = 1, 2, 3
BOOT = 1_000_000_000  # ns that the firmware runs before its first packet
PAUSE = 10_000  # ns between two looks of its scheduler
EEPROM = "eeprom.bin"  # what the firmware calls it
PATIENCE = 10.0  # s until a firmware that does not answer is given up
TO_FRD = np.array([1.0, -1.0, -1.0])


@dataclass(frozen=True)
class Answer:
    """What the firmware says when it stands still.

    Attributes:
        now: [ns] its time.
        process: its number.
        updates: how often it has written to its motors since the last answer.
        motors: shape (4,) [-] last outputs, 0 to 1, in its own order.
    """

    now: int
    process: int
    updates: int
    motors: Floats


class Link:
    """A firmware that stands still until it is told to run.

    Args:
        ends: our end of the socket pair.
        child: the process, unless it is a copy.
        patience: [s] for every answer.

    Attributes:
        answer: its last.
    """

    def __init__(self, ends: socket.socket, child: subprocess.Popen[bytes] | None, patience: float = PATIENCE) -> None:
        self._socket, self._child, self._patience = ends, child, patience
        self._socket.settimeout(patience)
        self._order = np.zeros(1, dtype=ORDER)
        self._order["attitude"], self._order["pressure"], self._order["time"] = (1.0, 0.0, 0.0, 0.0), 101325.0, 1.0
        self._fields = {name: self._order[name][0] for name in ("sticks", "gyro", "force", "attitude")}
        self._handle: int | None = None
        try:
            self.answer = self._receive()
        except SimulatorError:
            self.close()
            raise
        if child is None:
            with suppress(OSError):  # a system without handles of processes
                self._handle = os.pidfd_open(self.answer.process)

    @classmethod
    def start(cls, eeprom: bytes, *, program: Path | None = None, patience: float = PATIENCE) -> Link:
        """Start a firmware and let it boot.

        Args:
            eeprom: its configuration.
            program: another program than the firmware.
            patience: [s] for every answer.

        Raises:
            SimulatorError: it does not start.
        """
        with tempfile.TemporaryDirectory(prefix="hotlap-betaflight-") as folder:
            Path(folder, EEPROM).write_bytes(eeprom)
            ours, child = launch(Path(folder), {"LOCKSTEP_BOOT": BOOT}, program=program)
            return cls(ours, child, patience)

    def run(self, until: int, sticks: list[int] | NDArray[np.integer], rates: Floats, force: Floats, attitude: Floats) -> Answer:
        """Let it run from here to a time, with the state that its sensors feel now.

        Args:
            until: [ns] of its clock.
            sticks: shape (16,): channels [us].
            rates: shape (3,) [rad/s] (body).
            force: shape (3,) [m/s^2] (body) specific force.
            attitude: shape (4,).

        Raises:
            SimulatorError: it is silent, has ended, or answers what makes no sense.
        """
        fields = self._fields
        self._order["kind"], self._order["until"] = RUN, until
        fields["sticks"][:], fields["gyro"][:], fields["force"][:], fields["attitude"][:] = sticks, rates * TO_FRD, -force, attitude
        self._send()
        answer = self._receive()
        if not until <= answer.now < until + 10 * BOOT:
            raise SimulatorError(f"Betaflight's clock says {1e-9 * answer.now:g} s, not {1e-9 * until:g} s")
        return answer

    def copy(self) -> Link:
        """Another firmware in the very state of this one, which stays as it is.

        Raises:
            SimulatorError: it cannot be copied.
        """
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            self._order["kind"] = COPY
            self._send(theirs.fileno())
        except SimulatorError:
            ours.close()
            raise
        finally:
            theirs.close()
        return Link(ours, None, self._patience)

    def close(self) -> None:
        """End it; may be called twice."""
        self._socket.close()
        if self._child is not None:
            self._child.kill()
            self._child.wait()
        if self._handle is not None:
            with suppress(OSError):
                signal.pidfd_send_signal(self._handle, signal.SIGKILL)  # one that is stopped would not see that nobody is there
            os.close(self._handle)
            self._handle = None

    def _send(self, descriptor: int | None = None) -> None:
        """Send the order, with a descriptor."""
        try:
            if descriptor is None:
                self._socket.send(self._order.data)
            else:
                self._socket.sendmsg([self._order.data], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", [descriptor]))])
        except TimeoutError:
            raise self._silent() from None
        except OSError as error:
            raise self._lost(error) from None

    def _receive(self) -> Answer:
        """Wait for its answer."""
        try:
            data = self._socket.recv(REPLY.size + 1)
        except TimeoutError:
            raise self._silent() from None
        except OSError as error:
            raise self._lost(error) from None
        if not data:
            raise self._lost(None)
        if len(data) != REPLY.size or (values := REPLY.unpack(data))[0] != READY:
            raise SimulatorError("Betaflight answers what nobody understands")
        motors = np.array(values[4:])
        if not (np.isfinite(motors).all() and np.abs(motors).max() <= 2):
            raise SimulatorError(f"Betaflight sends {motors.tolist()} to its motors")
        return Answer(values[1], values[2], values[3], motors)

    def _silent(self) -> SimulatorError:
        """It has not answered in time."""
        return SimulatorError(f"Betaflight has not answered for {self._patience:g} s")

    def _lost(self, error: OSError | None) -> SimulatorError:
        """It has ended."""
        code = None
        if self._child is not None:
            with suppress(subprocess.TimeoutExpired):
                code = self._child.wait(1.0)
        how = f" with exit status {code}" if code is not None and code >= 0 else f" by signal {-code}" if code is not None else ""
        why = f" ({cause_of(error)})" if error is not None and not how else ""
        return SimulatorError(f"Betaflight has ended{how}{why}")


def launch(
    folder: Path, settings: dict[str, int], *, hand: tuple[int, ...] = (), program: Path | None = None
) -> tuple[socket.socket, subprocess.Popen[bytes]]:
    """Start a firmware under the shim.

    Args:
        folder: where it works; needs to be there only until it has booted.
        settings: variables of its environment.
        hand: descriptors that it inherits.
        program: another program than the firmware.

    Returns:
        Our end of its socket, and the process.

    Raises:
        SimulatorError: it cannot be started.
    """
    path, library = program or built.firmware(), built.shim()
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    variables = {"LOCKSTEP_ORDERS": theirs.fileno(), "LOCKSTEP_PAUSE": PAUSE, **settings}
    environment = os.environ | {"LD_PRELOAD": str(library)} | {name: str(value) for name, value in variables.items()}
    try:
        child = subprocess.Popen(
            [path, "127.0.0.1"],
            cwd=folder,
            env=environment,
            pass_fds=(theirs.fileno(), *hand),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            process_group=0,  # who interrupts hotlap lets it end its flights
        )
    except OSError as error:
        ours.close()
        raise SimulatorError(f"{path} cannot be started: {cause_of(error)}") from None
    finally:
        theirs.close()
    return ours, child

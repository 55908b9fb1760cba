"""Console: the firmware's command line, for configuring it; what it keeps in its EEPROM is kept here, for the next time."""

from __future__ import annotations

import hashlib
import re
import socket
import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from time import monotonic

from hotlap.core.errors import InputError
from hotlap.core.printable import printable
from hotlap.system import sealed
from hotlap.worlds.betaflight import built
from hotlap.worlds.betaflight.link import EEPROM, PATIENCE, launch
from hotlap.worlds.betaflight.settings import DEVICES, Line
from hotlap.worlds.simulator import SimulatorError

PROMPT = b"\r\n# "
KNOCK = 0.2  # s between two attempts to be let in
MOST_NAMED = 8  # lines, of those that are refused
ERROR_IN = re.compile(r"^ERROR IN \w+: ")
REFUSALS = ("###ERROR", "INVALID NAME", "INVALID VALUE", "UNKNOWN COMMAND", "PARSE ERROR")


@dataclass(frozen=True)
class Refusal:
    """A line that the firmware does not take.

    Attributes:
        line: which.
        answer: what it says instead.
    """

    line: Line
    answer: str


def configured(lines: Sequence[Line], patience: float = PATIENCE) -> bytes:
    """The EEPROM of a firmware that was told all lines; made once for each firmware and each set of lines.

    Args:
        lines: what it is told, in order.
        patience: [s] for every answer.

    Raises:
        InputError: it refuses a line of the user's file.
        SimulatorError: it refuses one of ours, is silent, or has ended.
    """
    texts = "\n".join(line.text for line in lines)
    mark = hashlib.sha256(f"{_fingerprint(built.firmware())}\n{texts}".encode()).hexdigest()[:24]
    kept = built.private_folder() / f"{mark}.bin"
    known = sealed.read(kept)
    if known is not None:
        return known
    eeprom, refusals = configure(lines, patience)
    _complain(refusals)
    sealed.write(kept, eeprom)
    return eeprom


def configure(lines: Sequence[Line], patience: float = PATIENCE) -> tuple[bytes, list[Refusal]]:
    """Tell a fresh firmware all lines and let it save them.

    Returns:
        Its EEPROM, and the lines that it did not take.

    Raises:
        SimulatorError: it is silent, or has ended.
    """
    console, theirs = socket.socketpair()
    with tempfile.TemporaryDirectory(prefix="hotlap-betaflight-") as folder:
        try:
            orders, child = launch(Path(folder), {"LOCKSTEP_CONSOLE": theirs.fileno()}, hand=(theirs.fileno(),))
        finally:
            theirs.close()
        try:
            with console, orders:
                _enter(console, patience)
                console.settimeout(patience)
                refusals = [refusal for line in lines if (refusal := _tell(console, line))]
                _save(console, child, patience)
            return Path(folder, EEPROM).read_bytes(), refusals
        except TimeoutError:
            raise SimulatorError(f"Betaflight's command line has not answered for {patience:g} s") from None
        except OSError as error:
            raise SimulatorError(f"Betaflight ended while it was configured ({error})") from None
        finally:
            child.kill()
            child.wait()


def _enter(console: socket.socket, patience: float) -> None:
    """Enter the command line; a firmware that is still booting does not listen."""
    deadline = monotonic() + patience
    console.settimeout(KNOCK)
    while monotonic() < deadline:
        console.sendall(b"#")
        with suppress(TimeoutError):
            _read(console)
            return
    raise TimeoutError


def _tell(console: socket.socket, line: Line) -> Refusal | None:
    """Type a line, and read what comes back."""
    console.sendall(line.text.encode() + b"\n")
    answer = _read(console)
    said = [" ".join(part.strip("# \r").split()) for part in answer.split("\n")]
    refused = [part for part in said if any(word.strip("#") in part.upper() for word in REFUSALS)]
    return Refusal(line, ERROR_IN.sub("", refused[0])) if refused else None


def _save(console: socket.socket, child: subprocess.Popen[bytes], patience: float) -> None:
    """Let it save and end."""
    console.sendall(b"save\n")
    try:
        child.wait(patience)
    except subprocess.TimeoutExpired:
        raise TimeoutError from None


def _read(console: socket.socket) -> str:
    """What it says up to its next prompt."""
    got = b""
    while not got.endswith(PROMPT):
        piece = console.recv(4096)
        if not piece:
            raise ConnectionResetError("it closed its command line")
        got += piece
    return got.decode(errors="replace")


def _complain(refusals: Sequence[Refusal]) -> None:
    """Refuse what the firmware refuses, unless it is about devices that it does not have."""
    told = [refusal for refusal in refusals if not (refusal.line.source and DEVICES.match(refusal.line.text))]
    if not told:
        return
    first, rest = told[0], [str(refusal.line.number) for refusal in told[1:] if refusal.line.source]
    more = f"; also line{'s' * (len(rest) > 1)} {', '.join(rest[:MOST_NAMED])}{' and more' * (len(rest) > MOST_NAMED)}" if rest else ""
    reason = printable(f"Betaflight refuses '{first.line.text}': {first.answer}")
    if first.line.source:
        raise InputError(first.line.source, f"line {first.line.number}", reason + more)
    raise SimulatorError(reason)


@cache
def _fingerprint(path: Path) -> str:
    """Of a firmware."""
    return hashlib.sha256(path.read_bytes()).hexdigest()

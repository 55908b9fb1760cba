"""Logs: what reads the flights of other programs, with the samples of the tests of `hotlap.logs`."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from fuzz.readers import Reader
from hotlap.core.errors import InputError
from hotlap.identification.evidence import lay_out
from hotlap.logs.hotlap_csv import write_hotlap_csv
from hotlap.logs.readers import read
from logs.ros_written import write_bag1, write_mcap
from logs.written import Flown, make_flight, write_blackbox, write_csv, write_dataflash, write_dataflash_text, write_ulog

LENGTH = 60  # samples of a flight
MAP = {"time": "stamp", "position": "X Y Z", "rates": "gx gy gz", "acceleration": "ax ay az"}


def _sample(write: Callable[[Path, Flown], Any], ending: str) -> Callable[[], Sequence[bytes]]:
    """What a writer of the tests makes of a short flight."""

    def make() -> Sequence[bytes]:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"sample{ending}"
            write(path, make_flight(LENGTH))
            return [path.read_bytes()]

    return cache(make)


@cache
def _own() -> Sequence[bytes]:
    """A log of hotlap's own, of all that a ULog tells."""
    with tempfile.TemporaryDirectory() as folder:
        log = read(write_ulog(Path(folder) / "a.ulg", make_flight(LENGTH)))
        write_hotlap_csv(Path(folder) / "a.csv", log)
        return [(Path(folder) / "a.csv").read_bytes()]


def _use(path: Path, mapping: dict[str, str] | None = None) -> Any:
    """Read a log, and look at it as `hotlap identify` and `hotlap score` do."""
    log = read(path, mapping)
    seen = [(signal.rate, signal.gaps(), signal.at(signal.times)) for signal in log.signals.values()]
    try:
        return seen, log.notes, lay_out(log)
    except InputError:  # it need not be enough for a fit
        return seen, log.notes


LOGS: dict[str, Reader] = {
    reader.name: reader
    for reader in (
        Reader("log, CSV", ".csv", _sample(write_csv, ".csv"), lambda path: _use(path, MAP)),
        Reader("log, own CSV", ".csv", _own, _use),
        Reader("log, ULog", ".ulg", _sample(write_ulog, ".ulg"), _use),
        Reader("log, dataflash", ".bin", _sample(write_dataflash, ".bin"), _use),
        Reader("log, dataflash text", ".log", _sample(write_dataflash_text, ".log"), _use),
        Reader("log, MCAP", ".mcap", _sample(write_mcap, ".mcap"), _use),
        Reader("log, ROS bag", ".bag", _sample(write_bag1, ".bag"), _use),
        Reader("log, blackbox", ".bbl", _sample(write_blackbox, ".bbl"), _use),
    )
}

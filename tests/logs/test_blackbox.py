"""Blackbox: what its program says where it fails, and frames that are cut short."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.core.errors import InputError
from hotlap.logs.readers import read
from logs.written import make_flight, write_blackbox

FLIGHT = make_flight(60)


@pytest.fixture
def decoded(tmp_path, monkeypatch):
    """A log that a program of ours decodes, in place of orangebox's."""

    def make(program: str):
        (tmp_path / "program.py").write_text(program)
        monkeypatch.setattr("hotlap.logs.blackbox._program", lambda _: tmp_path / "program.py")
        return write_blackbox(tmp_path / "a.bbl", FLIGHT)

    return make


def frames(*rows: str) -> str:
    """A program that prints some frames, and ends well."""
    lines = ["time,gyroADC[0],gyroADC[1],gyroADC[2],flags", *(f"{1000 * k},0,0,0,ARM" for k in range(20)), *rows]
    return f"print({chr(10).join(lines)!r})"


@pytest.mark.parametrize("program", ["import nothing_of_that_name", "print('no such header')\nraise SystemExit(1)"])
def test_what_a_program_that_fails_has_said_is_told(decoded, program):
    said = "ModuleNotFoundError: No module named 'nothing_of_that_name'" if "import" in program else "no such header"
    with pytest.raises(InputError, match=rf"with 0 frames: it is cut short, or holds no flight \(bb2csv said: {said}\)"):
        read(decoded(program))


def test_a_program_that_fails_behind_a_flight_is_noted(decoded):
    log = read(decoded(frames() + "\nraise SystemError('what now')"))
    assert len(log.signals["rates"].times) == 20
    assert "the log has no end: it may be cut short (bb2csv said: SystemError: what now)" in log.notes


def test_a_short_frame_in_the_middle_is_left_out_and_takes_no_column_along(decoded):
    log = read(decoded(frames("20000,0", "21000,0,0,0,ARM")))
    assert len(log.signals["rates"].times) == 21
    assert "1 frames have fewer than 5 fields and were left out" in log.notes


def test_a_short_frame_at_the_end_is_left_out(decoded):
    log = read(decoded(frames("20000,0")))
    assert len(log.signals["rates"].times) == 20
    assert "the last frame is cut short and was left out" in log.notes


def test_a_program_that_never_ends_is_stopped(decoded, monkeypatch):
    monkeypatch.setattr("hotlap.logs.blackbox.PATIENCE", 0.5)
    with pytest.raises(InputError, match=r"takes more than 0.5 s to decode"):
        read(decoded("import time\nwhile True: time.sleep(1)"))


@pytest.mark.parametrize("finer", [False, True])
def test_throttle_of_the_sticks_is_read_in_either_resolution(tmp_path, finer):
    log = read(write_blackbox(tmp_path / "a.bbl", FLIGHT, finer=finer, leave_out=("setpoint[3]",)))
    np.testing.assert_allclose(log.signals["thrust_command"].values[:, 0], FLIGHT.thrust, atol=1e-3)

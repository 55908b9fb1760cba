"""hotlap's own logs: what is written is read again, and what is wrong is told in one line."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.core.errors import InputError
from hotlap.core.records import columns_of
from hotlap.logs.flight_log import FlightLog, Signal
from hotlap.logs.hotlap_csv import FULL_THRUST, is_hotlap_csv, read_hotlap_csv, write_hotlap_csv

HEADER = "t,w_x,w_y,w_z,command_w_x,command_w_y,command_w_z,command_thrust"
ROWS = ["0,0,0,0,0,0,0,9.81", "0.01,0,0,0,0,0,0,9.81"]


def a_log() -> FlightLog:
    times, random = 0.01 * np.arange(50), np.random.default_rng(1)
    widths = {"position": 3, "velocity": 3, "attitude": 4, "rates": 3, "rate_command": 3}
    signals = {name: Signal(times, random.normal(size=(50, width))) for name, width in widths.items()}
    signals["thrust_command"] = Signal(times, np.linspace(0.2, 1.0, 50)[:, None])
    return FlightLog("a", "made up", signals, {FULL_THRUST: 30.0})


def test_a_log_that_is_written_is_read_again(tmp_path):
    log, path = a_log(), tmp_path / "flight.csv"
    write_hotlap_csv(path, log)
    read = read_hotlap_csv(path)
    assert path.read_text().splitlines()[0] == ",".join(columns_of(4))
    assert set(read.signals) == set(log.signals)
    for name, signal in log.signals.items():
        np.testing.assert_allclose(read.signals[name].values, signal.values, rtol=1e-12)
        np.testing.assert_array_equal(read.signals[name].times, signal.times)
    assert read.facts[FULL_THRUST] == pytest.approx(30.0)


def test_the_thrust_command_is_a_share_of_the_largest(tmp_path):
    path = tmp_path / "flight.csv"
    path.write_text("\n".join([HEADER, *ROWS, "0.02,0,0,0,0,0,0,19.62"]))
    read = read_hotlap_csv(path)
    np.testing.assert_allclose(read.signals["thrust_command"].values[:, 0], [0.5, 0.5, 1.0])
    assert read.facts[FULL_THRUST] == 19.62
    assert read.notes == ("thrust command 1 is 19.62 m/s^2, the largest in the log",)


def test_its_header_is_known():
    assert is_hotlap_csv(",".join(columns_of(6)))
    assert not is_hotlap_csv("time,ax,ay,az")


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], "is empty: a header and rows of numbers are needed"),
        (["t,w_x", "0,0"], "w_y: this column is missing; a log of hotlap has t, w_x"),
        ([HEADER, *ROWS, "0.02,0,0"], "row 4: has 3 values, the header has 8: is the file cut off?"),
        ([HEADER, *ROWS, "0.02,0,0,up,0,0,0,9"], "row 4: 'up' is no number"),
        ([HEADER, *ROWS[::-1]], "t: must increase from row to row, over two rows or more"),
        ([HEADER, *ROWS, "0.02,0,nan,0,0,0,0,9.81"], "rates: is not finite in row 4"),
        ([HEADER + ",v_x", "0,0,0,0,0,0,0,9,1", "1,0,0,0,0,0,0,9,1"], "v_y: this column is missing, others of its kind are not"),
        ([HEADER, "0,0,0,0,0,0,0,0", "1,0,0,0,0,0,0,0"], "command_thrust: is never above 0"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(tmp_path, lines, message):
    path = tmp_path / "flight.csv"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError) as caught:
        read_hotlap_csv(path)
    assert str(caught.value).startswith(f"{path}: {message}")
    assert "\n" not in str(caught.value)


def test_a_file_that_is_none_is_told_in_one_line(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        read_hotlap_csv(tmp_path / "nowhere.csv")
    (tmp_path / "image.csv").write_bytes(b"\xff\xfe\x00\x01" * 9)
    with pytest.raises(InputError, match=r"cannot be read as text: it is no UTF-8"):
        read_hotlap_csv(tmp_path / "image.csv")

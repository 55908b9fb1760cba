"""Malformed logs: each is told of in one line that names the file, and nothing hangs."""

from __future__ import annotations

import os
import struct
import tracemalloc

import numpy as np
import pytest

from hotlap.core.errors import InputError
from hotlap.logs.blackbox import FIRST
from hotlap.logs.hotlap_csv import NEEDED
from hotlap.logs.readers import MOST_BYTES, MOST_OF_TEXT, need, read
from logs.ros_written import write_bag1, write_bag2, write_mcap
from logs.written import make_flight, write_blackbox, write_csv, write_dataflash, write_ulog

FLIGHT = make_flight(60)


def _cut(path, share=0.5, least=0):
    path.write_bytes(path.read_bytes()[: max(least, int(path.stat().st_size * share))])
    return path


def _text(path, text):
    path.write_text(text)
    return path


def _bytes(path, content):
    path.write_bytes(content)
    return path


def _huge(path):
    with path.open("wb") as file:
        file.write(b"ULog\x01\x12\x35\x01")
        file.truncate(MOST_BYTES + 1)  # a hole: it takes no room
    return path


def _fifo(path):
    os.mkfifo(path)
    return path


def _numbers(path, heads, row, rows=20):
    lines = [",".join(map(str, [k * 0.01, *row])) for k in range(rows)]
    return _text(path, "\n".join([heads, *lines]) + "\n")


_FMT = struct.pack("<3sBB4s16s64s", b"\xa3\x95\x80", 128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns")
_EMPTY = _FMT + struct.pack("<3sBB4s16s64s", b"\xa3\x95\x80", 200, 0, b"NONE", b"", b"") + b"\xa3\x95\xc8"

MALFORMED = {
    "cut ulog": (lambda d: _cut(write_ulog(d / "a.ulg", FLIGHT), 0, 12), "ends within its first 16 bytes"),
    "ulog without data": (lambda d: _cut(write_ulog(d / "a.ulg", FLIGHT), 0, 40), "a ULog of PX4( without any signal|: it is cut short)"),
    "ulog that ends in a message": (
        lambda d: _bytes(d / "a.ulg", b"ULog\x01\x12\x35\x01" + bytes(8) + struct.pack("<HB", 6, 0) + bytes(5)),
        "a ULog of PX4 whose messages lead back again and again: it is damaged",
    ),
    "wrong version": (lambda d: write_ulog(d / "a.ulg", FLIGHT, version=9), "ULog of version 9; hotlap reads versions 0 and 1"),
    "one axis missing": (lambda d: write_ulog(d / "a.ulg", FLIGHT, leave_out=("pitch",)), "vehicle_rates_setpoint: has no pitch"),
    "wrong units": (lambda d: write_ulog(d / "a.ulg", FLIGHT, scale=57.3), r"rates: is up to 63.2 rad/s: is it in deg/s\?"),
    "blackbox, cut": (lambda d: _cut(write_blackbox(d / "a.bbl", FLIGHT), 0, 900), r"with \d frames: it is cut short"),
    "blackbox, cut in its head": (lambda d: _cut(write_blackbox(d / "a.bbl", FLIGHT), 0, 100), "a blackbox of Betaflight"),
    "blackbox, one axis": (lambda d: write_blackbox(d / "a.bbl", FLIGHT, leave_out=("gyroADC[2]",)), r"has no gyroADC\[2\]"),
    "dataflash, no length": (
        lambda d: _bytes(write_dataflash(d / "a.bin", FLIGHT), _EMPTY + (d / "a.bin").read_bytes()),
        "with a message NONE of no length at byte 178: it is damaged",
    ),
    "dataflash, cut": (lambda d: _cut(write_dataflash(d / "a.bin", FLIGHT), 0, 60), "a dataflash log of ArduPilot"),
    "mcap, cut": (lambda d: _cut(write_mcap(d / "a.mcap", FLIGHT), 0, 60), "an MCAP file"),
    "bag, cut": (lambda d: _cut(write_bag1(d / "a.bag", FLIGHT)), "a ROS bag: it is cut short or damaged"),
    "bag of ros 2, its data gone": (lambda d: _without_data(write_bag2(d / "bag", FLIGHT)), "a ROS bag"),
    "empty": (lambda d: _bytes(d / "a.ulg", b""), "is empty"),
    "text, no log": (lambda d: _text(d / "a.ulg", "hello\n" * 9), "does not begin like a ULog of PX4"),
    "noise": (lambda d: _bytes(d / "a.dat", np.random.default_rng(0).bytes(5000)), "is no log that hotlap knows: PX4 ULog"),
    "a race": (lambda d: _text(d / "a.toml", 'name = "race"\n'), "is no log that hotlap knows"),
    "fifo": (lambda d: _fifo(d / "a.csv"), "is not a file that can be read"),
    "device": (lambda d: "/dev/zero", "is not a file that can be read"),
    "folder": (lambda d: d, "is a folder, and no ROS 2 bag"),
    "nothing": (lambda d: d / "none.ulg", "there is no such file"),
    "huge": (lambda d: _huge(d / "a.ulg"), "is larger than 2000 MB"),
    "csv, NaN alone": (lambda d: _numbers(d / "a.csv", "t,px,py,pz", ["nan"] * 3), "position: has no finite value in 20 samples"),
    "csv, one axis missing": (lambda d: _numbers(d / "a.csv", "t,px,py", [1, 2]), "position: has no column pz"),
    "csv, times in us": (lambda d: write_csv(d / "a.csv", make_flight(), seconds=1e-9), "are the times in seconds"),
    "csv, in g": (lambda d: _numbers(d / "a.csv", "t,ax,ay,az", [0, 0, 1.0]), r"acceleration: is 1 m/s\^2 most of the time.*in g"),
    "csv, a word": (lambda d: _numbers(d / "a.csv", "t,px,py,pz", [1, "two", 3]), "line 2, py: must be a number, not 'two'"),
    "csv, ragged": (lambda d: _text(d / "a.csv", "t,px,py,pz\n0,1,2,3\n1,2\n2,1,2,3\n"), "line 3: has 2 cells, and the head 4"),
    "csv, back in time": (lambda d: _text(d / "a.csv", "t,px,py,pz\n" + "3,1,2,3\n1,1,2,3\n" * 9), "times go back 9 times"),
    "csv, no head": (lambda d: _numbers(d / "a.csv", "0,1,2,3", [1, 2, 3]), "its first line must name the columns"),
    "csv, no flight": (lambda d: _text(d / "a.csv", "t,px,py,pz\n"), "has 0 rows below its head"),
    "csv, unknown names": (lambda d: _numbers(d / "a.csv", "stamp,one,two", [1, 2]), "has no column of times"),
    "csv, crooked attitude": (lambda d: _numbers(d / "a.csv", "t,qw,qx,qy,qz", [1, 1, 1, 1]), "quaternions of length 2, not 1"),
}


def _without_data(folder):
    for file in folder.iterdir():
        if file.suffix != ".yaml":
            file.write_bytes(b"")
    return folder


@pytest.mark.parametrize("case", MALFORMED)
def test_a_malformed_log_is_one_line(case, tmp_path, capfd):
    make, reason = MALFORMED[case]
    path = make(tmp_path)
    keys = {"time": "stamp", "position": "X Y Z"} if case == "csv, times in us" else None
    with pytest.raises(InputError, match=reason) as caught:
        read(path, keys)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("name", "head"), [("a.csv", b"t,px,py,pz\n"), ("b.csv", ",".join(NEEDED).encode() + b"\n"), ("c.log", b"FMT, 1"), ("d.bbl", FIRST)]
)
def test_text_is_refused_earlier(tmp_path, name, head):
    with (tmp_path / name).open("wb") as file:
        file.write(head)
        file.truncate(MOST_OF_TEXT + 1)
    with pytest.raises(InputError, match="is larger than 200 MB: cut out the flight"):
        read(tmp_path / name)


def test_a_table_takes_little_more_memory_than_its_numbers(tmp_path):
    rows = "".join(f"{k / 100!r},{k % 7 / 7!r},{k % 11 / 11!r},{k % 13 / 13!r},{'x' * 40}\n" for k in range(20_000))
    for heads in ("t,px,py,pz,remark\n", f"{','.join(NEEDED)}\n"):
        text = rows if "px" in heads else rows.replace("x" * 40, "1,2,3")
        (tmp_path / "a.csv").write_text(heads + text)
        tracemalloc.start()
        read(tmp_path / "a.csv")
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert most < 4 * len(text)


def test_a_log_without_imu_says_what_it_has(tmp_path):
    path = write_ulog(tmp_path / "a.ulg", FLIGHT, leave_out=("vehicle_angular_velocity", "sensor_combined"))
    with pytest.raises(InputError, match="has no rates, acceleration, which a fit needs; it is a ULog of PX4 with position"):
        need(read(path), ("rates", "acceleration"), "a fit")


@pytest.mark.parametrize("write", [write_ulog, write_blackbox, write_dataflash, write_mcap, write_bag1])
def test_a_log_that_is_damaged_anywhere_is_read_or_told_of(write, tmp_path):
    suffix = {write_ulog: "ulg", write_blackbox: "bbl", write_dataflash: "bin", write_mcap: "mcap", write_bag1: "bag"}[write]
    whole, random = write(tmp_path / f"whole.{suffix}", FLIGHT).read_bytes(), np.random.default_rng(1)
    for trial in range(12):
        content = bytearray(whole)
        for place in random.integers(16, len(content), 20):
            content[place] = random.integers(256)
        path = _bytes(tmp_path / f"{trial}.{suffix}", bytes(content[: random.integers(16, len(content))]))
        told = ""
        try:
            assert read(path).signals
        except InputError as error:
            told = str(error)
        assert "\n" not in told

"""Damaged studies, odd files and odd names: one line, exit 2, and nothing that hangs."""

from __future__ import annotations

import errno
import os
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from hotlap.core.errors import StudyError
from hotlap.study.database import FILE
from hotlap.study.snapshot import read_snapshot
from hotlap.study.study import Study

pytestmark = pytest.mark.usefixtures("faked")
TUNE = ("tune", "straight.toml", "--seed", "1", "--budget", "12", "--validation", "5", "--first-guess", "default")
COMMANDS = (
    ("report", "mine"),
    ("export", "mine", "--format", "csv"),
    ("watch", "mine", "--port", "0"),
    (*TUNE, "--out", "mine"),
    ("transfer", "mine", "--to", "rotorpy"),
)


def flip(folder: Path, place: bytes, further: int) -> None:
    """One bit of the file, so far behind the first occurrence of some bytes."""
    content = bytearray((folder / FILE).read_bytes())
    content[content.index(place) + further] ^= 4
    (folder / FILE).write_bytes(content)


def change(folder: Path, statement: str) -> None:
    with closing(sqlite3.connect(folder / FILE)) as connection:
        connection.execute(statement)
        connection.commit()


HARMS = {
    "a bit of the reference": lambda folder: flip(folder, b"PK\x03\x04", 60),
    "a digit of the configuration": lambda folder: flip(folder, b'"budget": 12', 10),
    "a state that was cut": lambda folder: change(folder, "UPDATE increment SET change = substr(change, 1, 100) WHERE rowid = 1"),
    "a state that is gone": lambda folder: change(folder, "DELETE FROM increment WHERE rowid = 1"),
    "a wrong type": lambda folder: change(folder, "UPDATE entry SET value = 7 WHERE key = 'configuration'"),
    "a cost": lambda folder: change(folder, "UPDATE flight SET cost = cost + 1 WHERE number = 0"),
    "a table too many": lambda folder: change(folder, "CREATE TABLE more (x)"),
    "a view in place of a table": lambda folder: change(folder, "CREATE VIEW v AS SELECT 1"),
}


@pytest.mark.parametrize("harm", HARMS)
def test_a_damaged_study_is_one_line_for_every_command(hotlap, here, harm):
    hotlap(*TUNE, "--out", "mine")
    HARMS[harm](here / "mine")
    for command in COMMANDS:
        if command[0] in {"watch", "transfer", "export"} and harm in {"a cost", "a state that was cut", "a state that is gone"}:
            continue  # they begin without flights and state; watch says it to the browser
        ran = hotlap(*command)
        line = ran.err.splitlines()[-1]
        assert (ran.code, line.startswith("hotlap: mine: study.sqlite is damaged: ")) == (2, True), (command, ran)
        assert line.endswith("; what it had found is in parameters.toml and report.html beside it")
    with pytest.raises(StudyError, match=r"study.sqlite is damaged"):
        read_snapshot(Study("mine"))


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir], ids=["a pipe", "a folder"])
def test_what_is_no_file_is_no_study(hotlap, here, make):
    (here / "mine").mkdir()
    make(here / "mine" / FILE)
    for command in COMMANDS:
        ran = hotlap(*command)
        assert ran.code == 2
        assert ran.err.splitlines()[-1].startswith("hotlap: mine: study.sqlite is damaged: it is a "), (command, ran.err)


@pytest.mark.parametrize(
    ("command", "ending"),
    [
        (("check", "ODD"), ""),
        (("check", "straight.toml", "--reference", "ODD"), ""),
        (("fly", "straight.toml", "--parameters", "ODD"), ""),
        ((*TUNE[:-1], "ODD"), ".json"),
        ((*TUNE[:-1], "ODD"), ".toml"),
        (("import", "ODD"), ""),
    ],
)
def test_files_of_users_are_files(hotlap, here, command, ending):
    os.mkfifo(here / f"pipe{ending}")
    (here / f"endless{ending}").symlink_to("/dev/zero")
    for name, said in ((f"pipe{ending}", "is a pipe, not a file"), (f"endless{ending}", "is a device, not a file")):
        ran = hotlap(*(name if word == "ODD" else word for word in command))
        assert ran.code == 2
        assert f"{name}: {said}" in ran.err.splitlines()[-1]


@pytest.mark.parametrize("name", ["two\nlines", "a b", "ü\u202e", os.fsdecode(b"a\xff b"), "x" * 255])
def test_a_study_may_be_called_whatever_a_folder_may(hotlap, here, name):
    ran = hotlap(*TUNE, "--out", name)
    assert (ran.code, "Traceback" in ran.err) == (0, False), ran
    assert sorted(path.name for path in (here / name).iterdir()) == ["parameters.toml", "report.html", "study.lock", "study.sqlite"]
    assert hotlap("report", name).code == 0
    assert hotlap("fly", "straight.toml", "--parameters", name, "--flights", "2").code == 0


def test_a_path_that_is_too_long_leaves_nothing_behind(hotlap, here):
    long = "/".join(["x" * 100] * 6)
    ran = hotlap(*TUNE, "--out", long)
    assert ran.code == 2
    assert "its path is too long for SQLite" in ran.err.splitlines()[-1]
    assert not (here / ("x" * 100)).exists()
    for command in (("check", "x" * 600), ("check", f"{'x' * 600}.toml"), ("check", "straight.toml", "--reference", "x" * 600)):
        ran = hotlap(*command)
        assert (ran.code, len(ran.err.splitlines())) == (2, 1)


TOO_LONG = "x" * 300  # of a name, which may have 255 bytes
NAMED = (  # commands that are given a name
    (*TUNE, "--out", TOO_LONG),
    ("tune", "straight.toml", "--first-guess", f"{TOO_LONG}.toml"),
    ("tune", "straight.toml", "--goal", "lap_time", "--out", TOO_LONG),
    ("compare", "--races", "default", "--seeds", "1", "--out", TOO_LONG),
    ("learn", "circle-34", "--out", TOO_LONG),
    ("reproduce", "table1", "--out", TOO_LONG),
    ("fly", "straight.toml", "--parameters", TOO_LONG),
    ("fly", "straight.toml", "--parameters", f"{TOO_LONG}.toml"),
    ("fly", "straight.toml", "--log", TOO_LONG),
    ("fly", "straight.toml", "--reference", TOO_LONG),
    ("plan", "straight.toml", "--out", TOO_LONG),
    ("landscape", "straight.toml", "--out", f"{TOO_LONG}.png"),
    ("new", "track", TOO_LONG),
    ("import", TOO_LONG),
    ("report", TOO_LONG),
    ("watch", TOO_LONG, "--port", "0"),
    ("export", TOO_LONG, "--format", "csv"),
    ("transfer", TOO_LONG, "--to", "rotorpy"),
)


@pytest.mark.parametrize("command", NAMED, ids=lambda command: " ".join(command).replace(TOO_LONG, "LONG"))
def test_a_name_that_no_file_can_have_is_one_line(hotlap, here, command):
    ran = hotlap(*command)
    assert (ran.code, ran.out) == (2, ""), ran
    assert "File name too long" in ran.err.splitlines()[-1]
    assert sorted(path.name for path in here.iterdir() if path.name != "cache") == ["straight.toml"]


def test_a_folder_that_may_not_be_looked_into_is_one_line(hotlap, here, monkeypatch):
    look = Path.stat

    def refuse(path, **more):
        if path.name == FILE:
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return look(path, **more)

    (here / "mine").mkdir()
    monkeypatch.setattr(Path, "stat", refuse)
    for command in ((*TUNE, "--out", "mine"), ("report", "mine"), ("fly", "straight.toml", "--parameters", "mine")):
        ran = hotlap(*command)
        assert (ran.code, ran.err.splitlines()[-1]) == (2, "hotlap: mine: cannot be used as the folder of a study: Permission denied")


def test_numbers_beyond_all_bounds_are_refused_without_a_warning(hotlap, here):
    (here / "turned.toml").write_text("start = [0.0, 0.0, 1.0]\nattitude = [1e200, 1e200, 0.0, 0.0]\ngates = [[5.0, 0.0, 1.0]]\n")
    ran = hotlap("check", "turned.toml")
    assert (ran.code, ran.err) == (2, "hotlap: turned.toml: attitude: a quaternion (w, x, y, z) has norm 1, this one inf\n")


def test_a_race_by_way_of_another_is_one_for_every_command(hotlap, here):
    (here / "first.toml").write_text('base = "straight.toml"\n')
    (here / "second.toml").write_text('base = "./first.toml"\n')
    assert hotlap("check", "second.toml", "--flights", "0").code == 0
    assert hotlap("plan", "second.toml", "--out", "plan.csv").code == 0


def test_more_gates_than_can_be_flown_are_refused(hotlap, here):
    (here / "many.toml").write_text(
        f"start = [0.0, 0.0, 1.0]\nlaps = 11\ngates = [{', '.join(f'[{k}.0, 0.0, 1.0]' for k in range(1, 101))}]\n"
    )
    ran = hotlap("check", "many.toml")
    assert (ran.code, ran.err) == (2, "hotlap: many.toml: gates: there are 1100 in all laps, and may be 1000\n")


def test_a_full_disk_is_a_failure_of_the_work_and_no_bad_input(hotlap, here, monkeypatch):
    hotlap(*TUNE, "--out", "mine")

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    ran = hotlap("report", "mine")
    assert (ran.code, ran.err.splitlines()[-1]) == (1, "hotlap: mine/report.html: cannot be written: No space left on device")
    assert not list((here / "mine").glob("*.part"))

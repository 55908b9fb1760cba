"""What is kept is kept by the drive, also where `fsync` stops short of it, as on macOS."""

from __future__ import annotations

import fcntl
import os
import re
from pathlib import Path

import pytest

import hotlap
from hotlap.study.database import Database
from hotlap.system import drive
from hotlap.system.drive import flush
from hotlap.system.journal import Journal
from hotlap.system.text_files import replace

FULL = 51  # of macOS


@pytest.fixture
def flushed(monkeypatch) -> list[tuple[str, str]]:
    """(how, what) was flushed, on a system such as macOS."""
    found = []

    def note(how: str, descriptor: int) -> None:
        found.append((how, Path(f"/proc/self/fd/{descriptor}").readlink().name))

    monkeypatch.setattr(drive, "FULL", FULL)
    monkeypatch.setattr(fcntl, "fcntl", lambda descriptor, command: note(f"fcntl {command}", descriptor))
    monkeypatch.setattr(os, "fsync", lambda descriptor: note("fsync", descriptor))
    return found


on_linux = pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="asks Linux which file a descriptor is of")


@on_linux
def test_a_journal_and_its_new_folder_are_flushed_to_the_drive(tmp_path, flushed):
    with Journal.opened(tmp_path) as journal:
        journal.add("one", 1)
        assert flushed == [(f"fcntl {FULL}", "lines.jsonl"), (f"fcntl {FULL}", tmp_path.name)]
        flushed.clear()
        journal.add("two", 2)
    assert flushed == [(f"fcntl {FULL}", "lines.jsonl")]


@on_linux
def test_a_whole_file_and_its_folder_are_flushed_to_the_drive(tmp_path, flushed):
    replace(tmp_path / "file", "text")
    assert [how for how, _ in flushed] == [f"fcntl {FULL}"] * 2
    assert flushed[-1][1] == tmp_path.name


def test_a_file_system_that_cannot_flush_its_drive_synchronises(monkeypatch):
    done = []

    def refuse(*_):
        raise OSError(45, "Operation not supported")

    monkeypatch.setattr(drive, "FULL", FULL)
    monkeypatch.setattr(fcntl, "fcntl", refuse)
    monkeypatch.setattr(os, "fsync", done.append)
    flush(3)
    assert done == [3]
    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(OSError, match="not supported"):
        flush(3)


@pytest.mark.parametrize("owned", [True, False])
def test_a_study_is_flushed_to_the_drive(tmp_path, owned):
    Database(tmp_path, owned=True).close()
    (tmp_path / "study.sqlite").touch()
    database = Database(tmp_path, owned=owned)
    assert database.execute("PRAGMA fullfsync") == [(1,)]
    database.close()


def test_nothing_is_synchronised_in_another_way():
    """Whoever needs a file on the drive calls `flush`."""
    files = Path(hotlap.__file__).parent.rglob("*.py")
    assert {path.name for path in files if re.search(r"\b(fsync|fdatasync|os\.sync)\(", path.read_text(encoding="utf-8"))} == {"drive.py"}

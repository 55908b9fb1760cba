"""A file takes its place when all of it is on the disk; nothing that lies there before is followed, and nothing is left."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

import pytest

from hotlap.core.errors import InputError
from hotlap.system import text_files, whole_files
from hotlap.system.journal import Journal
from hotlap.system.text_files import create, replace
from hotlap.system.whole_files import new_part, written_whole


def test_links_that_someone_has_laid_are_not_followed(tmp_path):
    """Neither that of the name of the part, as it was once, nor that of the file itself."""
    (tmp_path / "victim").write_text("precious")
    for name in ("x.csv.part", "x.csv"):
        (tmp_path / name).symlink_to(tmp_path / "victim")
    replace(tmp_path / "x.csv", "plan")
    assert (tmp_path / "victim").read_text() == "precious"
    assert not (tmp_path / "x.csv").is_symlink()
    assert (tmp_path / "x.csv").read_text() == "plan"


def test_a_part_is_new_or_not_at_all(tmp_path, monkeypatch):
    monkeypatch.setattr(whole_files.secrets, "token_hex", lambda _: "guessed")
    (tmp_path / "victim").write_text("precious")
    (tmp_path / ".hotlap-guessed.part").symlink_to(tmp_path / "victim")
    for write in (create, replace):
        with pytest.raises(InputError, match="exist"):
            write(tmp_path / "x.csv", "plan")
    assert (tmp_path / "victim").read_text() == "precious"


def test_names_of_parts_differ(tmp_path):
    assert len({new_part(tmp_path) for _ in range(20)}) == 20


def test_a_long_name_has_room_for_a_part(tmp_path):
    name = "x" * 255
    replace(tmp_path / name, "text")
    create(tmp_path / ("y" * 255), "text")
    assert (tmp_path / name).read_text() == "text"
    with pytest.raises(InputError, match="File name too long"):
        replace(tmp_path / (name + "x"), "text")
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize("mask", [0o002, 0o022, 0o077])
def test_others_may_read_what_the_umask_lets_them(tmp_path, mask):
    before = os.umask(mask)
    try:
        replace(tmp_path / "replaced", "text")
        create(tmp_path / "created", "text")
    finally:
        os.umask(before)
    assert {file.stat().st_mode & 0o777 for file in tmp_path.iterdir()} == {0o666 & ~mask}


def test_a_pipe_or_a_device_is_not_replaced_by_a_file(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("/dev/null")
    for name in ("pipe", "link"):
        with pytest.raises(InputError, match="is no ordinary file"):
            replace(tmp_path / name, "text")
    assert (tmp_path / "pipe").is_fifo()


def test_file_and_folder_are_on_the_disk_before_it_is_done(tmp_path, monkeypatch):
    done, sync, move = [], whole_files.sync, whole_files.Path.replace
    monkeypatch.setattr(whole_files, "sync", lambda path: (sync(path), done.append(path.suffix)))
    monkeypatch.setattr(whole_files.Path, "replace", lambda part, path: (move(part, path), done.append("moved")))
    with written_whole(tmp_path / "film.gif") as part:
        part.write_bytes(b"film")
    assert done == [".part", "moved", ""]


def test_a_folder_that_cannot_be_synchronised_is_no_error(tmp_path, monkeypatch):
    sync = os.fsync

    def refuse(descriptor):
        if stat.S_ISDIR(os.fstat(descriptor).st_mode):
            raise OSError(22, "Invalid argument")
        sync(descriptor)

    monkeypatch.setattr(whole_files.os, "fsync", refuse)
    replace(tmp_path / "file", "text")
    assert (tmp_path / "file").read_text() == "text"


def test_a_folder_in_which_one_may_write_and_not_look_is_no_error(tmp_path, monkeypatch):
    """Of mode 0733, where what comes in is not shown to all."""
    begin = os.open

    def refuse(path, *arguments, **more):
        if Path(path).is_dir():
            raise PermissionError(errno.EACCES, "Permission denied")
        return begin(path, *arguments, **more)

    monkeypatch.setattr(whole_files.os, "open", refuse)
    replace(tmp_path / "replaced", "text")
    create(tmp_path / "created", "text")
    with Journal.opened(tmp_path / "journal") as journal:
        journal.add("key", 1)
    assert Journal(tmp_path / "journal").done == {"key": 1}
    assert {path.name for path in tmp_path.iterdir()} == {"replaced", "created", "journal"}


def test_a_file_system_without_second_names_has_new_files_too(tmp_path, monkeypatch):
    def refuse(*_):
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(text_files.Path, "hardlink_to", refuse)
    create(tmp_path / "file", "text")
    with pytest.raises(InputError, match="exists already"):
        create(tmp_path / "file", "other")
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [("file", "text")]


def test_a_link_that_leads_nowhere_is_no_free_name(tmp_path):
    (tmp_path / "new").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match="exists already"):
        create(tmp_path / "new", "text")
    assert not (tmp_path / "elsewhere").exists()


def test_parts_of_killed_processes_go_when_they_are_old_and_nothing_else(tmp_path):
    names = (".hotlap-old.part", ".hotlap-young.part", "x.csv.part", ".hotlap-link.part", "precious")
    for name in names:
        if "link" not in name:
            (tmp_path / name).write_text("begun")
    (tmp_path / ".hotlap-link.part").symlink_to("precious")
    for name in names:
        if "young" not in name:
            os.utime(tmp_path / name, (0, 0), follow_symlinks=False)
    replace(tmp_path / "file", "text")
    assert {file.name for file in tmp_path.iterdir()} == {"file", *names[1:]}

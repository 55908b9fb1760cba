"""A lock is a file of the folder, not what somebody's link leads to."""

from __future__ import annotations

import errno
import os

import pytest

from hotlap.core.errors import StudyError
from hotlap.system import folder_lock
from hotlap.system.folder_lock import LOCK, hold


def test_a_link_in_the_place_of_the_lock_is_not_followed(tmp_path):
    (tmp_path / "victim").write_text("precious")
    (tmp_path / LOCK).symlink_to(tmp_path / "victim")
    with pytest.raises(StudyError, match="cannot be used as the folder of a study"):
        hold(tmp_path)
    assert (tmp_path / "victim").read_text() == "precious"


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        (errno.ENOSYS, "its file system has no locks"),
        (errno.ENOLCK, "its file system has no locks"),
        (errno.EOPNOTSUPP, "its file system has no locks"),
        (errno.EIO, "it cannot be locked"),
    ],
)
def test_a_file_system_without_locks_is_no_other_process(tmp_path, monkeypatch, fault, said):
    def refuse(*_):
        raise OSError(fault, os.strerror(fault))

    monkeypatch.setattr(folder_lock.fcntl, "flock", refuse)
    with pytest.raises(StudyError, match=said) as raised:
        hold(tmp_path)
    assert "process " not in str(raised.value)
    assert os.strerror(fault) in str(raised.value)


def test_one_that_has_not_said_who_it_is_is_another_process(tmp_path):
    lock = hold(tmp_path)
    (tmp_path / LOCK).write_text("")
    with pytest.raises(StudyError, match="another process is working on this study"):
        hold(tmp_path)
    os.close(lock)


def test_a_second_process_is_told_which_one_works_there(tmp_path):
    lock = hold(tmp_path)
    with pytest.raises(StudyError, match=f"process {os.getpid()} is working on this study"):
        hold(tmp_path)
    os.close(lock)
    os.close(hold(tmp_path))

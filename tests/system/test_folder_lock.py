"""A lock is a file of the folder, not what somebody's link leads to."""

from __future__ import annotations

import os

import pytest

from hotlap.core.errors import StudyError
from hotlap.system.folder_lock import LOCK, hold


def test_a_link_in_the_place_of_the_lock_is_not_followed(tmp_path):
    (tmp_path / "victim").write_text("precious")
    (tmp_path / LOCK).symlink_to(tmp_path / "victim")
    with pytest.raises(StudyError, match="cannot be used as the folder of a study"):
        hold(tmp_path)
    assert (tmp_path / "victim").read_text() == "precious"


def test_a_second_process_is_told_which_one_works_there(tmp_path):
    lock = hold(tmp_path)
    with pytest.raises(StudyError, match=f"process {os.getpid()} is working on this study"):
        hold(tmp_path)
    os.close(lock)
    os.close(hold(tmp_path))

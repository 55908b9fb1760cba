"""Checks that are made before anything takes its time."""

import os

import pytest

from hotlap.api.inputs import check_target
from hotlap.core.errors import InputError


@pytest.fixture
def shut(tmp_path):
    """A folder in which nothing can be made."""
    file = tmp_path / "there.png"
    file.touch()
    tmp_path.chmod(0o555)
    yield tmp_path
    tmp_path.chmod(0o755)


def test_a_folder_that_cannot_be_written_in_is_refused_before_the_work(shut):
    if os.access(shut, os.W_OK):
        pytest.skip("this user may write everywhere")
    with pytest.raises(InputError, match=r"map\.png: cannot be written: Permission denied"):
        check_target(shut / "map.png")


def test_a_file_that_can_be_written_is_left_to_the_writer(shut, tmp_path):
    check_target(shut / "there.png", (".png",))
    tmp_path.chmod(0o755)
    check_target(shut / "map.png", (".png",))
    check_target(None)

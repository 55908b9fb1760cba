"""Text files are written whole or not at all."""

from __future__ import annotations

import resource

import pytest

from hotlap.core.errors import InputError
from hotlap.system.text_files import create, replace


@pytest.fixture
def full_disk():
    """No file may grow beyond 1000 bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("write", [create, replace])
@pytest.mark.usefixtures("full_disk")
def test_nothing_stays_of_a_file_for_which_there_is_no_room(tmp_path, write):
    with pytest.raises(InputError, match=r"new\.toml: cannot be written: "):
        write(tmp_path / "new.toml", "#" * 100_000)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("full_disk")
def test_an_older_file_stays_where_there_is_no_room_for_the_new_one(tmp_path):
    path = tmp_path / "old.toml"
    replace(path, "a = 1\n")
    with pytest.raises(InputError, match="cannot be written"):
        replace(path, "#" * 100_000)
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [("old.toml", "a = 1\n")]


def test_a_file_that_is_there_is_left_as_it_is(tmp_path):
    path = tmp_path / "old.toml"
    create(path, "a = 1\n")
    with pytest.raises(InputError, match="exists already"):
        create(path, "b = 2\n")
    assert path.read_text() == "a = 1\n"

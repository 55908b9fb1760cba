"""Text files are written whole or not at all."""

from __future__ import annotations

import resource

import pytest

from hotlap.core.errors import InputError
from hotlap.system.text_files import create, replace
from hotlap.system.whole_files import written_whole

UNWRITABLE = "begun" + "\ud800"  # no UTF-8: fails when the file is open, as on a full disk


@pytest.mark.parametrize("write", [create, replace])
def test_what_cannot_be_written_leaves_nothing_behind(tmp_path, write):
    with pytest.raises(InputError, match=r"new\.toml: cannot be written"):
        write(tmp_path / "new.toml", UNWRITABLE)
    assert not list(tmp_path.iterdir())


def test_what_cannot_be_written_leaves_an_older_file_as_it_is(tmp_path):
    path = tmp_path / "old.toml"
    path.write_text("old")
    for write in (create, replace):
        with pytest.raises(InputError):
            write(path, UNWRITABLE)
        assert [file.name for file in tmp_path.iterdir()] == ["old.toml"]
        assert path.read_text() == "old"


def write_half(path):
    with written_whole(path) as part:
        part.write_text("begun")
        raise KeyboardInterrupt


def test_a_file_that_an_interruption_ends_leaves_nothing_behind(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        write_half(tmp_path / "film.gif")
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_a_file_is_refused_in_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    for write in (create, replace):
        with pytest.raises(InputError, match="Not a directory"):
            write(tmp_path / "file" / "new.toml", "text")


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

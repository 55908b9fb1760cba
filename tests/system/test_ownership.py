"""A folder is trusted when nobody else can write to it, nor put another in its place."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from hotlap.system import ownership
from hotlap.system.ownership import TEMPORARY, doubt, is_private, is_trusted, make_private, temporary


@pytest.fixture
def umask():
    """Sets the umask, and resets it."""
    before = os.umask(0o022)
    yield os.umask
    os.umask(before)


STRANGER = 54321


def owned_by(user, status):
    """The same status of a file of another user."""
    return os.stat_result((*status[:4], user, *status[5:]))


@pytest.fixture
def stranger(monkeypatch, tmp_path):
    """Whoever has made the files below the temporary folder of the test is another user."""
    look = Path.lstat

    def lstat(path):
        status = look(path)
        return owned_by(STRANGER, status) if path.is_relative_to(tmp_path) else status

    monkeypatch.setattr(Path, "lstat", lstat)


@pytest.mark.parametrize("mask", [0o000, 0o022, 0o077, 0o777])
def test_a_folder_is_made_for_oneself_alone_whatever_the_umask(tmp_path, umask, mask):
    place = tmp_path / "above" / "folder"
    umask(mask)
    make_private(place)
    umask(0o022)
    assert [folder.stat().st_mode & 0o777 for folder in (place, place.parent)] == [0o700, 0o700]
    assert doubt(place) == ""
    make_private(place)


def test_a_folder_that_is_there_keeps_its_permissions(tmp_path):
    tmp_path.chmod(0o755)
    make_private(tmp_path)
    assert tmp_path.stat().st_mode & 0o777 == 0o755
    assert doubt(tmp_path) == ""


def test_a_file_where_the_folder_should_be_is_an_error(tmp_path):
    (tmp_path / "file").write_text("")
    for place in (tmp_path / "file", tmp_path / "file" / "folder"):
        with pytest.raises(OSError, match="file"):
            make_private(place)


@pytest.mark.parametrize("mode", [0o777, 0o757, 0o1777])
def test_others_may_not_write_to_it(tmp_path, mode):
    place = tmp_path / "folder"
    place.mkdir()
    place.chmod(mode)
    assert doubt(place) == f"others may write to {place}"


def test_nor_to_a_folder_above_it_that_lets_them_replace_it(tmp_path):
    above, place = tmp_path / "above", tmp_path / "above" / "folder"
    make_private(place)
    above.chmod(0o777)
    assert doubt(place) == doubt(place / "to be made") == f"others may write to {above}"
    above.chmod(0o1777)
    assert doubt(place) == doubt(place / "to be made") == ""


def test_a_group_of_others_may_not_write_either(tmp_path, monkeypatch):
    tmp_path.chmod(0o770)
    monkeypatch.setattr(ownership, "_is_own", lambda _: False)
    assert doubt(tmp_path).startswith("others may write")
    monkeypatch.setattr(ownership, "_is_own", lambda _: True)
    assert doubt(tmp_path) == ""


@pytest.mark.usefixtures("stranger")
def test_a_folder_of_another_user_is_not_trusted(tmp_path):
    assert doubt(tmp_path) == f"{tmp_path} belongs to user {STRANGER}"
    assert not is_private(tmp_path)


def test_what_root_has_made_is_as_good_as_ones_own(tmp_path, monkeypatch):
    """An image is built by root, and run as another user."""
    (tmp_path / "file").write_text("")
    look = Path.lstat
    monkeypatch.setattr(Path, "lstat", lambda path: owned_by(0, look(path)))
    monkeypatch.setattr(ownership, "_trusted", lambda: frozenset({0, STRANGER}))
    monkeypatch.setattr(ownership.os, "getuid", lambda: STRANGER)
    assert doubt(tmp_path) == ""
    assert is_trusted((tmp_path / "file").lstat())
    assert not is_private(tmp_path)


@pytest.mark.parametrize("mode", [0o777, 0o755])
def test_a_folder_that_somebody_else_makes_first_is_refused(tmp_path, monkeypatch, mode):
    """It was looked at before it was there, and in a folder as /tmp everybody may make it."""
    place, make = tmp_path / "folder" / "inner", Path.mkdir

    def slower(path, *arguments):
        make(path, *arguments)
        path.chmod(mode)
        raise FileExistsError

    assert doubt(place) == ""
    monkeypatch.setattr(Path, "mkdir", slower)
    look = Path.lstat
    others = (place, place.parent)
    monkeypatch.setattr(Path, "lstat", lambda path: owned_by(STRANGER, look(path)) if path in others else look(path))
    with pytest.raises(PermissionError, match=f"{place.parent} belongs to user {STRANGER}"):
        make_private(place)


def test_a_temporary_folder_of_ones_own_counts_wherever_it_lies(tmp_path, monkeypatch):
    above, place = tmp_path / "above", tmp_path / "above" / "folder"
    make_private(place)
    above.chmod(0o777)
    assert temporary() is None
    monkeypatch.setenv(TEMPORARY, str(place))
    assert temporary() == place
    make_private(place / "inner")
    assert doubt(place / "inner") == doubt(place) == ""
    (place / "inner").chmod(0o777)
    assert "others may write" in doubt(place / "inner")
    assert "others may write" in doubt(above / "other")
    place.chmod(0o755)
    assert temporary() is None
    place.rename(tmp_path / "elsewhere")
    (tmp_path / "elsewhere").chmod(0o700)
    place.symlink_to(tmp_path / "elsewhere")
    assert temporary() is None
    for odd in ("", "relative", str(tmp_path / "nothing")):
        monkeypatch.setenv(TEMPORARY, odd)
        assert temporary() is None


def test_links_are_followed_and_what_they_lead_to_is_looked_at(tmp_path):
    real, link = tmp_path / "real", tmp_path / "link"
    make_private(real / "inner")
    for target in (real, Path("real"), Path("..") / tmp_path.name / "real"):
        link.symlink_to(target)
        assert doubt(link / "inner") == doubt(link) == ""
        real.chmod(0o777)
        assert doubt(link / "inner") == doubt(link) == f"others may write to {real}"
        real.chmod(0o700)
        link.unlink()
    link.symlink_to(link)
    assert "too many links" in doubt(link)


def test_a_file_is_trusted_when_it_is_an_ordinary_one_that_others_cannot_write(tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    assert is_trusted(file.stat())
    file.chmod(0o606)
    assert not is_trusted(file.stat())
    assert not is_trusted(tmp_path.stat())


@pytest.mark.usefixtures("stranger")
def test_a_file_of_another_user_is_not_trusted(tmp_path):
    (tmp_path / "file").write_text("")
    assert not is_trusted((tmp_path / "file").lstat())

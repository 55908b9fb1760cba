"""What was kept is read as it was written, or not at all, and then one line says so."""

from __future__ import annotations

import errno
import os
import random
import warnings

import pytest

from hotlap.system import ownership, sealed
from hotlap.system.sealed import CacheWarning

CONTENT = bytes(range(256)) * 20


@pytest.fixture
def path(tmp_path):
    place = tmp_path / "kind" / "name"
    assert sealed.write(place, CONTENT)
    return place


def rejected(path):
    """Read a file that is to be refused."""
    with pytest.warns(CacheWarning, match=r"name: is .*, so it is made anew$") as said:
        assert sealed.read(path) is None
    assert len(said) == 1
    return str(said[0].message)


def test_it_is_read_as_it_was_written_by_its_owner_alone(path):
    assert sealed.read(path) == CONTENT
    assert path.stat().st_mode & 0o777 == 0o600
    assert path.parent.stat().st_mode & 0o777 == 0o700
    assert sealed.write(path, b"")
    assert sealed.read(path) == b""
    assert [file.name for file in path.parent.iterdir()] == ["name"]


def test_what_is_not_there_is_no_fault(tmp_path):
    assert sealed.read(tmp_path / "nothing") is None
    (tmp_path / "file").write_text("")
    assert sealed.read(tmp_path / "file" / "nothing") is None


def test_no_damage_is_overlooked_and_it_is_told_of_once(path):
    whole, chance = path.read_bytes(), random.Random(0)
    places = sorted({0, len(whole) - 1, *(chance.randrange(len(whole)) for _ in range(60))})
    damages = [whole[:k] + bytes([whole[k] ^ 1 << k % 8]) + whole[k + 1 :] for k in places]
    damages += [whole[:k] for k in places] + [whole[k:] for k in places[1:]] + [whole + b"\0", whole + whole]
    for damage in damages:
        path.write_bytes(damage)
        assert "is damaged" in rejected(path)
        assert sealed.read(path) is None
        assert not path.exists()


@pytest.mark.parametrize("place", ["kind/other", "other/name"])
def test_one_that_lies_in_the_place_of_another_is_not_read(path, place):
    other = path.parent.parent / place
    other.parent.mkdir(exist_ok=True)
    path.rename(other)
    with pytest.warns(CacheWarning, match="is damaged"):
        assert sealed.read(other) is None


def test_a_link_is_not_followed(path):
    path.rename(path.with_name("elsewhere"))
    path.symlink_to(path.with_name("elsewhere"))
    assert "no ordinary file" in rejected(path)
    assert path.with_name("elsewhere").exists()


def test_a_link_is_replaced_by_what_is_written_and_what_it_leads_to_stays(path, tmp_path):
    (tmp_path / "precious").write_text("mine")
    path.unlink()
    path.symlink_to(tmp_path / "precious")
    assert sealed.write(path, CONTENT)
    assert sealed.read(path) == CONTENT
    assert (tmp_path / "precious").read_text() == "mine"


def test_a_pipe_is_not_waited_for(path):
    path.unlink()
    os.mkfifo(path)
    assert "not yours alone" in rejected(path)


def test_a_file_that_others_may_write_to_is_not_read(path):
    path.chmod(0o666)
    assert "not yours alone" in rejected(path)


def test_a_file_of_another_user_is_not_read(path, monkeypatch):
    monkeypatch.setattr(ownership, "_trusted", lambda: frozenset({54321}))
    assert "not yours alone" in rejected(path)


def test_one_that_is_too_large_is_not_read_whole(path, monkeypatch):
    monkeypatch.setattr(sealed, "LARGEST", 100)
    assert "is damaged" in rejected(path)


@pytest.mark.parametrize("fault", [errno.ESTALE, errno.EIO, errno.EMFILE, errno.ENOMEM, errno.EACCES])
@pytest.mark.parametrize("step", ["open", "read"])
def test_one_that_cannot_be_read_now_stays_and_nothing_is_said(path, monkeypatch, step, fault):
    def fail(*_):
        raise OSError(fault, os.strerror(fault))

    with monkeypatch.context() as patched, warnings.catch_warnings():
        warnings.simplefilter("error")
        patched.setattr(os, step, fail)
        assert sealed.read(path) is None
    assert sealed.read(path) == CONTENT


def test_a_damaged_one_that_cannot_be_removed_is_no_end(path, monkeypatch):
    def refuse(_path):
        raise OSError(errno.EROFS, "Read-only file system")

    path.write_bytes(b"odd")
    monkeypatch.setattr(sealed.Path, "unlink", refuse)
    assert "is damaged" in rejected(path)


def test_a_cache_that_is_only_read_is_read(path):
    for place in (path, path.parent):
        place.chmod(place.stat().st_mode & 0o555)
    try:
        assert sealed.read(path) == CONTENT
        assert sealed.write(path.parent.parent / "kind", b"more") is False
    finally:
        path.parent.chmod(0o700)


def test_a_folder_in_its_place_is_no_end(path):
    path.unlink()
    path.mkdir()
    rejected(path)
    assert not sealed.write(path, CONTENT)
    assert [file.name for file in path.parent.iterdir()] == ["name"]


def test_what_killed_processes_have_left_goes_with_the_next_that_is_kept(path):
    left = [path.with_name(name) for name in ("tmpab12.part", ".hotlap-0123456789abcdef.part", "tmpyoung.part", "tmp.npz", "plan.part")]
    for file in left:
        file.write_bytes(b"begun")
        if file.name != "tmpyoung.part":
            os.utime(file, (0, 0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert sealed.write(path, CONTENT)
    assert sorted(file.name for file in path.parent.iterdir()) == ["name", "plan.part", "tmp.npz", "tmpyoung.part"]

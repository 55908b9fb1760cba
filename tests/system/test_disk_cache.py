"""Where results are kept, and fingerprints of code."""

import os
import warnings
from pathlib import Path

import pytest

from hotlap.core.errors import InputError
from hotlap.system import disk_cache, sealed
from hotlap.system.disk_cache import digest_sources, folder, source_files
from hotlap.system.ownership import TEMPORARY
from hotlap.system.sealed import CacheWarning


@pytest.fixture(autouse=True)
def bare(monkeypatch, tmp_path):
    """No folder of one's own, an empty home."""
    monkeypatch.delenv("HOTLAP_CACHE", raising=False)
    monkeypatch.setenv(TEMPORARY, "")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))


def test_results_are_kept_in_the_home_by_default(tmp_path):
    assert folder("plans") == tmp_path / ".cache" / "hotlap" / "plans"


def test_the_shared_cache_of_the_desktop_is_used_where_it_is_absolute(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "shared"))
    assert folder("plans") == tmp_path / "shared" / "hotlap" / "plans"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    assert folder("plans") == tmp_path / ".cache" / "hotlap" / "plans"


def test_ones_own_folder_comes_first(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "shared"))
    monkeypatch.setenv("HOTLAP_CACHE", "~/own")
    assert folder("plans") == tmp_path / "own" / "plans"


@pytest.fixture
def temporary(monkeypatch, tmp_path):
    """Where temporary folders are made, as /tmp; those of one process are removed as at its end."""
    place = tmp_path / "tmp"
    place.mkdir()
    place.chmod(0o1777)
    monkeypatch.setattr(disk_cache.tempfile, "tempdir", str(place))
    ends = []
    monkeypatch.setattr(disk_cache.atexit, "register", lambda *end: ends.append(end))
    yield place
    for end, *arguments in ends:
        end(*arguments)
    assert {path.name for path in place.iterdir()} <= {LASTING}


LASTING = f"hotlap-{os.getuid()}"


def no_home():
    raise RuntimeError("no home")


def found_with_a_warning(monkeypatch, reason="has no home"):
    """The folder of a new process, and of those that it starts."""
    monkeypatch.setenv(TEMPORARY, "")
    with pytest.warns(CacheWarning, match=reason) as said:
        found = folder("plans").parent
    assert len(said) == 1
    assert str(found) in str(said[0].message)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert folder("kernels", "1234") == found / "kernels" / "1234"
        kept = folder("plans") / "kept"
        assert sealed.write(kept, b"content")
        assert sealed.read(kept) == b"content"
    assert os.environ[TEMPORARY] == str(found)
    assert "HOTLAP_CACHE" not in os.environ
    assert found.stat().st_mode & 0o777 == 0o700
    return found


@pytest.mark.parametrize("home", [no_home, lambda: Path("relative")])
def test_a_user_without_a_home_gets_the_same_temporary_folder_every_time(monkeypatch, temporary, home):
    monkeypatch.setattr(Path, "home", home)
    assert {found_with_a_warning(monkeypatch) for _ in range(2)} == {temporary / LASTING}


def someone_may_write(place):
    place.mkdir()
    place.chmod(0o777)


def someone_may_read(place):
    place.mkdir()
    place.chmod(0o755)


def leads_elsewhere(place):
    (place.parent / "elsewhere").mkdir(mode=0o700)
    place.symlink_to(place.parent / "elsewhere")


@pytest.mark.parametrize("plant", [someone_may_write, someone_may_read, leads_elsewhere, Path.touch])
def test_one_that_is_not_ones_own_alone_is_not_used(monkeypatch, temporary, plant):
    monkeypatch.setattr(Path, "home", no_home)
    plant(temporary / LASTING)
    found = {found_with_a_warning(monkeypatch) for _ in range(2)}
    assert len(found) == 2
    assert all(place.parent == temporary and place.name != LASTING for place in found)
    for place in temporary.iterdir():
        if place not in found and place.name != LASTING:
            assert list(place.iterdir()) == []
            place.rmdir()


def test_a_temporary_folder_of_everybody_is_no_end(monkeypatch, temporary):
    """Others could replace what lies there, so that nothing that can be foreseen is used."""
    monkeypatch.setattr(Path, "home", no_home)
    temporary.chmod(0o777)
    assert len({found_with_a_warning(monkeypatch) for _ in range(2)}) == 2
    assert not (temporary / LASTING).exists()


@pytest.mark.parametrize("shared", [".cache", ".cache/hotlap", ".cache/hotlap/plans"])
def test_the_usual_folder_is_not_used_where_others_may_write(monkeypatch, tmp_path, temporary, shared):
    (tmp_path / ".cache" / "hotlap" / "plans").mkdir(parents=True)
    (tmp_path / shared).chmod(0o777)
    assert found_with_a_warning(monkeypatch, f"others may write to {tmp_path / shared}, so") == temporary / LASTING


@pytest.mark.parametrize("shared", ["own", "own/plans"])
def test_ones_own_folder_is_refused_where_others_may_write(monkeypatch, tmp_path, shared):
    (tmp_path / "own" / "plans").mkdir(parents=True)
    (tmp_path / shared).chmod(0o777)
    monkeypatch.setenv("HOTLAP_CACHE", str(tmp_path / "own"))
    with pytest.raises(InputError, match=rf"^HOTLAP_CACHE: others may write to {tmp_path / shared}, so .*chmod 700"):
        folder("plans")


def test_folders_below_are_looked_at_as_well(monkeypatch, tmp_path):
    (tmp_path / "own" / "kernels" / "1234").mkdir(parents=True)
    (tmp_path / "own" / "kernels" / "1234").chmod(0o777)
    monkeypatch.setenv("HOTLAP_CACHE", str(tmp_path / "own"))
    with pytest.raises(InputError, match="1234, so"):
        folder("kernels", "1234")


def test_the_home_of_an_unknown_user_is_one_line(monkeypatch):
    monkeypatch.setenv("HOTLAP_CACHE", "~no_such_user_at_all/c")
    with pytest.raises(InputError, match=r"^HOTLAP_CACHE: the home of ~no_such_user_at_all is not known$"):
        folder("plans")


def test_asking_for_a_folder_makes_none(tmp_path):
    folder("plans")
    assert not (tmp_path / ".cache").exists()


def test_a_fingerprint_changes_with_any_file_of_a_folder(tmp_path):
    (tmp_path / "inner").mkdir()
    (tmp_path / "a.py").write_text("x = 1")
    inner = tmp_path / "inner" / "b.py"
    inner.write_text("y = 1")
    found = []
    for text in ("y = 1", "y = 2", "y = 1"):
        inner.write_text(text)
        digest_sources.cache_clear()
        found.append(digest_sources(tmp_path))
    assert found[0] == found[2] != found[1]
    assert len(found[0]) == 16


def digest_of(path: Path, text: str) -> str:
    """The fingerprint of a file with a text."""
    path.write_text(text)
    digest_sources.cache_clear()
    return digest_sources(path)


CODE = '''"""A module."""

LIMIT = 3.5


class Wing:
    """Lifts."""

    area: float = 1.0
    """m^2"""


def lift(x):
    """How much."""
    return "how much" if x > LIMIT else x
'''


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"""How much."""', '"""How little."""'),
        ('"""A module."""', ""),
        ('"""m^2"""', '"""square metres"""'),
        ("LIMIT = 3.5", "LIMIT  =  3.5  # m"),
    ],
)
def test_words_and_formatting_change_no_fingerprint(tmp_path, old, new):
    assert old in CODE
    assert digest_of(tmp_path / "a.py", CODE) == digest_of(tmp_path / "a.py", CODE.replace(old, new))


@pytest.mark.parametrize(("old", "new"), [("3.5", "3.6"), ("x > LIMIT", "x >= LIMIT"), ('"how much"', '"how little"'), ("area", "span")])
def test_code_changes_the_fingerprint(tmp_path, old, new):
    assert digest_of(tmp_path / "a.py", CODE) != digest_of(tmp_path / "a.py", CODE.replace(old, new))


def test_a_text_is_parsed_once(tmp_path, monkeypatch):
    found = digest_of(tmp_path / "a.py", CODE)
    monkeypatch.setattr(disk_cache, "_digest_code", lambda texts: 1 / 0)
    assert digest_of(tmp_path / "a.py", CODE) == found


def test_a_damaged_note_is_made_anew(tmp_path):
    found = digest_of(tmp_path / "a.py", CODE)
    (note,) = folder("digests").iterdir()
    for damage in (b"\xff", b"0123456789abcdef", note.read_bytes().replace(found.encode(), b"0123456789abcdef")):
        note.write_bytes(damage)
        with pytest.warns(CacheWarning, match="is damaged"):
            assert digest_of(tmp_path / "a.py", CODE) == found


def test_a_folder_that_cannot_be_made_is_no_error(tmp_path, monkeypatch):
    found = digest_of(tmp_path / "a.py", CODE)
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("HOTLAP_CACHE", str(tmp_path / "file"))
    assert digest_of(tmp_path / "a.py", CODE) == found


def test_modules_can_be_left_out():
    files = source_files("hotlap.planning", without=("hotlap.planning.cache",))
    assert files == [path for path in source_files("hotlap.planning") if path.name != "cache.py"]
    assert digest_sources("hotlap.planning", without=("hotlap.planning.cache",)) != digest_sources("hotlap.planning")


def test_a_fingerprint_takes_no_other_files(tmp_path):
    (tmp_path / "a.py").write_text("x = 1")
    before = digest_sources(tmp_path)
    (tmp_path / "notes.txt").write_text("nothing")
    digest_sources.cache_clear()
    assert digest_sources(tmp_path) == before


def test_modules_packages_and_paths_differ():
    digests = {
        digest_sources("hotlap.planning"),
        digest_sources("hotlap.planning.cache"),
        digest_sources("hotlap.planning", "hotlap.system.disk_cache"),
    }
    assert len(digests) == 3


def test_an_unknown_module_is_named():
    with pytest.raises(ModuleNotFoundError, match="no module nonesuch_module"):
        digest_sources("nonesuch_module")

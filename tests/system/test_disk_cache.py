"""Where results are kept, and fingerprints of code."""

from pathlib import Path

import pytest

from hotlap.system import disk_cache
from hotlap.system.disk_cache import digest_sources, folder, source_files


@pytest.fixture(autouse=True)
def bare(monkeypatch, tmp_path):
    """No folder of one's own, an empty home."""
    monkeypatch.delenv("HOTLAP_CACHE", raising=False)
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


def test_a_user_without_a_home_gets_a_temporary_folder(monkeypatch):
    def fail():
        raise RuntimeError("no home")

    monkeypatch.setattr(Path, "home", fail)
    assert folder("plans").is_absolute()


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
    for note in folder("digests").iterdir():
        note.write_bytes(b"\xff")
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

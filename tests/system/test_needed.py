"""What work reads where it is done is what lies where it was asked for, or it is not done."""

from __future__ import annotations

import sys

import pytest

from hotlap.core.errors import InputError
from hotlap.core.own_code import find_own
from hotlap.system import needed
from hotlap.system.cluster_worker import do, fingerprint, pack, unpack
from hotlap.system.needed import check_needed, digest_needed

NAME = "needed_of_a_test"


def square(piece: int):
    yield piece**2


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    """A working folder, and a process that has worked with nothing yet."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(needed, "_loaded", {})
    return tmp_path


def refused(what: str, digest: str) -> str:
    with pytest.raises(InputError) as raised:
        check_needed(((what, digest),))
    assert "\n" not in str(raised.value)
    return str(raised.value)


def test_a_worker_does_nothing_with_another_file(here):
    file = here / "reference.csv"
    file.write_text("1\n")
    asked = ((str(file), digest_needed(str(file))),)
    assert unpack(do(pack(square, 3, asked), fingerprint())) == ([9], None)
    file.write_text("2\n")
    _, error = unpack(do(pack(square, 3, asked), fingerprint()))
    assert "reference.csv differs from ours" in str(error)
    file.unlink()
    assert "reference.csv is not there" in refused(*asked[0])


def test_a_file_that_was_copied_needs_no_restart(here):
    file = here / "reference.csv"
    for text in ("1\n", "2\n"):
        file.write_text(text)
        check_needed(((str(file), digest_needed(str(file))),))


def test_a_module_of_the_working_folder_is_found_as_its_import_finds_it(here):
    (here / f"{NAME}.py").write_text("VALUE = 3\n")
    asked = ((NAME, digest_needed(NAME)),)
    assert asked[0][1]
    assert unpack(do(pack(square, 3, asked), fingerprint())) == ([9], None)
    (here / f"{NAME}.py").rename(here / "elsewhere.py")
    assert digest_needed(NAME) == ""


def test_where_a_missing_module_was_looked_for_is_said(here):
    assert str(here) in refused(NAME, "another")


def test_nothing_is_imported_to_look_for_a_module(here):
    (here / NAME).mkdir()
    (here / NAME / "__init__.py").write_text("1 / 0\n")
    (here / NAME / "inner.py").write_text("VALUE = 3\n")
    before = digest_needed(f"{NAME}.inner"), digest_needed(NAME)
    assert all(before)
    (here / NAME / "inner.py").write_text("VALUE = 4\n")
    after = digest_needed(f"{NAME}.inner"), digest_needed(NAME)
    assert after[0] != before[0]
    assert after[1] != before[1], "a package is all of its files"
    assert NAME not in sys.modules
    assert find_own(f"{NAME}.other") is None
    assert find_own(f"{NAME}.inner.other") is None


def test_what_was_changed_after_it_was_loaded_needs_a_restart(here):
    module = here / f"{NAME}.py"
    module.write_text("VALUE = 3\n")
    first = digest_needed(NAME)
    check_needed(((NAME, first),))
    module.write_text("VALUE = 4\n")
    second = digest_needed(NAME)
    assert second != first
    assert "restart the workers" in refused(NAME, second)
    assert "copy it to every worker and restart them" in refused(NAME, "another")
    check_needed(((NAME, first),))


def test_what_was_refused_was_not_loaded_and_needs_none(here):
    module = here / f"{NAME}.py"
    module.write_text("VALUE = 3\n")
    assert "restart" not in refused(NAME, "another")
    module.write_text("VALUE = 4\n")
    check_needed(((NAME, digest_needed(NAME)),))


@pytest.mark.parametrize("name", ["", ".", "sys", "no.such.module", "..x", "cf21B_500"])
def test_what_is_no_file_and_no_module_counts_for_nothing(name):
    assert digest_needed(name) == ""


def test_compiled_modules_and_such_as_cannot_be_read_are_told_apart_by_their_bytes(here):
    for name, one, other in ((f"{NAME}.so", b"\x7fELF\0a", b"\x7fELF\0b"), (f"{NAME}_too.py", b"x =", b"y =")):
        found = []
        for content in (one, other):
            (here / name).write_bytes(content)
            found.append(digest_needed(name.partition(".")[0]))
        assert all(found)
        assert len(set(found)) == 2

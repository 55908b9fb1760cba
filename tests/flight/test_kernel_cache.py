"""Compiled code is kept where only the same sources find it, and a cache that fails is no error."""

import os
import pickle
import random
from typing import ClassVar

import numpy as np
import pytest
from numba import njit

from hotlap.core.errors import InputError
from hotlap.flight import kernel_cache
from hotlap.system import disk_cache, sealed
from hotlap.system.sealed import CacheWarning
from reached import reached


def double(x):
    return x + x


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.setenv("HOTLAP_CACHE", str(tmp_path))
    return kernel_cache.place()


def compile_and_call(label="double"):
    dispatcher = kernel_cache.keep(njit(double), label)
    assert dispatcher(np.float64(2)) == 4
    return dispatcher


def test_what_was_compiled_is_loaded_the_next_time(place):
    assert not kernel_cache.is_filled(kernel_cache.keep(njit(double), "double"))
    assert compile_and_call().stats.cache_hits == {}
    assert list(place.glob("*.nbc"))
    assert kernel_cache.is_filled(kernel_cache.keep(njit(double), "double"))
    assert sum(compile_and_call().stats.cache_hits.values()) == 1


def test_functions_do_not_share_a_place(place):
    compile_and_call("one")
    assert not kernel_cache.is_filled(kernel_cache.keep(njit(double), "two"))
    assert place.exists()


def test_every_module_that_kernels_are_made_from_takes_part():
    """What a kernel's modules import from hotlap is digested, or is never compiled."""
    never_compiled = (
        "hotlap.core.errors",
        "hotlap.core.parameters",
        "hotlap.core.printable",
        "hotlap.core.shown",
        "hotlap.reference.attitude",
        "hotlap.system",
    )
    made_from = {path for name, path in reached("hotlap.flight.kernel").items() if not name.startswith(never_compiled)}
    assert made_from - set(disk_cache.source_files(*kernel_cache.SOURCES)) == set()


def test_an_edited_source_is_another_place(tmp_path, monkeypatch):
    (tmp_path / "stage.py").write_text("GAIN = 1\n")
    monkeypatch.setattr(kernel_cache, "SOURCES", (tmp_path,))
    before = kernel_cache.place()
    (tmp_path / "stage.py").write_text("GAIN = 2\n")
    disk_cache.digest_sources.cache_clear()
    assert kernel_cache.place() != before


def test_damage_of_any_kind_is_compiled_anew_with_one_line_for_each_file(place):
    """Numba would unpickle it, and run what it calls machine code."""
    compile_and_call()
    kept = {file: file.read_bytes() for file in place.iterdir() if file.suffix in {".nbi", ".nbc"}}
    chance = random.Random(0)
    for file, whole in kept.items():
        flipped = bytearray(whole)
        flipped[chance.randrange(len(whole))] ^= 1 << chance.randrange(8)
        for damage in (b"no kernel", b"", whole[: len(whole) // 2], bytes(flipped), b"[" * 100_000):
            file.write_bytes(damage)
            with pytest.warns(CacheWarning, match=f"{file.name}: is damaged, so it is made anew") as said:
                assert compile_and_call().stats.cache_hits == {}
            assert len(said) == 1
            assert sum(compile_and_call().stats.cache_hits.values()) == 1


def test_pickles_that_were_not_written_here_are_never_read(place):
    """Nor those of an earlier version, which had no seal."""
    compile_and_call()
    for file in place.glob("*.nb?"):
        file.write_bytes(pickle.dumps(Planted()))
        with pytest.warns(CacheWarning, match="is damaged"):
            compile_and_call()
    assert Planted.ran == []


class Planted:
    """Runs when it is unpickled."""

    ran: ClassVar[list[int]] = []

    def __reduce__(self):
        return self.ran.append, (1,)


def test_an_index_that_cannot_be_unpickled_is_made_anew(place):
    compile_and_call()
    (index,) = place.glob("*.nbi")
    made_by = sealed.read(index).partition(b"\n")[0]
    for content in (made_by + b"\nno pickle", made_by + b"\n" + pickle.dumps(3)):
        sealed.write(index, content)
        with pytest.warns(CacheWarning, match="is damaged"):
            compile_and_call()
    sealed.write(index, b"('0.1', ('0.1', '0.1'))\nof another compiler")
    assert compile_and_call().stats.cache_hits == {}
    assert sum(compile_and_call().stats.cache_hits.values()) == 1


def test_data_that_an_index_names_by_mistake_are_not_those_of_the_function(place):
    """As when another process has written the index and not yet the data."""
    dispatcher = compile_and_call()
    assert dispatcher(1) == 2
    (index,) = place.glob("*.nbi")
    made_by, _, names = sealed.read(index).partition(b"\n")
    (one, other), (first, second) = zip(*pickle.loads(names).items(), strict=True)  # noqa: S301  our own
    sealed.write(index, made_by + b"\n" + pickle.dumps({one: second, other: first}))
    assert compile_and_call().stats.cache_hits == {}


def test_it_is_for_its_owner_alone(place):
    before = os.umask(0)
    try:
        compile_and_call()
    finally:
        os.umask(before)
    assert {file.stat().st_mode & 0o777 for file in place.iterdir()} == {0o600}
    assert place.stat().st_mode & 0o777 == 0o700
    place.chmod(0o777)
    with pytest.raises(InputError, match=f"others may write to {place}"):
        compile_and_call()


def test_a_lock_is_no_link(place, tmp_path):
    (tmp_path / "precious").write_text("mine")
    place.mkdir(parents=True)
    turn = kernel_cache.Turn(place / "lock")
    turn.path.symlink_to(tmp_path / "precious")
    assert turn.take()
    assert (tmp_path / "precious").read_text() == "mine"


def test_a_place_that_cannot_be_made_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("HOTLAP_CACHE", str(tmp_path / "file"))
    compile_and_call()


@pytest.fixture
def other_process(place):
    """Takes the turn to compile, as another process would, and gives it back."""
    compile_and_call()
    (lock,) = place.glob("*.lock")
    turn = kernel_cache.Turn(lock)
    assert turn.take()
    return turn


def test_what_another_process_compiles_is_waited_for(place, other_process, monkeypatch):
    kept = {file: file.read_bytes() for file in place.iterdir()}
    for file in kept:
        if file.suffix != ".lock":
            file.unlink()
    waits = []

    def finish(_):
        """The other process is done while this one waits for the second time."""
        waits.append(1)
        if len(waits) == 2:
            for file, content in kept.items():
                file.write_bytes(content)
            other_process.give_back()

    monkeypatch.setattr(kernel_cache, "sleep", finish)
    assert sum(compile_and_call().stats.cache_hits.values()) == 1
    assert len(waits) == 2


@pytest.mark.parametrize("longest", [0.0, 1.0])
def test_a_process_that_never_finishes_is_not_waited_for_endlessly(place, other_process, monkeypatch, longest):
    assert not kernel_cache.Turn(other_process.path).take()
    waits = []
    monkeypatch.setattr(kernel_cache, "LONGEST_WAIT", longest)
    monkeypatch.setattr(kernel_cache, "sleep", waits.append)
    for file in place.glob("*.nb?"):
        file.unlink()
    assert compile_and_call().stats.cache_hits == {}
    assert sum(waits) <= longest


def test_the_turn_is_given_back_when_a_function_is_compiled_or_loaded(place):
    for _ in range(2):
        compile_and_call()
        (lock,) = place.glob("*.lock")
        other = kernel_cache.Turn(lock)
        assert other.take()
        other.give_back()

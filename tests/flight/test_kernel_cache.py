"""Compiled code is kept where only the same sources find it, and a cache that fails is no error."""

import numpy as np
import pytest
from numba import njit

from hotlap.flight import kernel_cache
from hotlap.system import disk_cache
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


def test_a_damaged_file_is_made_anew(place):
    compile_and_call()
    for file in place.iterdir():
        file.write_bytes(b"no kernel")
    assert compile_and_call().stats.cache_hits == {}


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

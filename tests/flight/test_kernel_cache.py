"""Compiled code is kept where only the same sources find it, and a cache that fails is no error."""

import numpy as np
import pytest
from numba import njit

from hotlap.flight import kernel_cache
from hotlap.system import disk_cache


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


def test_an_edited_source_is_another_place(tmp_path):
    source = tmp_path / "flight"
    source.mkdir()
    (source / "mpc.py").write_text("a = 1\n")
    before = disk_cache.digest_sources(source)
    disk_cache.digest_sources.cache_clear()
    (source / "mpc.py").write_text("a = 2\n")
    assert disk_cache.digest_sources(source) != before


def test_every_module_that_is_compiled_takes_part():
    assert {"hotlap.flight", "hotlap.dynamics"} <= set(kernel_cache.SOURCES)


def test_a_damaged_file_is_made_anew(place):
    compile_and_call()
    for file in place.iterdir():
        file.write_bytes(b"no kernel")
    assert compile_and_call().stats.cache_hits == {}


def test_a_place_that_cannot_be_made_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("HOTLAP_CACHE", str(tmp_path / "file"))
    compile_and_call()

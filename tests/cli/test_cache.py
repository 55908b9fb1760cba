"""`hotlap cache`: where caches lie, how large they are, and how they go."""

from __future__ import annotations

import pytest

from hotlap.cli.cache import written
from hotlap.system.disk_cache import folder


@pytest.fixture
def filled(here):
    (here / "cache" / "mine").mkdir(parents=True)
    (here / "cache" / "mine" / "precious.txt").write_text("not hotlap's")
    for kind in ("plans", "kernels"):
        folder(kind).mkdir(parents=True)
        (folder(kind) / "kept").write_bytes(bytes(1500))


@pytest.mark.usefixtures("filled")
def test_it_says_where_caches_lie_and_how_large_they_are(hotlap, here):
    assert hotlap("cache").out.startswith(f"{here / 'cache'}: 3 kB\n")
    document = hotlap("cache", "--json").document
    assert (document["folder"], document["bytes"], document["removed"]) == (str(here / "cache"), 3000, False)
    assert {kind["kind"]: kind["bytes"] for kind in document["kinds"]} == {"plans": 1500, "kernels": 1500, "digests": 0, "betaflight": 0}


@pytest.mark.usefixtures("filled")
def test_clear_removes_them_and_nothing_else(hotlap, here):
    ran = hotlap("cache", "--clear")
    assert (ran.code, ran.err) == (0, "")
    assert hotlap("cache", "--json").document["bytes"] == 0
    assert [path.name for path in (here / "cache").iterdir()] == ["mine"]
    assert hotlap("cache", "--clear").code == 0


def test_nothing_is_kept_where_nothing_was_done(hotlap, here):
    assert hotlap("cache", "--json").document["bytes"] == 0
    assert not (here / "cache").exists()


@pytest.mark.usefixtures("faked")
def test_whatever_is_kept_is_of_a_kind_that_is_known(hotlap, here):
    hotlap("check", "straight.toml", "--flights", "3")
    hotlap("cache", "--clear")
    assert list((here / "cache").rglob("*")) == []


@pytest.mark.parametrize(("size", "words"), [(0, "0 bytes"), (999, "999 bytes"), (1500, "1.5 kB"), (2.34e6, "2.34 MB"), (5e9, "5 GB")])
def test_sizes_are_for_people(size, words):
    assert written(size) == words

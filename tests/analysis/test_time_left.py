"""The time that is left of work whose pieces are of several kinds."""

from __future__ import annotations

import pytest

from hotlap.analysis.time_left import TimeLeft, in_words


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_it_is_known_when_a_piece_of_each_kind_is_done():
    clock = Clock()
    left = TimeLeft(["quick", "slow"] * 3, clock)
    clock.now = 1.0
    assert left.after("quick") == ""
    clock.now = 61.0
    assert left.after("slow") == "about 2 min left"
    assert left.seconds == 2 * 1 + 2 * 60


def test_one_slow_piece_does_not_change_what_is_expected_of_the_others():
    clock = Clock()
    left = TimeLeft(["slow"] * 10, clock)
    for taken in (10, 10, 100, 10, 10):
        clock.now += taken
        left.after("slow")
    assert left.seconds == 50


def test_at_the_end_nothing_is_left():
    left = TimeLeft(["one"], Clock())
    assert left.after("one") == ""
    assert left.seconds == 0


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(None, ""), (0.2, "about 1 s left"), (40, "about 40 s left"), (200, "about 3 min left"), (7200, "about 2.0 h left")],
)
def test_words(seconds, words):
    assert in_words(seconds) == words

"""What is said while a tuning goes on."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from hotlap.api.rates import Flown, Pace, Rate
from hotlap.api.wording import duration, percent
from hotlap.cli.output import finite, table, working
from hotlap.cli.progress import Lines, Tally, describe, follow, follow_pieces, follow_stages, pace
from hotlap.core.success_rate import Validation
from hotlap.tuning.candidate import Candidate


def candidate(**changes) -> Candidate:
    return Candidate(
        **{"parameters": np.ones((1, 5)), "cost": 3.14159, "completion": 0.5, "lap_time": 5.0, "flights": 1, "confirmed": False, **changes}
    )


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def test_logs_get_a_line_every_few_seconds_and_one_at_the_end(capsys):
    clock = Clock()
    lines = Lines(200, 40, clock)
    for flights in range(41, 61):
        clock.now += 1.0
        lines(
            SimpleNamespace(
                flights=flights, best=candidate(), failed_validations=(Validation(200, 100),) * (flights == 52), done=flights == 60
            )
        )  # pyright: ignore[reportArgumentType]
    said = capsys.readouterr().err.splitlines()
    assert said[0] == "45 of 200 flights, best so far: completion 50 %, cost 3.14, 1 flights/s"
    assert [line.partition(" ")[0] for line in said] == ["45", "50", "a", "55", "60"]
    assert said[2] == "a confirmed candidate held in 50 % of 200 flights only; the search goes on"


def test_a_rate_before_any_time_has_passed_is_none():
    assert Rate(0, Clock())(5) == "- flights/s"


def test_a_cost_that_is_infinite_is_left_out():
    assert describe(candidate(cost=float("inf"), completion=0.0)) == "completion 0 %"


@pytest.mark.parametrize(
    ("share", "text"), [(1.0, "100 %"), (0.0, "0 %"), (0.97, "97 %"), (0.9996, "99.96 %"), (0.0004, "0.04 %"), (1 / 3, "33.3 %")]
)
def test_percentages_are_never_rounded_to_all_or_nothing(share, text):
    assert percent(share) == text


def test_columns_line_up():
    assert table([("a", "1", "x"), ("bbb", "22", "")], right=[1], indent="  ") == ["  a     1  x", "  bbb  22"]


def test_numbers_that_json_does_not_have_become_null():
    assert finite({"a": [float("nan"), 1.0], "b": (float("inf"), "x"), "c": None}) == {"a": [None, 1.0], "b": [None, "x"], "c": None}


def test_runs_are_counted_and_said_now_and_then_and_at_the_end(capsys):
    clock = Clock()
    tally, run = Tally("runs", 4, 1, clock), SimpleNamespace(race="drop-20", tuner="cma_es:log", flights=30, validation=50)
    flown = Flown(clock)
    for clock.now in (1.0, 6.0, 8.0):
        tally.say(flown(run))
    assert capsys.readouterr().err.splitlines() == [
        "3 of 4 runs, now drop-20 by cma_es:log, 26.7 flights/s",
        "4 of 4 runs, now drop-20 by cma_es:log, 30 flights/s",
    ]


@pytest.mark.parametrize(("speed", "text"), [(None, "-/s"), (0.0, "-/s"), (12.345, "12.3/s"), (1.0, "1/s"), (0.05, "3/min")])
def test_slow_work_is_counted_by_the_minute(speed, text):
    assert pace(speed) == text


def test_a_terminal_gets_a_bar_with_rate_and_time_left(monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "120")
    with follow_pieces("runs", 4, 1) as say:
        say("circle-34")
        say("flip-16")
    shown = capsys.readouterr().err
    assert "runs" in shown
    assert "3/4" in shown
    assert "/s" in shown or "/min" in shown
    assert "flip-16" in shown


def test_a_stage_counts_when_the_next_one_begins(monkeypatch, capsys):
    with follow_stages(2) as say:
        say("compiling")
    assert capsys.readouterr().err == "compiling\n"
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "120")
    with follow_stages(2) as say:
        say("compiling")
        say("measuring [x]")
    shown = capsys.readouterr().err
    assert "1/2" in shown
    assert "2/2" not in shown
    assert "measuring [x]" in shown


def test_what_has_no_end_in_sight_gets_a_clock(monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    with working("planning [x]"):
        pass
    assert "planning [x] ..." in capsys.readouterr().err


def test_flights_of_simulators_are_counted_one_by_one_within_a_batch(capsys):
    """The first waits for its simulator for 10 s; each of the others takes 2 s. A failed validation counts as time, not as progress."""
    clock = Clock()
    lines = Lines(40, 4, clock)
    for clock.now in (10.0, 12.0, 14.0, 16.0, 18.0, 20.0):
        lines.flown(1)
    lines(SimpleNamespace(flights=6, best=candidate(), failed_validations=(), done=False))  # pyright: ignore[reportArgumentType]
    for clock.now in (22.0, 24.0, 26.0):
        lines.flown(1)
    assert capsys.readouterr().err.splitlines() == [
        "4 of 40 flights, 1 flown with all re-flights, 0.1 flights/s, at most 6 min left",
        "4 of 40 flights, 4 flown with all re-flights, 0.5 flights/s, at most 72 s left",
        "6 of 40 flights, best so far: completion 50 %, cost 3.14, 7 flown with all re-flights, 0.5 flights/s, at most 68 s left",
    ]


def test_a_terminal_shows_flights_of_simulators_while_their_batch_goes_on(monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "160")
    clock = Clock()
    monkeypatch.setattr("hotlap.cli.progress.FlightPace", lambda: Pace(clock))
    with follow(40, 4) as watch:
        for clock.now in (10.0, 12.0, 14.0):
            watch.flown(1)
        watch(SimpleNamespace(flights=6, best=candidate(), failed_validations=(), done=False))
    shown = capsys.readouterr().err
    assert "3 flown with all re-flights" in shown
    assert "0.5 flights/s" in shown
    assert "at most 68 s left" in shown
    assert "6/40" in shown


@pytest.mark.parametrize(("seconds", "text"), [(40.4, "40 s"), (99.9, "100 s"), (360.0, "6 min"), (9000.0, "2.5 h")])
def test_long_times_are_told_roughly(seconds, text):
    assert duration(seconds) == text

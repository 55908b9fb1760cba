"""Goals read as written, and met by the flights that they describe."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hotlap.core.errors import InputError
from hotlap.core.records import Scores
from hotlap.tuning.goal import Goal, Quantity, parse_goal
from hotlap.tuning.scoring import Metric


def scores(completion: list[float], mean_error: list[float], max_error: list[float]) -> Scores:
    flown = Scores.of_costs(np.full(len(completion), np.nan))
    return replace(flown, completion=np.array(completion), mean_error=np.array(mean_error), max_error=np.array(max_error))


FOUR = scores([1.0, 1.0, 0.95, 0.2], [0.2, 0.4, 0.1, 0.1], [0.9, 1.1, 0.5, 0.3])


@pytest.mark.parametrize(
    ("text", "met"),
    [
        ("completion=1", [True, True, False, False]),
        ("completion=0.95", [True, True, True, False]),
        ("completion>=0.95", [True, True, True, False]),
        ("mean_error<0.3", [True, False, False, False]),
        ("max_error < 1.0", [True, False, False, False]),
        ("none", [False, False, False, False]),
    ],
)
def test_a_goal_is_met_by_the_flights_that_it_describes(text, met):
    assert parse_goal(text).met(FOUR).tolist() == met


@pytest.mark.parametrize("text", ["completion=1", "completion=0.95", "mean_error<0.3", "max_error<1", "none", "mean_error<0.1234567"])
def test_a_goal_reads_back_as_it_is_written(text):
    assert str(parse_goal(text)) == text
    assert parse_goal(str(parse_goal(text))) == parse_goal(text)


def test_the_default_goal_is_every_gate():
    assert parse_goal("completion=1") == Goal() == Goal(Quantity.COMPLETION, 1.0)


def test_19_of_20_gates_are_a_completion_of_095():
    assert parse_goal("completion=0.95").met(scores([19 / 20, 18 / 20], [0, 0], [0, 0])).tolist() == [True, False]


def test_without_a_goal_complete_flights_succeed():
    assert parse_goal("none").succeeded(FOUR).tolist() == [True, True, False, False]
    assert parse_goal("mean_error<0.3").succeeded(FOUR).tolist() == [True, False, False, False]


def test_an_error_goal_is_led_to_by_the_error():
    assert [parse_goal(text).metric for text in ("completion=1", "none", "mean_error<1", "max_error<1")] == [
        Metric.TIME,
        Metric.TIME,
        Metric.MEAN_ERROR,
        Metric.MEAN_ERROR,
    ]


@pytest.mark.parametrize(
    "text",
    ["", "completion", "completion=", "completion=95", "completion=0", "completion<1", "mean_error=0.3", "mean_error<-1", "mean_error<nan",
     "mean_error<1e999", "max_error>1", "lap_time<9", "none=1", "completion=1=1", "completion=1..0", "mean_error<."],
)  # fmt: skip
def test_what_is_no_goal_is_refused_in_one_line(text):
    with pytest.raises(InputError, match=r"^goal: ") as refused:
        parse_goal(text)
    assert "\n" not in str(refused.value)

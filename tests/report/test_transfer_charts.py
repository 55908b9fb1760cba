"""Charts and article of a transfer: they show what was flown, whatever became of it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from hotlap.analysis.transfer import TransferFlight, metres, rows_of
from hotlap.report.transfer_article import cells_of, changes, compose_article, endings
from hotlap.report.transfer_charts import draw_transfer, error_boxes, error_over_time


def flight(world: str, label: str, errors, *, complete: bool = True, seed: int = 0) -> TransferFlight:
    """A flight with given errors, ten milliseconds apart."""
    errors = np.array(errors, dtype=np.float64)
    mean, most = (float(errors.mean()), float(errors.max())) if len(errors) else (math.nan, math.nan)
    lap, ending = (5.0, "all 3 gates") if complete else (math.nan, "missed gate 2")
    times = 0.01 * np.arange(len(errors))
    return TransferFlight(world, label, seed, 1.0 if complete else 0.3, lap, mean, most, ending, 0.01 * len(errors), times, errors)


def rows_with(crash: float = 0.0):
    """Two worlds; abroad the default parameters crash at an error [m], unless that is 0."""
    ramp = np.linspace(0, 1, 101)
    abroad = np.append(ramp, crash) if crash else 1.2 * ramp
    flights = [
        *(flight("home", "default", ramp, seed=seed) for seed in range(3)),
        *(flight("home", "tuned", 0.5 * ramp, seed=seed) for seed in range(3)),
        *(flight("abroad", "default", abroad, complete=not crash, seed=seed) for seed in range(3)),
        *(flight("abroad", "tuned", 0.6 * ramp, seed=seed) for seed in range(3)),
    ]
    return rows_of(flights)


def test_a_flight_is_kept_and_read_again():
    for one in (flight("home", "tuned", [0.1, 0.2]), flight("home", "tuned", [], complete=False)):
        again = TransferFlight.load(one.dump())
        assert again.dump() == one.dump()
        assert again.complete == one.complete
        np.testing.assert_array_equal(again.lap_time, one.lap_time)


def test_the_charts_reach_as_far_as_the_errors():
    for chart in (error_boxes("circle", rows_with()), error_over_time("circle", rows_with())):
        assert all(axes.get_ylim() == pytest.approx((0, 1.05 * 1.2)) for axes in chart.get_axes())


def test_a_crash_does_not_make_flights_flat_that_are_complete():
    for chart in (error_boxes("circle", rows_with(crash=200)), error_over_time("circle", rows_with(crash=200))):
        assert all(axes.get_ylim() == pytest.approx((0, 1.05 * 3)) for axes in chart.get_axes())
    texts = {text.get_text() for text in error_boxes("circle", rows_with(crash=200)).get_axes()[0].texts}
    assert "200.00" in texts


def test_there_is_a_line_for_each_flight_and_a_cross_for_each_that_failed():
    home, abroad = error_over_time("circle", rows_with(crash=4)).get_axes()
    assert len(home.lines) == 6
    assert len(abroad.lines) == 9
    assert sum(line.get_marker() == "x" for line in abroad.lines) == 3


def test_medians_stand_beside_their_boxes():
    texts = [text.get_text() for text in error_boxes("circle", rows_with()).get_axes()[0].texts]
    assert texts == ["0.50", "0.25", "0.60", "0.30"]


def test_flights_that_ended_at_once_can_be_drawn(tmp_path):
    rows = rows_of([flight("home", "default", [], complete=False), flight("home", "tuned", [], complete=False)])
    assert all(path.stat().st_size for path in draw_transfer(tmp_path, "circle", rows))
    assert cells_of(rows)[0] == ["home", "default", "0 of 1", "-", "-", "-"]


def test_errors_are_compared_where_all_flights_are_complete():
    home, abroad = changes(rows_with(crash=4))
    assert home == "home: tuned against default, mean error -50 %, largest error after 1 s -50 % (means of the flights)"
    assert abroad == "abroad: 3 of 3 flights pass every gate when tuned, 0 of 3 with the default parameters"
    assert list(endings(rows_with(crash=4))) == [["abroad", "default", "3 missed gate 2"]]


def test_the_largest_error_is_not_that_of_the_start_which_the_noise_draws():
    begun = flight("home", "tuned", [0.9, 0.8, 0.2, 0.3], complete=True)
    begun = replace(begun, times=np.array([0.0, 0.9, 1.0, 1.5]))
    assert begun.later_error == 0.3
    assert cells_of(rows_of([begun]))[0][4] == "0.30"
    assert replace(begun, times=np.array([0.0, 0.1, 0.2, 0.3])).later_error == 0.9, "one that ended before is all start"


def test_table_and_chart_round_an_error_once():
    """10.084989 m, kept as 10.085, was 10.08 in one and 10.09 in the other."""
    calm = flight("home", "default", [0.1, 0.1, 0.1], complete=True)
    lost = replace(flight("home", "tuned", [0.1, 0.1, 10.085], complete=False), max_error=10.084989)
    lost, calm = (replace(one, times=np.array([0.0, 1.0, 2.0])) for one in (lost, calm))
    rows = rows_of([calm, lost])
    drawn = [text.get_text() for text in error_boxes("circle", rows).get_axes()[0].texts]
    assert cells_of(rows)[1][4] in drawn


def test_many_flights_have_a_mean_and_a_range():
    rows = rows_of([flight("home", "tuned", [0.2 + 0.1 * seed], seed=seed) for seed in range(6)])
    assert cells_of(rows) == [["home", "tuned", "6 of 6", "0.45 (0.20 to 0.70)", "0.45 (0.20 to 0.70)", "5.00"]]


def test_the_article_names_all_worlds():
    text = compose_article("circle", rows_with(), (), "").markdown
    assert "flown in home and abroad with the same noise, 3 flights each" in text


def test_the_article_says_of_laps_what_they_are():
    tuned = (replace(flight("home", "tuned", [0.1], seed=seed), lap_time=lap) for seed, lap in enumerate((5.0, 5.0, 8.0)))
    rows = rows_of([*tuned, *rows_with()[2].flights])
    assert cells_of(rows)[0][5] == "6.00", "their mean, not their median"
    assert "*lap*: the mean of the flights that passed all gates" in compose_article("circle", rows, (), "").markdown


@pytest.mark.parametrize(("error", "words"), [(0.694, "0.69"), (0.0254, "0.025"), (math.nan, "-")])
def test_errors_for_people(error, words):
    assert metres(error) == words

"""Pictures of a comparison show every race and every tuner, also one that never succeeds."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hotlap.analysis.comparison import Run
from hotlap.core.errors import InputError
from hotlap.report.comparison import BAND_UP_TO, curves, draw_comparison, profile


def make_run(tuner: str, race: str, seed: int, *, confirmed: bool = True) -> Run:
    flights = 10 * (seed + 1)
    curve = ((1, 0.2), (flights, 1.0 if confirmed else 0.5))
    spent = {"budget": 200, "flights": flights, "search_flights": flights, "confirmed": confirmed, "successes": 40, "validation": 50}
    worth = {"completion": curve[-1][1], "cost": 5.0, "lap_time": 5.0 if confirmed else math.nan, "tuner_time": 0.1, "curve": curve}
    return Run(race=race, tuner=tuner, seed=seed, **spent, **worth)


def make_runs(tuners: int, races: int) -> list[Run]:
    names = [f"algorithm{k // 3}:preset{k}" for k in range(tuners)]
    return [make_run(name, f"race-{r}", seed, confirmed=k > 0) for k, name in enumerate(names) for r in range(races) for seed in range(3)]


@pytest.mark.check
@pytest.mark.parametrize(("tuners", "races"), [(1, 1), (4, 2), (9, 5), (30, 14)])
def test_every_race_has_a_chart_and_every_tuner_a_line_of_its_own_look(tuners, races):
    figure = curves(make_runs(tuners, races))
    charts = [axes for axes in figure.axes if axes.get_title(loc="left").startswith("race-")]
    assert [axes.get_title(loc="left") for axes in charts] == [f"race-{k}" for k in range(races)]
    for axes in charts:
        assert len(axes.lines) == tuners
        assert len(axes.collections) == (tuners if tuners <= BAND_UP_TO else 0)
    written = [text.get_text() for text in figure.texts]
    assert sum(text.startswith("algorithm") for text in written) == tuners
    looks = {(line.get_color(), str(line.get_linestyle()), str(line._unscaled_dash_pattern)) for line in charts[0].lines}  # type: ignore[attr-defined]
    assert len(looks) == tuners or tuners > 7


def test_charts_and_key_do_not_overlap():
    figure = curves(make_runs(9, 5))
    boxes = [axes.get_position() for axes in figure.axes]
    for i, one in enumerate(boxes):
        assert one.x0 >= 0
        assert one.y0 >= 0
        assert one.x1 <= 1
        assert one.y1 <= 1
        assert not any(one.overlaps(other) for other in boxes[i + 1 :])


def test_a_profile_ends_with_the_share_that_was_solved():
    figure = profile(make_runs(3, 2))
    ends = {line.get_label(): np.asarray(line.get_ydata())[-1] for line in figure.axes[0].lines}
    assert ends == {"algorithm0:preset0": 0.0, "algorithm0:preset1": 100.0, "algorithm0:preset2": 100.0}


def test_pictures_are_files_and_a_folder_that_is_not_there_is_said(tmp_path):
    paths = draw_comparison(tmp_path, make_runs(2, 1))
    assert [path.name for path in paths] == ["curves.png", "profile.png"]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in paths)
    with pytest.raises(InputError, match="nowhere"):
        draw_comparison(tmp_path / "nowhere", make_runs(2, 1))

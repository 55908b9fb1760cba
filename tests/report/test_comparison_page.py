"""Parts of the page of a comparison: looks that can be told apart, lines side by side, maps and charts that say what the runs say."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest

from comparisons import LONG, TUNERS, make_comparison, make_run
from hotlap.analysis.comparison_table import rows_of
from hotlap.report.comparison_article import compose_article
from hotlap.report.comparison_charts import Axes, curve_chart, profile_chart, style_of
from hotlap.report.comparison_curves import MOST, curves_of
from hotlap.report.comparison_heat import heat_maps
from hotlap.report.comparison_looks import DARK, DASHES, LIGHT, looks_of
from hotlap.report.scripts import load_script


def luminance(colour: str) -> float:
    """Relative luminance of #rrggbb (WCAG 2)."""
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return float(np.dot(linear, (0.2126, 0.7152, 0.0722)))


@pytest.mark.parametrize(("colours", "paper"), [(LIGHT, "#ffffff"), (DARK, "#14181d")])
def test_every_line_stands_out_from_its_paper(colours, paper):
    for colour in colours:
        light, dark = sorted((luminance(colour), luminance(paper)), reverse=True)
        assert (light + 0.05) / (dark + 0.05) >= 3, colour


@pytest.mark.parametrize("algorithms", [1, 4, 7, 9, 14])
@pytest.mark.parametrize("presets", [1, 2])
def test_tuners_are_told_apart_by_colour_and_dashes(algorithms, presets):
    names = [f"algorithm{a}:preset{p}" for a in range(algorithms) for p in range(presets)]
    looks = looks_of(names)
    assert len(set(looks.values())) == len(names) <= len(LIGHT) * len(DASHES)
    if algorithms <= len(DASHES) and presets == 1:
        assert len({look.dashes for look in looks.values()}) == algorithms, "dashes alone are enough, where colours are not seen"


def test_lines_that_coincide_lie_side_by_side_and_others_where_they_belong():
    alike = curves_of("all alike", make_comparison())
    differing = curves_of("r", [make_run(f"t{k}", "r", 0, curve=((1, 0.1), (5, 0.2 * (k + 1)))) for k in range(4)])
    for column in alike.shifts.T:
        assert sorted(np.diff(column)) == pytest.approx([-1.0, -1.0, -1.0]), "the first on top"
        assert column.sum() == pytest.approx(0)
    assert differing.shifts[:, :4].any(axis=0).all()
    assert not differing.shifts[:, 4:].any()
    many = curves_of("r", [make_run(f"t{k}", "r", 0) for k in range(30)])
    assert np.abs(many.shifts).max() == MOST
    assert all(len(set(column)) == 30 for column in many.shifts.T)


def test_a_curve_begins_with_the_first_guess_and_ends_with_the_budget():
    curves = curves_of("r", [make_run("a", "r", 0, budget=50), make_run("b", "r", 0, budget=200)])
    assert (curves.flights[0], curves.flights[-1]) == (1, 200)
    assert curves.middle[:, 0].tolist() == [0.2, 0.2]
    assert np.isnan(curves.middle[0][curves.flights > 50]).all()
    assert np.isfinite(curves.middle[1]).all()


def test_a_chart_draws_each_tuner_within_its_frame_and_says_what_its_axes_are():
    runs = make_comparison()
    looks = looks_of(TUNERS)
    axes = Axes(262, 130, 200)
    for chart in (curve_chart(curves_of("all differ", runs), looks), profile_chart(runs, looks)):
        paths = re.findall(r'<path d="(M[^"]*)" class="line t\d" data-tuner="(t\d)" data-steps="', chart)
        assert [tuner for _, tuner in paths] == ["t0", "t1", "t2", "t3"]
        assert all(re.fullmatch(r"M[\d.]+ [\d.]+(H[\d.]+(V[\d.]+)?)+", path) for path, _ in paths), "steps alone"
        assert chart.count('class="name"') == 2
    curve = curve_chart(curves_of("all differ", runs), looks)
    (first,) = re.findall(r'<path d="M([\d.]+) ([\d.]+)[^"]*" class="line t0"', curve)
    assert float(first[0]) == axes.x(1) == axes.LEFT
    assert float(first[1]) == pytest.approx(axes.y(0.1), abs=8)


def test_a_map_has_a_cell_for_each_race_and_tuner_and_the_best_is_the_darkest():
    maps = heat_maps(rows_of(make_comparison()))
    assert re.findall(r'data-measure="(\w+)"', maps) == ["validated", "confirmed", "flights"]
    for shown in maps.split("<figure")[1:]:
        assert shown.count("<tr>") == 1 + 3
        assert shown.count("<td") == 3 * 4
    rows = re.findall(r"<tr>(.*?)</tr>", maps.split("<figure")[3])
    flights = next(row for row in rows if "all differ" in row)
    heat = [int(value) for value in re.findall(r"--heat: (\d+)%", flights)]
    assert heat[0] == 100
    assert all(before > after for before, after in pairwise(heat))
    assert next(row for row in rows if LONG in row).count("<td>-</td>") == 2


def test_the_page_has_one_key_and_a_dark_form_and_escapes_names():
    page = compose_article([make_run("a<b:c", "r&s", 0), make_run("d:e", "r&s", 0)], "runs.jsonl", "hotlap compare").html
    assert page.count('class="legend"') == 1
    assert "a<b" not in page
    assert "r&s" not in page
    style = style_of(looks_of(TUNERS))
    assert all(f"--c0: {colours[0]}" in style for colours in (LIGHT, DARK))
    assert "@media screen and (prefers-color-scheme: dark)" in style


def test_a_comparison_without_a_command_does_not_name_one():
    assert "Run it again" not in compose_article([make_run("a:b", "r", 0)], "runs.jsonl", "").html


def test_scripts_cannot_end_their_element():
    assert "</" not in load_script("tables", "comparison")


def test_a_line_says_the_values_of_its_curve_wherever_they_change():
    curves = curves_of("r", [make_run("a", "r", 0, budget=60, curve=((1, 0.25), (7, 1.0)))])
    [line] = re.findall(r'<path[^>]*class="line[^>]*>', curve_chart(curves, looks_of(["a"])))
    assert re.search('data-steps="([^"]*)"', line)[1] == "1 25 25 25;7 100 100 100"
    assert re.search('data-end="([^"]*)"', line)[1] == "60"
    assert re.findall('data-steps="1 [0-9]', profile_chart([make_run("a", "r", 0)], looks_of(["a"])))

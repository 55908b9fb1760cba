"""The map of a track with openings shows which way each gate is passed, every obstacle and the box, at any size."""

from __future__ import annotations

import math
import re

import pytest

from hall import HALL, make_hall, scaled
from hotlap.race.track import Track
from hotlap.report.map import draw_map, draw_track
from hotlap.report.map_marks import HEADS
from hotlap.report.structures import structures_of

DOT = re.compile("[\u2801-\u28ff]")


def straight(*gates, **changes) -> Track:
    """Along x, from 0 to 40 m."""
    return Track.model_validate({"name": "straight", "start": (0.0, 0.0, 5.0), "end": (40.0, 0.0, 5.0), "gates": gates, **changes})


def views(track: Track, **options) -> tuple[list[str], list[str]]:
    """Lines of both views, one below the other, without the legend."""
    lines = draw_track(track, width=80, height=40, **options).splitlines()
    titles = [k for k, line in enumerate(lines) if line.startswith("from ")]
    end = next((k for k, line in enumerate(lines) if line.startswith("S start")), len(lines))
    return lines[titles[0] + 1 : titles[1]], lines[titles[1] + 1 : end]


def find(lines: list[str], mark: str) -> tuple[int, int]:
    """Row and column of a mark that is there once."""
    ((row, column),) = [(row, line.index(mark)) for row, line in enumerate(lines) if mark in line]
    return row, column


def dots(lines: list[str], row: int, column: int) -> bool:
    """Whether something is drawn in a cell."""
    return 0 <= row < len(lines) and column < len(lines[row]) and bool(DOT.match(lines[row][column]))


def test_a_gate_that_faces_the_way_is_drawn_across_it_in_both_views():
    track = straight({"position": (20.0, 0.0, 5.0), "yaw": 0.0, "side": 6.0}, boxes=[{"low": (5.0, -8.0, 0.0), "high": (6.0, 8.0, 10.0)}])
    for lines in views(track):
        row, column = find(lines, "→")
        assert all(dots(lines, row + step, column) for step in (-1, 1))
        assert not dots(lines, row + 1, column + 2)


@pytest.mark.parametrize("eighth", range(8))
@pytest.mark.parametrize("direction", ["forward", "backward", "either"])
def test_the_arrow_head_shows_the_way_in_which_a_gate_is_passed(eighth, direction):
    gate = {"position": (20.0, 0.0, 5.0), "yaw": eighth * math.pi / 4, "side": 2.0, "direction": direction}
    above, _ = views(straight(gate))
    text = "".join(above)
    if direction == "either":
        assert "o" in text
        assert not set(text) & set(HEADS)
    else:
        assert set(text) & set(HEADS) == {HEADS[(eighth + (4 if direction == "backward" else 0)) % 8]}


def test_a_gate_that_lies_flat_has_its_arrow_in_the_view_from_the_side():
    above, side = views(straight({"position": (20.0, 0.0, 5.0), "yaw": 0.0, "pitch": math.pi / 2, "side": 2.0}))
    assert not set("".join(above)) & set(HEADS)
    assert set("".join(side)) & set(HEADS) == {"↓"}


@pytest.mark.parametrize("kind", ["poles", "spheres", "boxes"])
def test_every_obstacle_appears_in_both_views(kind):
    for k in range(len(getattr(HALL, kind))):
        kept = tuple(one for i, one in enumerate(getattr(HALL, kind)) if i != k)
        for whole, less in zip(views(HALL), views(HALL.model_copy(update={kind: kept})), strict=True):
            assert whole != less


def test_the_legend_names_what_is_drawn_and_nothing_else():
    full = draw_track(HALL)
    for words in ("S start", "o gate", "→ gate with its direction", "opening", "ball", "+ point", "obstacle", "box, floor, ceiling"):
        assert words in full
    empty = draw_track(straight({"position": (20.0, 0.0, 5.0), "yaw": 0.0, "side": 2.0}))
    for words in ("o gate", "ball", "+ point", "obstacle", "dotted"):
        assert words not in empty


def test_a_track_of_bare_points_has_a_map_of_points_without_a_legend():
    track = straight((20.0, 0.0, 5.0), (30.0, 4.0, 5.0), floor=0.0)
    drawn = draw_track(track)
    assert "start" not in drawn
    assert drawn.count("o") - drawn.count("from") == 2 * 2 + drawn.count("above")
    assert set("".join("".join(view) for view in views(track))) & set(HEADS) == set()


@pytest.mark.parametrize("factor", [0.2, 10.0, 1000.0])
def test_a_track_of_another_size_has_the_same_map(factor):
    assert views(scaled(HALL, factor)) == views(HALL)


def test_a_small_gate_on_a_long_track_has_a_bar_that_can_be_seen():
    tiny, small = (straight({"position": (20.0, 0.0, 5.0), "yaw": 0.0, "side": side}) for side in (1e-3, 0.5))
    assert views(tiny) == views(small)
    row, column = find(views(tiny)[0], "→")
    assert any(dots(views(tiny)[0], row + step, column) for step in (-1, 1))


def test_laps_are_drawn_once_and_numbered_as_messages_name_their_gates():
    twice, once = ("".join(views(HALL.model_copy(update={"laps": laps}))[0]) for laps in (2, 1))
    assert twice.count("→") == once.count("→")
    numbers = [[int(found) for found in re.findall("[0-9]+", text)] for text in (twice, once)]
    assert sorted(numbers[0]) == sorted(numbers[1]) == list(range(1, len(HALL.gates)))


def test_a_plan_is_drawn_with_what_stands_on_its_track():
    scenario = make_hall()
    known = structures_of(scenario.race.track, scenario.race.judge.distance)
    asked = (scenario.reference, scenario.race.track.gate_positions, scenario.segments)
    for size in ({"width": 78, "height": 22}, {"width": 40, "height": 10}):
        lines = draw_map(*asked, structures=known, **size).splitlines()
        assert max(map(len, lines)) <= size["width"]
        assert lines.index("") <= size["height"]
    text = draw_map(*asked, structures=known, colour=True)
    assert all(words in text for words in ("→", "↓", "S start"))
    assert "\x1b" in text

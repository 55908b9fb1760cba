"""`hotlap.score`: the log of a flight, judged and shown beside simulated ones."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest

import hotlap
from docs.test_json import documented, keys_of
from flight.scenarios import TUNED, make_scenario
from hotlap.api import scored
from hotlap.api.flown import write_log
from hotlap.api.scoring import score
from hotlap.cli import main
from hotlap.core.errors import InputError
from hotlap.worlds.built_in import BuiltIn

SCENARIO = make_scenario(noise={"thrust": 0.05, "rates": 0.2, "position": 0.05, "velocity": 0.05, "attitude": 0.01})


@pytest.fixture(scope="module")
def flown():
    return BuiltIn().fly(SCENARIO, np.tile(TUNED, (1, 2, 1)), np.array([7]), log=[0])


@pytest.fixture
def there(tmp_path, monkeypatch, flown):
    """A working folder with the log of a flight, and a race that needs no plan."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(scored, "make_scenario", lambda race, asked: SCENARIO)
    write_log(tmp_path / "flight.csv", flown.logs[0])
    return tmp_path


@pytest.mark.usefixtures("there")
def test_a_score_says_what_the_world_has_said(flown):
    result = hotlap.score("flight.csv", race="circle-34", flights=5, parameters=np.array(TUNED))
    assert result.scores.complete[0]
    assert result.scores.lap_time[0] == pytest.approx(flown.lap_time[0], abs=1e-6)
    assert result.scores.mean_error[0] == pytest.approx(flown.mean_error[0], abs=1e-4)
    assert len(result.simulated) == 5
    assert result.complete.successes >= 4
    assert result.efforts[0].rate_activity == pytest.approx(result.efforts[1].rate_activity, rel=1.0)
    assert len(result.rows()) == len(flown.gate_positions)
    assert repr(result).startswith("<ScoredFlight circle-34: flight.csv, a flight of hotlap")
    assert len(repr(result)) < 600
    assert result._repr_html_().startswith("<table>")


@pytest.mark.usefixtures("there")
def test_json_has_the_keys_that_are_documented(capsys):
    assert main(["score", "flight.csv", "--race", "circle-34", "--flights", "2", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert documented()["score"] <= keys_of(document)
    assert document["completion"] == 1


@pytest.mark.usefixtures("there")
def test_text_shows_flown_beside_simulated(capsys):
    assert main(["score", "flight.csv", "--race", "circle-34", "--flights", "2"]) == 0
    out = capsys.readouterr().out
    assert re.search(r"^ +gates +5 of 5 +all in", out, re.MULTILINE)
    assert "note: thrust command 1 is" in out


@pytest.mark.check
def test_a_page_is_one_file_with_its_pictures(there):
    result = score("flight.csv", race="circle-34", flights=2, out="page.html", align=True)
    html = (there / "page.html").read_text()
    assert result.page is not None
    assert html.count('<img src="data:image/png') == 3
    assert "hotlap score flight.csv --race circle-34 --align" in html
    assert "Gate by gate" in html
    assert not re.search(r'(src|href)="https?:', html)


def test_a_table_of_ones_own_needs_a_map(there, flown, capsys):
    record = flown.logs[0]
    rows = ["at,X,Y,Z", *(",".join(map(repr, row)) for row in np.column_stack([record.times, record.states[:, :3]]).tolist())]
    (there / "mine.csv").write_text("\n".join(rows) + "\n")
    (there / "map.toml").write_text('time = "at"\nposition = ["X", "Y", "Z"]\n')
    assert main(["score", "mine.csv", "--race", "circle-34"]) == 2
    assert "say which with a key map (--map)" in capsys.readouterr().err
    result = score("mine.csv", race="circle-34", map="map.toml", start=0.0, flights=2)
    assert result.scores.complete[0]
    assert math.isnan(result.efforts[0].frequency) or result.efforts[0].rate_activity == 0
    (there / "map.toml").write_text('tiem = "at"\n')
    with pytest.raises(InputError, match=r"map.toml: tiem: there is no signal named 'tiem' \(did you mean time\?\)"):
        score("mine.csv", race="circle-34", map="map.toml")


@pytest.mark.usefixtures("there")
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nothing.ulg", "--race", "circle-34"], "nothing.ulg: there is no such file"),
        (["flight.csv"], "--race: is missing; see hotlap score --help"),
        (["flight.csv", "--race", "circle-34", "--start", "soon"], "--start: must be a number, not 'soon'"),
        (["flight.csv", "--race", "circle-34", "--start", "900"], "--start: must be from 0.00 to"),
        (["flight.csv", "--race", "circle-34", "--from", "900"], "--from: leaves nothing of flight.csv, which is from 0.00 to"),
        (["flight.csv", "--race", "circle-34", "--out", "page.pdf"], "page.pdf: must end with .html, .htm"),
        (["flight.csv", "--race", "circle-34", "--flights", "0"], "--flights: must be from 1 to"),
    ],
)
def test_a_mistake_is_one_line(capsys, words, said):
    assert main(["score", *words]) == 2
    assert capsys.readouterr().err.splitlines()[-1].startswith(f"hotlap: {said}")


def test_a_log_without_places_is_asked_for_them(there, capsys):
    (there / "gyro.csv").write_text("t,wx,wy,wz\n" + "\n".join(f"{k},0,0,0" for k in range(9)) + "\n")
    assert main(["score", "gyro.csv", "--race", "circle-34"]) == 2
    assert "has no position, which the judge of a race needs" in capsys.readouterr().err

"""`hotlap.lap`: the same from Python, over a link without a protocol."""

from __future__ import annotations

import re

import numpy as np
import pytest
from matplotlib.figure import Figure

import hotlap
from hotlap.api import lapped
from hotlap.core.errors import InputError
from hotlap.real_flight import flight as flight_loop
from hotlap.real_flight import stream
from real_flight.hangar import DirectLink, make_drone, make_scenario

SCENARIO = make_scenario()
PARAMETERS = SCENARIO.space.first_guess(1)


@pytest.fixture
def link(tmp_path, monkeypatch):
    """The vehicle that is opened, whatever it is called: it hovers at the start."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(lapped, "make_scenario", lambda race, asked: SCENARIO)
    monkeypatch.setattr(stream, "STOPPING", 0.05)
    for name, short in {"MEETING": 0.2, "IDLE": 0.2, "STEADY_FOR": 1.0}.items():
        monkeypatch.setattr(flight_loop, name, short)
    drone = make_drone(SCENARIO)
    drone.hover(SCENARIO.reference.position[0])
    made = DirectLink(drone)
    monkeypatch.setattr(lapped, "open_link", lambda name, period, *, mute: made)
    return made


def lap(**options):
    return hotlap.lap(SCENARIO.race, parameters=PARAMETERS[0], on="a stand-in", rehearsal=False, **options)


def test_a_lap_can_be_looked_at(link, capsys):
    result = lap(log="flight.csv", progress=False)
    assert capsys.readouterr() == ("", "")
    assert re.match(r"<LapResult arc: flown on a stand-in: 3 of 3; 2\.90 s; 0\.\d\d m from the reference", repr(result))
    assert len(repr(result)) < 400
    assert result._repr_html_().startswith("<table>")
    assert [row["gate"] for row in result.rows()] == ["gate 1", "gate 2", "gate 3"]
    assert all(row["distance"] < 0.6 for row in result.rows())
    assert isinstance(result.plot(), Figure)
    assert (result.stopped, result.to_dict()["log"]) == ("", "flight.csv")
    assert link.closed


def test_a_lap_that_was_cut_short_says_where(link):
    link._script = lambda each: setattr(each, "states", not any((one.race_time or 0.0) > 1.8 for _, one, _ in each.sent))
    result = lap(log="flight.csv", progress=False)
    assert (result.to_dict()["stopped"], result.to_dict()["phase"]) == ("stale", "race")
    assert re.match(r"1 of 3: the log ends 1\.\d\d s after the start, before gate 2", result.facts()["gates"])
    assert [row["passed"] for row in result.rows()] == [True, False, False]


def test_a_lap_that_never_began_the_race_has_nothing_to_judge(link):
    link._script = lambda each: setattr(each, "states", len(each.sent) < 60)
    result = lap(log="flight.csv", progress=False)
    assert (result.flights, result.scores, result.rows()) == (None, None, [])
    assert "too old" in result.stopped
    assert result.to_dict()["completion"] is None
    with pytest.raises(InputError, match="there is no flight to draw"):
        result.plot()


def test_a_vehicle_that_fell_ill_on_a_dry_run_is_one_line(link):
    link._script = lambda each: setattr(each, "states", each.drone.time < 0.5)
    with pytest.raises(InputError, match="on: direct: the state is too old"):
        lap(dry_run=True, progress=False)


@pytest.mark.usefixtures("link")
@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"throttle_curve": 2.0}, "throttle_curve: must be from 0 to 1, not 2"),
        ({"wait": -1.0}, "wait: must be above 0, not -1"),
        ({"on_stop": "engage"}, "on_stop: must be one of land, hold, disarm, not 'engage'"),
        ({"log": "no/such/folder.csv"}, "cannot be written: there is no folder"),
    ],
)
def test_what_makes_no_sense_is_refused(options, reason):
    with pytest.raises(InputError, match=reason):
        lap(**options)


@pytest.mark.usefixtures("link")
def test_parameters_of_another_shape_are_refused():
    with pytest.raises(InputError, match=r"parameters: must have shape \(1, 5\) or \(5,\), not \(3,\)"):
        hotlap.lap(SCENARIO.race, parameters=np.ones(3), on="a stand-in", rehearsal=False)

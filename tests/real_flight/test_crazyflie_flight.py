"""Flights of a Crazyflie: cflib itself, over UDP on loopback, against a stand-in that owns the clock."""

from __future__ import annotations

import json
import re
import sys
from importlib.util import find_spec

import numpy as np
import pytest

from hotlap.api import lapped, scored
from hotlap.cli import main
from hotlap.core.errors import InputError
from hotlap.files.descriptions import save_parameters
from hotlap.files.parameters_file import SavedParameters
from hotlap.real_flight import flight as flight_loop
from hotlap.real_flight import open_link
from hotlap.real_flight.crazyflie import onboard, vehicle
from hotlap.real_flight.flight import RealFlight
from hotlap.real_flight.guard import Reason
from hotlap.real_flight.link import LinkError
from hotlap.real_flight.settings import FlightSettings, Phase
from real_flight.crazyflies import PERIOD, SCENARIO, name_of, serving, until

pytestmark = pytest.mark.skipif(find_spec("cflib") is None, reason="needs cflib")


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """Nobody waits for long."""
    for name, short in {"MEETING": 0.2, "STEADY_FOR": 0.3, "IDLE": 0.2, "REFUSING": 0.5}.items():
        monkeypatch.setattr(flight_loop, name, short)
    monkeypatch.setattr(onboard, "STILL_FLYING", 0.3)


def fly(stand_in, *options, say=lambda _: None, **settings):
    link = open_link(name_of(stand_in, *options), PERIOD)
    return RealFlight(link, SCENARIO, SCENARIO.space.first_guess(1), FlightSettings(wait=20.0, **settings), say).fly()


def away(stand_in, begun):
    """Largest distance of the true path from the reference's [m]."""
    path = [(moment - begun, state[:3]) for moment, state in stand_in.path if begun <= moment <= begun + SCENARIO.reference.duration]
    times, places = np.array([moment for moment, _ in path]), np.array([place for _, place in path])
    return float(np.linalg.norm(places - SCENARIO.reference.position_at(times), axis=1).max())


def check(stand_in, flown):
    """A flight that went to its end."""
    assert (flown.halt, flown.phase, stand_in.board.drone.crashed) == (None, Phase.LAND, False)
    assert stand_in.board.drone.on_ground
    assert away(stand_in, flown.record.race_begun) < 0.3
    assert np.isnan(flown.gain)  # nobody asked for it
    for moment, state, aim in stand_in.setpoints:
        assert not flown.geofence.outside(state[:3]), moment
        assert not flown.geofence.outside(aim.position), moment


@pytest.mark.check
def test_a_lap_of_full_states_from_the_ground():
    with serving(noise=0.003) as stand_in:
        flown = fly(stand_in, arm=True)
        check(stand_in, flown)
    begun = flown.record.race_begun
    assert [what for _, what in stand_in.requests] == ["arm", "land", "give way", "disarm"]
    racing = [moment for moment, _, _ in stand_in.setpoints if begun < moment < begun + SCENARIO.reference.duration]
    assert len(racing) > 0.9 * SCENARIO.reference.duration / PERIOD
    first = flown.record.orders[[order.race_time is not None for order in flown.record.orders].index(True)]
    assert first.thrust == pytest.approx(SCENARIO.reference.thrust[0], rel=0.05)  # of the plan: whoever commands is not ours


def test_a_process_that_dies_in_flight_stops_it_and_is_no_part_of_hotlap():
    links = []

    def kill(stand_in):
        if len(stand_in.setpoints) == 20:
            links[0]._process._process.kill()

    with serving(airborne=True, each_step=kill) as stand_in:
        links.append(open_link(name_of(stand_in), PERIOD))
        flown = RealFlight(links[0], SCENARIO, SCENARIO.space.first_guess(1), FlightSettings(wait=20.0)).fly()
    assert flown.halt.reason is Reason.LINK
    assert 20 <= len(stand_in.setpoints) < 25
    assert "cflib" not in sys.modules


@pytest.mark.check
@pytest.mark.parametrize("arms_itself", [False, True])
def test_a_lap_by_trajectory_from_the_ground(arms_itself):
    lines = []
    with serving(noise=0.003, arms_itself=arms_itself) as stand_in:
        flown = fly(stand_in, "trajectory", arm=True, say=lines.append)
        check(stand_in, flown)
    assert any("the trajectory has" in line and "mm" in line for line in lines)
    said = ["arm", "start", "give way", "land", "give way", *([] if arms_itself else ["disarm"])]
    assert [what for _, what in stand_in.requests] == said
    assert stand_in.setpoints[-1][0] <= flown.record.race_begun + PERIOD


def test_one_that_arms_itself_does_not_take_off_unasked():
    with serving(arms_itself=True) as stand_in, pytest.raises(InputError, match="hotlap arms it only when that is asked for"):
        fly(stand_in)
    assert (stand_in.setpoints, stand_in.requests) == ([], [])


def test_an_arm_that_is_refused_says_why():
    with serving(refuses=True) as stand_in:
        flown = fly(stand_in, arm=True)
    assert (flown.phase, flown.halt.reason, stand_in.setpoints) == (Phase.ENGAGE, Reason.REFUSED, [])
    assert "its checks before a flight are not passed" in flown.halt.detail


def test_one_that_tumbles_is_given_up():
    def tumble(stand_in):
        stand_in.board.drone.crashed = len(stand_in.setpoints) > 20

    with serving(airborne=True, each_step=tumble) as stand_in:
        flown = fly(stand_in)
    assert flown.halt.reason in {Reason.TAKEN_OVER, Reason.DISARMED}
    assert len(stand_in.setpoints) < 25


def test_a_race_that_is_too_long_for_a_trajectory_is_refused(monkeypatch):
    monkeypatch.setattr("hotlap.real_flight.crazyflie.vehicle.LARGEST_ERROR", 1e-5)
    with serving(airborne=True) as stand_in, pytest.raises(LinkError, match=r"too long for a trajectory on .*mm and .* from the plan"):
        fly(stand_in, "trajectory")
    assert stand_in.requests == []


@pytest.mark.check
def test_a_link_that_is_lost_stops_it_and_setpoints(monkeypatch):
    monkeypatch.setattr(vehicle, "PATIENCE_FOLLOWED", 1.0)
    cut = []

    def fall_silent(stand_in):
        if not cut and len(stand_in.setpoints) > 20:
            cut.append(stand_in.now)
            stand_in.silent = True

    with serving(airborne=True, each_step=fall_silent) as stand_in:
        flown = fly(stand_in)
        until(lambda: "land" in [what for _, what in stand_in.requests])
    assert flown.halt.reason is Reason.LINK
    assert max(moment for moment, _, _ in stand_in.setpoints) <= cut[0] + PERIOD
    assert vehicle.PATIENCE < 0.5


def test_a_dry_run_sends_nothing():
    lines = []
    with serving(airborne=True) as stand_in:
        link = open_link(name_of(stand_in), PERIOD, mute=True)
        RealFlight(link, SCENARIO, SCENARIO.space.first_guess(1), FlightSettings(wait=20.0), lines.append).look(0.3)
        assert (stand_in.setpoints, stand_in.requests) == ([], [])
    assert any(re.search(r"would send position \(-?0\.00, -?0\.00, 1\.00\) m, to its own controller", line) for line in lines)


@pytest.mark.check
def test_a_flight_from_the_command_line_is_judged_and_scored(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for module in (lapped, scored):
        monkeypatch.setattr(module, "make_scenario", lambda race, asked: SCENARIO)
    space = SCENARIO.space
    save_parameters("any.toml", SavedParameters("arc", space.names, SCENARIO.segments, space.first_guess(1), {}))
    with serving(airborne=True) as stand_in:
        options = ["--on", name_of(stand_in), "--log", "flight.csv", "--no-rehearsal", "--json", "--wait", "20"]
        assert main(["lap", "circle-34", "--parameters", "any.toml", *options]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["stopped"], document["completion"], document["thrust_gain"]) == (None, 1.0, None)
    assert main(["score", "flight.csv", "--race", "circle-34", "--flights", "2", "--parameters", "any.toml", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["mean_error"] == pytest.approx(document["mean_error"])

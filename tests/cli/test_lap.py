"""`hotlap lap`: a stand-in flown from the command line, its log scored, and what it says where nothing can be flown."""

from __future__ import annotations

import _thread
import json
import re
import threading

import pytest

pytest.importorskip("pymavlink")

from docs.test_json import documented, keys_of
from hotlap.api import lapped, scored
from hotlap.cli import main
from hotlap.files.descriptions import save_parameters
from hotlap.files.parameters_file import SavedParameters
from hotlap.real_flight import flight as flight_loop
from hotlap.real_flight.flight import RealFlight
from hotlap.real_flight.mavlink.stand_in import StandIn, Weather
from hotlap.real_flight.settings import FlightSettings, Phase
from real_flight.hangar import DirectLink, make_drone, make_scenario

SCENARIO = make_scenario()
WEATHER = Weather(loss=0.03, latency=0.002, jitter=0.004, position=0.005, velocity=0.02, attitude=0.002)


@pytest.fixture
def hall(tmp_path, monkeypatch):
    """A folder with parameters, of a race that needs no plan; nobody waits for long."""
    monkeypatch.chdir(tmp_path)
    for module in (lapped, scored):
        monkeypatch.setattr(module, "make_scenario", lambda race, asked: SCENARIO)
    for name, short in {"MEETING": 0.2, "STEADY_FOR": 1.0}.items():
        monkeypatch.setattr(flight_loop, name, short)
    space = SCENARIO.space
    save_parameters("tuned.toml", SavedParameters("arc", space.names, SCENARIO.segments, space.first_guess(1), {}))
    return tmp_path


@pytest.fixture
def serving():
    """Serves a stand-in that hovers at the start; gives the stand-in and the name of the vehicle."""
    served = []

    def serve(**settings):
        drone = make_drone(SCENARIO)
        if settings.pop("airborne", True):
            drone.hover(SCENARIO.reference.position[0])
        stand_in = StandIn("udpin:127.0.0.1:0", drone, **settings)
        thread = threading.Thread(target=stand_in.serve, daemon=True)
        thread.start()
        served.append((stand_in, thread))
        return stand_in, f"mavlink:udpout:127.0.0.1:{stand_in.port}?clock=vehicle"

    yield serve
    for stand_in, thread in served:
        stand_in.stop()
        thread.join()


def lap(*arguments):
    return main(["lap", "circle-34", "--parameters", "tuned.toml", *arguments])


@pytest.mark.check
@pytest.mark.usefixtures("hall")
def test_a_flight_is_judged_and_its_log_can_be_scored(serving, capsys):
    _, vehicle = serving(weather=WEATHER, seed=3)
    assert lap("--on", vehicle, "--log", "flight.csv", "--no-rehearsal", "--json") == 0
    ran = capsys.readouterr()
    document = json.loads(ran.out)
    assert documented()["lap"] <= keys_of(document)
    assert (document["stopped"], document["phase"], document["completion"], document["dry_run"]) == (None, "land", 1.0, False)
    assert [gate["passed"] for gate in document["gates"]] == [True, True, True]
    told = [line.partition(":")[0] for line in ran.err.splitlines()]
    assert [one for one in dict.fromkeys(told) if one in set(Phase)] == ["engage", "approach", "race", "stand", "land"]
    assert re.search(r"hovers with 3\d % of the throttle: thrust is 0\.8\d of the file's", ran.err)
    assert main(["score", "flight.csv", "--race", "circle-34", "--flights", "2", "--parameters", "tuned.toml", "--json"]) == 0
    judged = json.loads(capsys.readouterr().out)
    assert judged["completion"] == 1.0
    assert judged["mean_error"] == pytest.approx(document["mean_error"])
    assert judged["lap_time"] == pytest.approx(document["lap_time"])


class Puppet:
    """A flight that has been flown: the end of it."""

    def __init__(self, interrupted):
        link = DirectLink(make_drone(SCENARIO))
        link.drone.hover(SCENARIO.reference.position[0])
        link._script = lambda each: setattr(each, "states", not (each.sent and each.sent[-1][1].race_time))
        self.flight = RealFlight(link, SCENARIO, SCENARIO.space.first_guess(1), FlightSettings())
        self.fly = self.interrupt if interrupted else self.flight.fly

    def interrupt(self):
        self.flight.fly()
        raise KeyboardInterrupt

    def __getattr__(self, name):
        return getattr(self.flight, name)


@pytest.mark.parametrize("interrupted", [False, True])
@pytest.mark.parametrize("full", [False, True])
def test_a_disk_that_is_full_takes_neither_the_result_nor_the_flight(interrupted, full, tmp_path, monkeypatch, hall):
    monkeypatch.setattr(lapped.tempfile, "gettempdir", lambda: str(tmp_path / "none" if full else tmp_path))
    said = []
    flight, log = Puppet(interrupted), hall / "gone" / "flight.csv"
    if interrupted:
        with pytest.raises(KeyboardInterrupt) as caught:
            lapped._fly(flight, SCENARIO, log, said.append)
        kept = "" if full else f"; its flight is in {tmp_path / 'flight.csv'}"
        assert caught.value.__notes__ == [f"the vehicle was asked to land{kept}"]
    else:
        result = lapped._fly(flight, SCENARIO, log, said.append)
        assert "the state is too old" in result.stopped
        assert result.log == (None if full else tmp_path / "flight.csv")
    assert (tmp_path / "flight.csv").exists() is not full
    assert len([line for line in said if "the log is not written: " in line]) == 1 + full


@pytest.mark.usefixtures("hall")
def test_a_flight_that_was_stopped_exits_with_1_and_keeps_its_log(hall, serving, capsys):
    def fall_silent(stand_in):
        stand_in.silent = stand_in.silent or sum(told.engaged for told in stand_in.setpoints) > 60

    _, vehicle = serving(each_step=fall_silent)
    assert lap("--on", vehicle, "--no-rehearsal") == 1
    ran = capsys.readouterr()
    assert "stopped  the state is too old: 0.2" in ran.out
    assert [path.name.startswith("circle-34-") for path in hall.glob("*.csv")] == [True]


@pytest.mark.usefixtures("hall")
@pytest.mark.parametrize(
    ("settings", "options", "line"),
    [
        ({"airborne": False}, (), "--arm: mavlink:udpout:.* is not armed, and hotlap arms it only when that is asked for"),
        ({"airborne": False, "refuses": "no GPS"}, ("--arm",), r"--on: PX4, .*: the vehicle refused: arming refused for now \(no GPS\)"),
        ({}, ("--geofence", "-1,1,-1,1,0,2"), r"--geofence: the flight leaves it at \("),
        ({}, ("--on-stop", "explode"), "--on-stop: there is no request named 'explode'"),
        ({}, ("--origin", "-1,2"), "--origin: must be x, y, z .* not '-1,2'"),
        ({}, ("--margin", "0"), "--margin: must be above 0, not 0"),
        ({}, ("--stray", "-1"), "--stray: must be above 0, not -1"),
    ],
)
def test_what_cannot_be_flown_is_one_line_and_exit_status_2(serving, capsys, settings, options, line):
    stand_in, vehicle = serving(**settings)
    assert lap("--on", vehicle, "--no-rehearsal", *options) == 2
    last = capsys.readouterr().err.splitlines()[-1]
    assert re.match(f"hotlap: {line}", last)
    assert not any(told.throttle for told in stand_in.setpoints)


@pytest.mark.usefixtures("hall")
def test_what_does_not_hold_in_simulation_is_not_flown(capsys, monkeypatch):
    monkeypatch.setattr(lapped, "REHEARSED", 8)
    monkeypatch.setattr(lapped, "HOLDS", 1.1)
    assert lap("--on", "mavlink:udpin:127.0.0.1:1031") == 2
    last = capsys.readouterr().err.splitlines()[-1]
    assert re.match(r"hotlap: --parameters: pass every gate in .* in simulation, too few for a real flight; --rehearsal", last)


@pytest.mark.usefixtures("hall")
def test_a_dry_run_says_what_it_would_send_and_writes_no_log(hall, serving, capsys, monkeypatch):
    monkeypatch.setattr(lapped, "LOOKING", 0.2)
    stand_in, vehicle = serving(lockstep=False)
    assert lap("--on", vehicle, "--no-rehearsal", "--dry-run") == 0
    ran = capsys.readouterr()
    assert "would send thrust" in ran.err
    assert "circle-34: a dry run" in ran.out or "arc: a dry run" in ran.out
    assert (stand_in.setpoints, stand_in.requests, list(hall.glob("*.csv"))) == ([], [], [])


@pytest.mark.usefixtures("hall")
def test_ctrl_c_lands_it_keeps_the_log_and_says_so(hall, serving, capsys):
    def interrupt(stand_in):
        if sum(told.engaged for told in stand_in.setpoints) == 60:
            stand_in.each_step = lambda _: None
            _thread.interrupt_main()

    stand_in, vehicle = serving(each_step=interrupt)
    assert lap("--on", vehicle, "--no-rehearsal", "--log", "cut.csv") == 130
    last = capsys.readouterr().err.splitlines()[-1]
    assert last == "hotlap: interrupted; the vehicle was asked to land; its flight is in cut.csv"
    assert stand_in.requests[-1][1] == "land"
    assert (hall / "cut.csv").exists()

"""`hotlap tune RACE --goal lap_time`, with real plans and flights; and the search by itself, on plans that take no time."""

from __future__ import annotations

import json
import math

import pytest

from hotlap.analysis import fastest as search
from hotlap.analysis.fastest import Knobs, Trial, first_knobs
from hotlap.cli import fastest, main
from hotlap.files import load_parameters, load_race
from hotlap.tuning import TuningSettings

RACE = load_race("circle-20")
SETTINGS = TuningSettings(budget=60, reliability=0.95, validation=40)


def formula(limit: float):
    """Laps get shorter with v_max, tolerance and thrust; beyond a limit of all three together nothing holds."""
    tried = []

    def do(trials):
        tried.extend(trial.knobs for trial in trials.values())
        return {key: answer(trial) for key, trial in trials.items()}

    def answer(trial: Trial):
        effort = math.log(trial.knobs.v_max) + math.log(trial.knobs.tolerance) / 4 + 2 * math.log(trial.knobs.thrust)
        lap = 30 - effort
        return {"lap": lap, "planned": lap, "rate": 1.0 if effort < limit else 0.5, "flights": 1, "parameters": [[1.0] * 5], "reason": ""}

    return do, tried


def test_it_goes_as_far_as_what_is_tried_holds():
    do, tried = formula(3.2)
    knobs, found = search.fastest(RACE, "guided_walk", SETTINGS, do)
    assert found["lap"] == pytest.approx(30 - 3.2, abs=0.1)
    assert len({one.key for one in tried}) == len(tried)
    assert knobs.tolerance <= search.NEAREST_GATE * RACE.judge.distance


def test_a_plan_that_cannot_be_flown_is_slowed_down_first():
    do, _ = formula(2.0)
    knobs, found = search.fastest(RACE, "guided_walk", SETTINGS, do)
    assert knobs.v_max < RACE.planning.v_max
    assert found["rate"] == 1.0


def test_where_nothing_holds_there_is_no_result():
    do, tried = formula(-math.inf)
    assert search.fastest(RACE, "guided_walk", SETTINGS, do, most_rounds=5) is None
    assert tried


def test_knobs_say_what_is_planned_with():
    race = Knobs(25.0, 0.3, 1.1).applied(RACE)
    assert (race.planning.v_max, race.planning.tolerance) == (25.0, 0.3)
    assert race.planned.rotor_thrust[1] == pytest.approx(1.1 * RACE.planned.rotor_thrust[1])
    assert race.vehicle == RACE.vehicle
    assert first_knobs(RACE).applied(RACE).planned.rotor_thrust == RACE.planned.rotor_thrust


def test_a_faster_race_is_written_with_parameters_that_fly_it(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(fastest, "ROUNDS", 2)
    out = tmp_path / "fast"
    command = ["tune", "circle-20", "--goal", "lap_time", "--budget", "60", "--validation", "40", "--out", str(out), "--json"]
    assert main(command) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["lap_time"] < document["planned_before"]
    assert document["validation"]["rate"] >= 0.95
    assert load_parameters(out).race == load_race(document["race_file"]).name == "circle-20-fastest"
    assert main(["fly", document["race_file"], "--parameters", str(out), "--flights", "40", "--json"]) == 0
    flights = json.loads(capsys.readouterr().out)["flights"]
    assert sum(flight["completion"] == 1 for flight in flights) >= 36
    assert main(command) == 0  # nothing is flown twice
    again = capsys.readouterr()
    assert json.loads(again.out) == document
    assert "now" not in again.err


@pytest.mark.parametrize("option", [("--first-guess", "default"), ("--segments", "none"), ("--randomise", "0.1")])
def test_what_has_no_meaning_for_it_is_said(option, capsys):
    assert main(["tune", "circle-20", "--goal", "lap_time", *option]) == 2
    assert capsys.readouterr().err == f"hotlap: {option[0]}: has no meaning for --goal lap_time, which looks for a plan of its own\n"

"""`hotlap tune RACE --goal lap_time`, with real plans and flights; and the search by itself, on plans that take no time."""

from __future__ import annotations

import json
import math

import pytest

import hotlap
from hotlap.analysis import fastest as search
from hotlap.analysis.plan_trials import NEAREST_GATE, PlanSettings, Trial, first_plan_settings, neighbours
from hotlap.api import fastest
from hotlap.api.fastest import FastestResult
from hotlap.cli import main
from hotlap.core.finite import finite
from hotlap.files.descriptions import load_parameters, load_race
from hotlap.race.race import Race
from hotlap.study.database import Database
from hotlap.tuning.loop import TuningSettings

RACE = load_race("circle-20")
SETTINGS = TuningSettings(budget=60, reliability=0.95, validation=40)


def formula(limit: float):
    """Laps get shorter with v_max, tolerance and thrust; beyond a limit of all three together nothing holds."""
    tried = []

    def do(trials):
        tried.extend(trial.plan_settings for trial in trials.values())
        return {key: answer(trial) for key, trial in trials.items()}

    def answer(trial: Trial):
        effort = (
            math.log(trial.plan_settings.v_max) + math.log(trial.plan_settings.tolerance) / 4 + 2 * math.log(trial.plan_settings.thrust)
        )
        lap = 30 - effort
        return {"lap": lap, "planned": lap, "rate": 1.0 if effort < limit else 0.5, "flights": 1, "parameters": [[1.0] * 5], "reason": ""}

    return do, tried


def test_it_goes_as_far_as_what_is_tried_holds():
    (do, tried), (judge, _) = formula(3.2), formula(3.2)
    plan_settings, found = search.fastest(RACE, "guided_walk", SETTINGS, do, judge)
    assert found["lap"] == pytest.approx(30 - 3.2, abs=0.1)
    assert len({one.key for one in tried}) == len(tried)
    assert plan_settings.tolerance <= NEAREST_GATE * RACE.judge.distance


def test_what_held_by_luck_is_passed_over():
    do, tried = formula(3.2)
    unlucky = search.fastest(RACE, "guided_walk", SETTINGS, do, do)[0].key

    def judge(trials):
        return {key: {"lap": 1.0, "rate": 0.9 if trial.plan_settings.key == unlucky else 1.0} for key, trial in trials.items()}

    plan_settings, found = search.fastest(RACE, "guided_walk", SETTINGS, do, judge)
    assert plan_settings.key in {one.key for one in tried} - {unlucky}
    assert found["lap"] == 1.0
    assert search.fastest(RACE, "guided_walk", SETTINGS, do, lambda trials: {key: {"lap": 1.0, "rate": 0.9} for key in trials}) is None


def test_a_plan_that_cannot_be_flown_is_slowed_down_first():
    do, _ = formula(2.0)
    plan_settings, found = search.fastest(RACE, "guided_walk", SETTINGS, do, do)
    assert plan_settings.v_max < RACE.planning.v_max
    assert found["rate"] == 1.0


def test_where_nothing_holds_there_is_no_result():
    do, tried = formula(-math.inf)
    assert search.fastest(RACE, "guided_walk", SETTINGS, do, do, most_rounds=5) is None
    assert tried


def test_the_nearest_to_holding_is_kept_in_mind():
    """Nothing around the first plan comes near; smaller steps do."""
    first = first_plan_settings(RACE)

    def do(trials):
        away = {key: abs(math.log(trial.plan_settings.v_max / first.v_max)) for key, trial in trials.items()}
        rates = {key: 0.94 if far == 0 else 1.0 if far < 0.1 else 0.1 for key, far in away.items()}
        plain = {"lap": 10.0, "planned": 10.0, "flights": 1, "parameters": [[1.0] * 5], "reason": ""}
        return {
            key: {**plain, "rate": rate if trials[key].plan_settings.tolerance == first.tolerance else 0.1} for key, rate in rates.items()
        }

    plan_settings, _ = search.fastest(RACE, "guided_walk", SETTINGS, do, do)
    assert abs(math.log(plan_settings.v_max / first.v_max)) < 0.1


def test_a_search_ends_where_there_is_no_plan_at_all():
    rounds = []

    def do(trials):
        rounds.append(len(trials))
        return {key: {"lap": None, "planned": None, "rate": 0.0, "parameters": None, "reason": "no plan"} for key in trials}

    assert search.fastest(RACE, "guided_walk", SETTINGS, do, do) is None
    assert len(rounds) <= 6


@pytest.mark.parametrize("mass", [0.4, 1.6])
def test_a_plan_asks_for_no_more_than_vehicle_and_controller_can(mass):
    race = RACE.model_copy(update={"vehicle": RACE.vehicle.model_copy(update={"mass": mass})})
    most = max(
        plan_settings.applied(race).planning_model.max_acceleration for plan_settings in neighbours(race, PlanSettings(20.0, 0.2, 1.4), 1.0)
    )
    possible = min(race.vehicle.max_acceleration, 0.95 * race.controller.thrust[1])
    assert most <= max(possible, race.planning_model.max_acceleration) + 1e-9


def test_what_is_tried_can_be_written_as_a_race():
    for plan_settings in neighbours(RACE, PlanSettings(195.0, 4.9), 1.0):
        Race.model_validate(plan_settings.applied(RACE).model_dump())


def test_knobs_say_what_is_planned_with():
    race = PlanSettings(25.0, 0.3, 1.1).applied(RACE)
    assert (race.planning.v_max, race.planning.tolerance) == (25.0, 0.3)
    assert race.planning_model.rotor_thrust[1] == pytest.approx(1.1 * RACE.planning_model.rotor_thrust[1])
    assert race.vehicle == RACE.vehicle
    assert first_plan_settings(RACE).applied(RACE).planning_model.rotor_thrust == RACE.planning_model.rotor_thrust


@pytest.mark.check
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
    found = hotlap.tune("circle-20", goal="lap_time", budget=60, validation=40, out=out)
    assert isinstance(found, FastestResult)
    assert finite(found.to_dict()) == document
    assert found.plot().get_axes()
    assert repr(found).startswith(f"<FastestResult circle-20: {found.lap_time:.2f} s, where the race's own plan takes")
    assert [row["lap_time"] for row in found.rows()] == [found.lap_time]
    assert found.found
    assert found.chosen is not None
    assert load_race(found.chosen.race).name == "circle-20-fastest"


def test_where_no_plan_can_be_flown_python_and_the_command_say_so(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(fastest, "fastest", lambda *_: None)
    found = hotlap.tune("circle-20", goal="lap_time", out=tmp_path)
    assert isinstance(found, FastestResult)
    assert (found.found, found.lap_time, found.rows(), found.chosen) == (False, None, [], None)
    assert "no plan was found that passes every gate in 95 % of the flights" in repr(found)
    assert tuple(capsys.readouterr()) == ("", "")
    assert main(["tune", "circle-20", "--goal", "lap_time", "--out", str(tmp_path), "--json"]) == 1
    assert json.loads(capsys.readouterr().out) == finite(found.to_dict())


@pytest.mark.parametrize(
    "option", [("--first-guess", "default"), ("--segments", "none"), ("--randomise", "0.1"), ("--samples", "3"), ("--reliability", "0.5")]
)
def test_what_has_no_meaning_for_it_is_said(option, capsys):
    assert main(["tune", "circle-20", "--goal", "lap_time", *option]) == 2
    assert capsys.readouterr().err == f"hotlap: {option[0]}: has no meaning for the goal lap_time, which looks for a plan of its own\n"


def test_a_folder_holds_one_kind_of_study(tmp_path, monkeypatch, capsys):
    database = Database(tmp_path, owned=True)
    with database.transaction():
        database.create()
    database.close()
    assert main(["tune", "circle-20", "--goal", "lap_time", "--out", str(tmp_path)]) == 2
    assert "holds another study" in capsys.readouterr().err
    (tmp_path / "study.sqlite").unlink()
    (tmp_path / "race.toml").write_text('base = "circle-20"\n', encoding="utf-8")
    assert main(["tune", "circle-20", "--goal", "lap_time", "--out", str(tmp_path)]) == 2
    assert "holds another study" in capsys.readouterr().err
    assert main(["tune", "circle-20", "--out", str(tmp_path)]) == 2
    assert "holds a search for the fastest plan" in capsys.readouterr().err
    monkeypatch.chdir(tmp_path)
    assert main(["tune", "circle-20", "--goal", "lap_time", "--validation", "0"]) == 2
    assert "--validation: must not be 0" in capsys.readouterr().err

"""Exported files say what the controller flew with, and what of it the program that they are for does not do."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
import yaml

from exporters.studies import saved, tune
from flight.scenarios import make_scenario
from hotlap.exporters import export
from hotlap.exporters.flown_with import flown_with, not_reproduced
from hotlap.files.descriptions import load_parameters, save_parameters
from hotlap.race.controller_kind import ControllerKind, Solver
from hotlap.reference.scenario import Scenario

DRAG = {"drag": (0.4, 0.4, 0.2)}
SAID = {
    "observer": "observer of offset-free control",
    "drag": "model's drag along the horizon",
    "reference": "reference without drag",
    "offsets": "offsets of line_search",
}


def rich() -> Scenario:
    """Everything that a weight does not say: offset-free, drag, line search, thrust of the vehicle, a chosen plan."""
    settings = {"offset_free": True, "reference_drag": True, "solver": Solver.LINE_SEARCH, "thrust": (0.5, 500.0)}
    return make_scenario(model=DRAG, controller=settings, planning={"quadrotor": None, "thrust_share": 0.75})


def plain() -> Scenario:
    """The paper's controller."""
    return make_scenario(controller={"offset_free": False, "reference_drag": False})


def exported(folder, scenario: Scenario, name: str) -> str:
    """The text of the first file."""
    with tune(folder / "study", scenario, save=False) as opened:
        known = saved(scenario)
        chosen = {"thrust_share": 0.75} if scenario.race.planning.thrust_share else {}
        save_parameters(opened.folder / "parameters.toml", replace(known, provenance={**known.provenance, **chosen}))
        return export(opened, name, folder / "mine")[0].read_text(encoding="utf-8")


def test_remarks_are_what_was_decided_not_what_the_race_leaves_open():
    told, scenario = flown_with(rich()), rich()
    assert (told["offset_free"], told["reference_drag"], told["solver"]) == (True, True, "line_search")
    assert (told["observer_thrust"], told["observer_acceleration"]) == (10.0, 10.0)
    most = 0.95 * scenario.race.control_model.max_acceleration
    assert (told["least_thrust"], told["largest_thrust"], told["largest_command"]) == (0.5, most, most)
    assert told["thrust_share"] == 0.75
    open_ = make_scenario(controller={"offset_free": None, "solver": None, "reference_drag": True})
    decided = flown_with(open_)
    assert (decided["offset_free"], decided["solver"]) == (open_.offset_free, "real_time")
    assert not decided["reference_drag"], "the model has none"


@pytest.mark.parametrize("name", ["toml", "json"])
def test_files_with_room_for_keys_hold_the_remarks(tmp_path, name):
    text = exported(tmp_path, rich(), name)
    (tmp_path / "again.toml").write_text(text)
    content = json.loads(text)["flown_with"] if name == "json" else load_parameters(tmp_path / "again.toml").flown_with
    assert content == flown_with(rich())


def test_acados_says_what_it_lacks_and_has_the_bounds_of_the_plan(tmp_path):
    content = json.loads(exported(tmp_path, rich(), "acados"))
    assert content["flown_with"] == flown_with(rich())
    assert [any(words in sentence for sentence in content["not_reproduced"]) for words in SAID.values()] == [True] * 4
    assert (content["low"][0], content["high"][0]) == rich().planned_thrust


def test_rpg_mpc_says_in_comments_what_it_lacks_and_has_the_bounds_of_the_plan(tmp_path):
    text = exported(tmp_path, rich(), "rpg_mpc")
    comments = "\n".join(line for line in text.splitlines() if line.startswith("#"))
    assert [words in comments for words in SAID.values()] == [True] * 4
    assert "solved by line_search" in comments
    assert "75 % of the rotors' thrust, chosen by hotlap tune" in comments
    assert (yaml.safe_load(text)["min_thrust"], yaml.safe_load(text)["max_thrust"]) == rich().planned_thrust


def test_where_nothing_is_missing_nothing_is_said(tmp_path):
    assert not_reproduced(plain(), own_model=False) == []
    assert "has not" not in exported(tmp_path, plain(), "rpg_mpc")


def test_a_model_with_drag_is_the_users_to_write_where_that_can_be_done():
    race = plain().race.with_controller(ControllerKind.MPC_DRAG)
    scenario = replace(plain(), race=race)
    (mine,), (fixed,) = (not_reproduced(scenario, own_model=own) for own in (True, False))
    assert "write it into the model" in mine
    assert "write" not in fixed


@pytest.mark.check
def test_a_study_for_optuna_says_it(tmp_path):
    optuna = pytest.importorskip("optuna")
    with tune(tmp_path / "study", rich()) as opened:
        (path,) = export(opened, "optuna", tmp_path / "mine.db")
    (summary,) = optuna.get_all_study_summaries(f"sqlite:///{path}")
    assert summary.user_attrs["flown_with"] == flown_with(rich())

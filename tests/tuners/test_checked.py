"""A tuner of someone else's that breaks the protocol is told so in one line, and is flown no further."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import dataclass
from typing import Any

import pytest

from fake_world import FakeWorld, make_scenario
from hotlap import tuners
from hotlap.cli.main import main
from hotlap.core.errors import HotlapError, InputError
from hotlap.tuners.checked import Checked, checked
from hotlap.tuners.random_search import PRESETS, RandomSearch
from hotlap.tuning.loop import Tuning, TuningSettings, tune
from hotlap.tuning.objective import Objective

BUDGET = 20
BROKEN = {
    "tell: return None": r"tell must return which candidates it accepts, \(\d+,\) truth values, not None",
    "tell: return [True]": r"tell must return .* \(\d+,\) truth values, not a list of shape \(1,\)",
    "tell: return parameters": r"tell must return .* truth values, not a numpy.ndarray of shape",
    "tell: return np.full(len(parameters), 2)": r"tell must return .* truth values, not a numpy.ndarray of shape",
    "tell: return 1 / 0": r"tell raised ZeroDivisionError: division by zero \(broken_tuner.py, line \d+\)",
    "state: return {'best': np.zeros(3)}": r"state must return plain JSON: best is a numpy.ndarray of shape \(3,\); .tolist\(\)",
    "state: return {'a': [{'b': np.int64(3)}]}": r"state must return plain JSON: a\[0\]\['b'\] is a numpy.int64; .item\(\) makes it one",
    "state: return {'cost': float('inf')}": r"state must return plain JSON: cost is inf, for which JSON has no number",
    "state: return {1: 2}": r"state must return plain JSON: it has the key 1, and keys are strings",
    "state: return {'seen': {1, 2}}": r"state must return plain JSON: seen is a set",
    "state: return None": r"state must return a dict of plain JSON, not None",
    "ask: return np.repeat(super().ask(1), n + 1, axis=0)": r"ask\((\d+)\) must return 1 to \1 candidates of .*, not \d+$",
    "ask: return super().ask(n)[:0]": r"ask\(\d+\) must return 1 to .*, not 0",
    "ask: return super().ask(n)[0]": r"ask\(\d+\) must return .* not a numpy.ndarray of shape",
    "ask: return None": r"ask\(\d+\) must return .* not None",
    "ask: return super().ask(n) * np.nan": r"ask gave Q_pos_xy = nan in segment 1, beyond its bounds",
    "ask: return super().ask(n) * 1e6": r"ask gave Q_pos_xy = .* beyond its bounds of .*; space.clip brings candidates within them",
    "ask: raise SystemError": r"ask raised SystemError \(broken_tuner.py, line \d+\)",
    "start: self.nothing.at_all": r"start raised AttributeError: .* \(broken_tuner.py, line \d+\)",
}
ARGUMENTS = {"tell": "parameters, scores", "state": "", "ask": "n", "start": "first_guess, space, rng"}
SETTINGS = ["None", "{'step': 1}", "3", "Kind", "Kind(np.zeros(2))", "Kind(object())", "Kind(float('nan'))"]


def write(folder, monkeypatch, body: str, presets: str = "{'a': Kind()}") -> str:
    """A module with one tuner; its name."""
    text = f"""
from dataclasses import dataclass
import numpy as np
from hotlap.tuners.random_search import Draw, RandomSearch, RandomSearchSettings

@dataclass(frozen=True)
class Kind:
    draw: object = Draw.UNIFORM

class Mine(RandomSearch):
    {body}

PRESETS = {presets}
"""
    (folder / "broken_tuner.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(folder)
    monkeypatch.chdir(folder)
    monkeypatch.delitem(sys.modules, "broken_tuner", raising=False)
    return "broken_tuner.Mine"


def broken(what: str) -> str:
    method, _, does = what.partition(": ")
    return f"def {method}(self, {ARGUMENTS[method]}):\n        {does}"


def fly(tuner: Any, budget: int = BUDGET) -> tuple[Objective, Tuning]:
    scenario = make_scenario()
    objective = Objective(scenario, FakeWorld())
    tuning = Tuning(tuner, scenario, TuningSettings(budget=budget, validation=0, selection=0))
    for batch in tune(objective, tuning):
        json.dumps(batch.state, allow_nan=False)
    return objective, tuning


@pytest.fixture(autouse=True)
def forgotten():
    yield
    sys.modules.pop("broken_tuner", None)


@pytest.mark.parametrize("what", BROKEN)
def test_each_break_of_the_protocol_is_one_line(tmp_path, monkeypatch, what):
    name = write(tmp_path, monkeypatch, broken(what))
    with pytest.raises(HotlapError, match=f"^tuner: {name}:a: {BROKEN[what]}") as caught:
        fly(tuners.build(name))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "what", ["tell: return None", "state: return {'best': np.zeros(3)}", "ask: return np.repeat(super().ask(1), n + 1, axis=0)"]
)
def test_the_command_line_says_the_same_and_ends_with_2(tmp_path, monkeypatch, capsys, what):
    name = write(tmp_path, monkeypatch, broken(what))
    assert main(["tune", "drop-20", "--tuner", name, "--budget", "16", "--validation", "0", "--selection", "0", "--goal", "none"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert re.match(f"hotlap: --tuner: {name}:a: {BROKEN[what]}", lines[-1])
    assert not any("Traceback" in line for line in lines)


@pytest.mark.parametrize("settings", SETTINGS)
def test_settings_that_a_study_cannot_keep_are_one_line(tmp_path, monkeypatch, settings):
    name = write(tmp_path, monkeypatch, "pass", f"{{'a': {settings}}}")
    with pytest.raises(
        InputError, match=f"^tuner: {name}:a: its settings must be a frozen dataclass of numbers, .*(not a|not None|draw is)"
    ):
        tuners.build(name)


@pytest.mark.parametrize("presets", ["{}", "None", "[3]"])
def test_presets_that_are_no_mapping_are_one_line(tmp_path, monkeypatch, presets):
    name = write(tmp_path, monkeypatch, "pass", presets)
    with pytest.raises(InputError, match="PRESETS must map at least one name to settings"):
        tuners.build(name)


def test_a_class_that_cannot_be_made_or_lacks_a_method_is_one_line(tmp_path, monkeypatch):
    name = write(tmp_path, monkeypatch, "def __init__(self, name):\n        pass")
    with pytest.raises(InputError, match=r"broken_tuner.Mine:a: __init__ raised TypeError: .* positional argument"):
        tuners.build(name)
    sys.modules.pop("broken_tuner")
    name = write(tmp_path, monkeypatch, "tell = restore = None")
    with pytest.raises(InputError, match=r"has no tell, restore; a tuner has the methods start, ask, tell, state, restore"):
        tuners.build(name)


class Own(RandomSearch):
    """One that keeps to the protocol, by lists in place of arrays."""

    learns_from_any = True
    told = 0

    def ask(self, n):
        return super().ask(n).tolist()

    def tell(self, parameters, scores):  # noqa: ARG002  it accepts every other one
        self.told += len(parameters)
        return [i % 2 for i in range(len(parameters))]

    def report(self):
        return f"told of {self.told}"


class Greedy(Own):
    """One that asks for twice as many."""

    def ask(self, n):
        return super().ask(2 * n)


def test_one_that_keeps_to_it_flies_as_before_and_is_never_above_its_budget():
    _, tuning = fly(Own("mine", PRESETS["uniform"]))
    assert tuning.flights == BUDGET
    assert re.fullmatch(r"told of \d+", tuning.tuner.report())
    assert tuning.tuner.learns_from_any
    assert not hasattr(tuning.tuner, "ask_together")


@pytest.mark.parametrize("budget", [1, 7, 8, 20])
def test_one_that_asks_for_more_flies_none_of_them(budget):
    scenario = make_scenario()
    objective = Objective(scenario, FakeWorld())
    tuning = Tuning(Greedy("mine", PRESETS["uniform"]), scenario, TuningSettings(budget=budget, validation=0, selection=0))
    with pytest.raises(InputError, match=r"^tuner: mine: ask\(\d\) must return 1 to "):
        list(tune(objective, tuning))
    assert objective.flights == 0


def test_those_of_hotlap_are_as_they_are_and_none_is_checked_twice():
    own = tuners.build("random_search")
    assert checked(own) is own
    once = checked(Own("mine", PRESETS["uniform"]))
    assert isinstance(once, Checked)
    assert checked(once) is once


@dataclass(frozen=True)
class Nested:
    steps: tuple[float, ...] = (0.1, 0.2)
    name: str = "far"


def test_plain_settings_of_every_kind_are_taken():
    assert checked(Own("mine", Nested())).settings == Nested()

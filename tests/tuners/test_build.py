"""A tuner of one's own is found by the path of its class, and runs as the built-in ones do."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from fake_world import FakeWorld, make_scenario
from hotlap import tuners
from hotlap.core.errors import InputError, UnknownNameError
from hotlap.core.renamed import RenamedWarning
from hotlap.study.configuration import Configuration
from hotlap.study.study import Study
from hotlap.tuners.renamed import current_name
from hotlap.tuning.loop import TuningSettings
from hotlap.tuning.objective import Objective
from hotlap.tuning.scoring import Metric

MODULE = '''
from hotlap.tuners.random_search import PRESETS, RandomSearch

class Mine(RandomSearch):
    """One of my own."""
'''


@pytest.fixture
def module(tmp_path, monkeypatch):
    (tmp_path / "my_tuners_of_a_test.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    yield "my_tuners_of_a_test"
    sys.modules.pop("my_tuners_of_a_test", None)


def test_presets_are_found_as_those_of_built_in_tuners(module):
    assert tuners.build(f"{module}.Mine").name == f"{module}.Mine:paper"
    assert tuners.build(f"{module}.Mine:default").settings == tuners.build("random_search").settings
    assert tuners.build(f"{module}.Mine:uniform").settings == tuners.build("random_search:uniform").settings
    with pytest.raises(UnknownNameError, match=r"no preset of .*Mine named 'papr' \(did you mean paper\?\)"):
        tuners.build(f"{module}.Mine:papr")


def test_it_has_studies_that_are_resumed(module, tmp_path):
    scenario = make_scenario()
    name = tuners.build(f"{module}.Mine").name
    asked = Configuration(scenario, "fake", Metric.TIME, name, TuningSettings(budget=12, validation=0), scenario.space.first_guess(2))
    with Study.open(tmp_path / "study", asked) as study:
        result = study.run(Objective(scenario, FakeWorld(reach=50.0)))
    with Study.read(tmp_path / "study") as study:
        assert study.tuning.tuner.name == result.tuner == name
        assert np.array_equal(study.result.best.parameters, result.best.parameters)


@pytest.mark.parametrize("name", ["no_such_module_at_all.Mine", "json.Mine", "json.dumps", ".Mine", "json."])
def test_what_cannot_be_imported_is_one_line(name):
    with pytest.raises(InputError, match=r"tuner: .* cannot be imported: ") as caught:
        tuners.build(name)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "def Mine(:\n",
        "import no_such_name_anywhere.at_all\n",
        "oops\n",
        "1 / 0\n",
        "Mine, PRESETS = 3, {'a': 1}\n",
        "Mine, PRESETS = dict, {}\n",
    ],
    ids=["syntax", "import", "name", "zero", "no class", "no presets"],
)
def test_a_module_that_is_broken_is_one_line_that_says_how(tmp_path, monkeypatch, text):
    (tmp_path / "broken_tuner_of_a_test.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    try:
        with pytest.raises(InputError, match=r"tuner: broken_tuner_of_a_test\.Mine cannot be imported: \w+") as caught:
            tuners.build("broken_tuner_of_a_test.Mine")
    finally:
        sys.modules.pop("broken_tuner_of_a_test", None)
    assert "\n" not in str(caught.value)


def test_a_file_in_the_folder_is_a_tuner_without_a_list_to_edit(tmp_path, monkeypatch):
    (tmp_path / "one_of_a_test.py").write_text(MODULE.replace("class Mine", "class OneOfATest"))
    (tmp_path / "support_of_a_test.py").write_text("LEAST = 3\n")
    monkeypatch.setattr(tuners, "__path__", [*tuners.__path__, str(tmp_path)])
    try:
        assert tuners.build("one_of_a_test").name == "one_of_a_test:paper"
        assert tuners.build("one_of_a_test:uniform").settings == tuners.build("random_search:uniform").settings
        added = [name for name in tuners.names() if name.endswith(("random_search:paper", "_of_a_test:paper"))]
        assert added == ["one_of_a_test:paper", "random_search:paper"], "in alphabetical order"
        with pytest.raises(UnknownNameError, match=r"available: .*one_of_a_test"):
            tuners.build("support_of_a_test")
    finally:
        for name in ("one_of_a_test", "support_of_a_test"):
            sys.modules.pop(f"hotlap.tuners.{name}", None)
            vars(tuners).pop(name, None)


@pytest.mark.parametrize("name", ["walk", "tuner", "renamed", "unit_box", "surrogates", "__init__"])
def test_a_module_that_is_no_algorithm_is_no_tuner(name):
    with pytest.raises(UnknownNameError, match=f"no tuner named '{name}'"):
        tuners.build(name)


def test_only_the_algorithm_that_is_asked_for_is_imported():
    program = (
        "import sys; from hotlap import tuners; tuners.build('random_search')\n"
        "print(*(name.removeprefix('hotlap.tuners.') for name in sys.modules if name.startswith('hotlap.tuners.')))"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert set(ran.stdout.split()) == {"renamed", "tuner", "random_search"}


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("gatewise", "gate_gp:default"),
        ("gatewise:default", "gate_gp:default"),
        ("gatewise:homely", "gate_gp:no_exploration"),
        ("gate_gp:hasty", "gate_gp:one_generation"),
        ("gatewise:steady", "gate_gp:no_restarts"),
        ("guided_walk:homely", "guided_walk:no_exploration"),
        ("guided_walk:steady", "guided_walk:no_restarts"),
    ],
)
def test_a_name_of_before_goes_on_working_and_says_the_new_one(old, new):
    with pytest.warns(RenamedWarning) as caught:
        tuner = tuners.build(old)
    assert tuner.name == new
    assert tuner.settings == tuners.build(new).settings
    assert [str(warning.message) for warning in caught] == [f"{old} is now called {current_name(old)}"]
    assert caught[0].filename == __file__, "it names the line that asks"


@pytest.mark.parametrize("name", [*tuners.names(), "gate_gp", "cma_es:homely", "my_module.Mine:steady"])
def test_names_of_today_stay(name):
    assert current_name(name) == name

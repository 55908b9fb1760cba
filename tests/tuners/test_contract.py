"""What every tuner must do, whatever its algorithm; one that is added is tested without editing this file."""

from __future__ import annotations

import ast
import hashlib
import json
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

import hotlap.tuners
from hotlap import tuners
from hotlap.core.errors import UnknownNameError
from hotlap.core.parameters import ParameterSpace
from hotlap.core.records import Scores

from .laws import make_scores

SPACE = ParameterSpace(
    ("Q_pos_xy", "Q_pos_z", "Q_attitude", "Q_velocity", "horizon"),
    np.array([1.0, 100.0, 1.0, 1.0, 1.0]),
    np.array([1000.0, 1500.0, 100.0, 1000.0, 7.0]),
    np.array([200.0, 500.0, 50.0, 10.0, 4.0]),
    np.array([1.0, 1.0, 1.0, 1.0, 0.5]),
)
SEGMENTS = 3
EVERY = pytest.mark.parametrize("name", tuners.names())


def start(name: str, seed: int = 3) -> tuners.Tuner:
    tuner = tuners.build(name)
    tuner.start(SPACE.first_guess(SEGMENTS), SPACE, np.random.default_rng(seed))
    return tuner


def judge(parameters: np.ndarray) -> Scores:
    """A bowl in logarithms, with a segment that fails."""
    bowl = np.log(parameters / SPACE.default * 1.5) ** 2
    return make_scores(bowl.sum(axis=(1, 2)), failed_segment=1)


def play(tuner: tuners.Tuner, flights: int, n: int = 4, scores=judge) -> np.ndarray:
    """Ask and tell for a number of flights; all that was asked for, which lies within the bounds."""
    asked = []
    while flights > 0:
        parameters = tuner.ask(min(n, flights))
        assert 1 <= len(parameters) <= min(n, flights)
        assert SPACE.contains(parameters)
        accepted = tuner.tell(parameters, scores(parameters))
        assert accepted.shape == (len(parameters),)
        assert accepted.dtype == bool
        asked.append(parameters)
        flights -= len(parameters)
    return np.concatenate(asked) if asked else SPACE.first_guess(0)


def digest(name: str, seed: int = 3) -> str:
    """Of the first flights, in a few bytes."""
    return hashlib.sha256(play(start(name, seed), 40).tobytes()).hexdigest()


@EVERY
def test_first_ask_begins_with_the_first_guess(name):
    np.testing.assert_array_equal(start(name).ask(4)[0], SPACE.first_guess(SEGMENTS))


@pytest.mark.parametrize("algorithm", sorted({name.split(":")[0] for name in tuners.names()}))
def test_same_seed_asks_the_same_in_another_process_and_another_seed_does_not(algorithm):
    names = [name for name in tuners.names() if name.split(":")[0] == algorithm]
    program = "import sys\nfrom tuners.test_contract import digest\nfor name in sys.argv[1:]: print(name, digest(name))"
    here = Path(__file__).parent.parent
    out = subprocess.run([sys.executable, "-c", program, *names], cwd=here, capture_output=True, text=True, check=True).stdout
    elsewhere = dict(line.split() for line in out.splitlines())
    assert elsewhere == {name: digest(name) for name in names}
    assert all(elsewhere[name] != digest(name, seed=4) for name in names)


@EVERY
@pytest.mark.parametrize("turns", [((1, 15), (2, 15), (7, 30), (64, 90)), ((64, 64), (7, 14), (1, 5))], ids=["more", "fewer"])
def test_any_number_may_be_asked_for_and_no_more_is_given(name, turns):
    tuner = start(name)
    for n, flights in turns:
        assert len(play(tuner, flights, n)) == flights


@EVERY
def test_a_first_guess_on_or_beyond_a_bound_is_brought_inside(name):
    tuner = tuners.build(name)
    tuner.start(np.tile(SPACE.high * 1.2, (SEGMENTS, 1)), SPACE, np.random.default_rng(0))
    asked = play(tuner, 50)
    assert SPACE.contains(asked)
    np.testing.assert_array_equal(asked[0], np.tile(SPACE.high, (SEGMENTS, 1)))


@EVERY
@pytest.mark.parametrize("cost", [np.nan, np.inf, 1e300, 12.0], ids=["nan", "inf", "huge", "equal"])
def test_survives_flights_that_are_all_alike_and_all_bad(name, cost):
    tuner = start(name)
    asked = play(tuner, 50, scores=lambda parameters: make_scores(np.full(len(parameters), cost), completion=0.0))
    assert SPACE.contains(asked)
    assert len(np.unique(asked, axis=0)) > 10, "it went on searching"
    json.dumps(tuner.state(), allow_nan=False)


@EVERY
def test_saved_and_restored_through_json_it_goes_on_as_if_never_stopped(name):
    never_stopped, resumed = start(name), start(name)
    for flights in (1, 16, 23, 25):
        saved = json.dumps(resumed.state(), allow_nan=False)
        resumed = start(name, seed=99)
        resumed.restore(json.loads(saved))
        np.testing.assert_array_equal(play(resumed, flights), play(never_stopped, flights))
    assert resumed.state() == never_stopped.state()


@EVERY
def test_what_it_hands_out_is_not_its_own_memory(name):
    tuner, untouched = start(name), start(name)
    for _ in range(12):
        asked, same = tuner.ask(4), untouched.ask(4)
        np.testing.assert_array_equal(asked, same)
        scores = judge(asked)
        tuner.tell(asked, scores)
        untouched.tell(same, scores)
        asked[:] = -1.0


@EVERY
def test_settings_are_plain_json(name):
    assert json.loads(json.dumps(asdict(tuners.build(name).settings), allow_nan=False))


@EVERY
def test_is_built_under_the_name_that_it_bears(name):
    assert tuners.build(name).name == name


def test_an_algorithm_without_preset_is_its_first_preset():
    assert tuners.build("metropolis_hastings").name == tuners.build("metropolis_hastings:default").name == "metropolis_hastings:tied"
    assert tuners.build("random_search").name == "random_search:paper"
    assert tuners.build(tuners.DEFAULT).name in tuners.names()


@pytest.mark.parametrize("name", ["metropolis", "metropolis_hastings:papr", "", ":paper", "random_search:"])
def test_an_unknown_name_is_refused_with_those_that_there_are(name):
    with pytest.raises(UnknownNameError, match=r"available: .*(paper|random_search)"):
        tuners.build(name)


def test_tuners_know_parameters_and_records_and_nothing_else_of_hotlap():
    allowed = {"hotlap.core.parameters", "hotlap.core.records", "hotlap.core.errors", "hotlap.core.renamed"}
    for path in Path(str(hotlap.tuners.__file__)).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            modules = (
                [node.module or ""]
                if isinstance(node, ast.ImportFrom)
                else [alias.name for alias in node.names]
                if isinstance(node, ast.Import)
                else []
            )
            for module in modules:
                foreign = module.split(".")[0] == "hotlap" and not module.startswith("hotlap.tuners")
                assert not foreign or module in allowed, f"{path.name} imports {module}"

"""What every tuner must do, whatever its algorithm; one that is added is tested without editing this file.

Most properties are read off two runs of each preset: one that is never saved, in another process, and one in this process that is saved
and restored through JSON again and again and whose parameters are overwritten as soon as they have been flown.
"""

from __future__ import annotations

import ast
import json
import subprocess
import sys
import traceback
from collections.abc import Callable, Iterator
from dataclasses import FrozenInstanceError, asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hotlap.tuners
from hotlap import tuners
from hotlap.core.errors import UnknownNameError
from hotlap.core.parameters import ParameterSpace
from hotlap.core.records import Scores
from hotlap.system.blas_threads import one_thread

from .laws import make_scores

SPACE = ParameterSpace(
    ("Q_pos_xy", "Q_pos_z", "Q_attitude", "Q_velocity", "horizon"),
    np.array([1.0, 100.0, 1.0, 1.0, 1.0]),
    np.array([1000.0, 1500.0, 100.0, 1000.0, 7.0]),
    np.array([200.0, 500.0, 50.0, 10.0, 4.0]),
    np.array([1.0, 1.0, 1.0, 1.0, 0.5]),
)
SEGMENTS, GATE_SEGMENTS = 3, np.array([0, 0, 1, 2, 2])
CRASH = 1.5  # a miss at which a flight ends
TURNS = ((1, 1), (2, 16), (7, 23), (64, 25))  # how many are asked for at once, and least flights until the next turn


def start(name: str, seed: int = 3) -> tuners.Tuner:
    tuner = tuners.build(name)
    tuner.start(SPACE.first_guess(SEGMENTS), SPACE, np.random.default_rng(seed))
    return tuner


def judge(parameters: np.ndarray) -> Scores:
    """A bowl in logarithms, with a segment that fails."""
    bowl = np.log(parameters / SPACE.default * 1.5) ** 2
    return make_scores(bowl.sum(axis=(1, 2)), failed_segment=1)


def judge_gates(parameters: np.ndarray) -> Scores:
    """The same bowl as flights through gates: a dense cost of its own, and the miss at each gate, unknown behind a crash."""
    bowl = (np.log(parameters / SPACE.default * 1.5) ** 2).sum(axis=2)
    miss = np.log(0.1 + bowl[:, GATE_SEGMENTS]) - 0.5
    reached = np.cumprod(miss < CRASH, axis=1, dtype=bool)
    seen = np.hstack([np.ones((len(miss), 1), dtype=bool), reached[:, :-1]])
    segments = np.tile(GATE_SEGMENTS, (len(miss), 1))
    passed = np.cumprod(miss < 0, axis=1).mean(axis=1)
    gates = {"gate_miss": np.where(seen, miss, np.nan), "gate_segment": segments, "completion": passed}
    return replace(judge(parameters), dense=np.exp(miss).sum(axis=1), **gates)


def step(tuner: tuners.Tuner, n: int, scores: Callable[[np.ndarray], Scores] = judge) -> np.ndarray:
    """Ask for at most n and tell; what was asked for, which lies within the bounds."""
    parameters = tuner.ask(n)
    assert 1 <= len(parameters) <= n
    assert SPACE.contains(parameters)
    accepted = tuner.tell(parameters, scores(parameters))
    assert accepted.shape == (len(parameters),)
    assert accepted.dtype == bool
    return parameters


def play(tuner: tuners.Tuner, flights: int, n: int = 4, scores: Callable[[np.ndarray], Scores] = judge) -> np.ndarray:
    """Ask and tell for a number of flights; all that was asked for."""
    asked = []
    while flights > 0:
        asked.append(step(tuner, min(n, flights), scores))
        flights -= len(asked[-1])
    return np.concatenate(asked) if asked else SPACE.first_guess(0)


def turn(tuner: tuners.Tuner, n: int, flights: int, overwrite: bool = False) -> list[list[float]]:
    """Always ask for n, until so many flights are flown; all that was asked for, which may be overwritten after that."""
    asked: list[list[float]] = []
    while len(asked) < flights:
        parameters = step(tuner, n, judge_gates)
        asked += parameters.tolist()
        if overwrite:
            parameters[:] = -1.0
    return asked


def never_saved(name: str) -> dict[str, Any]:
    """A run from its beginning to its end."""
    tuner = start(name)
    return {"asked": [turn(tuner, *one) for one in TURNS], "state": tuner.state()}


def saved_and_restored(name: str) -> dict[str, Any]:
    """The same run, which goes on in another tuner at every turn, and whose parameters are overwritten once they are flown."""
    tuner, asked = start(name), []
    for one in TURNS:
        saved = json.dumps(tuner.state(), allow_nan=False)
        tuner = start(name, seed=99)
        tuner.restore(json.loads(saved))
        asked.append(turn(tuner, *one, overwrite=True))
    return {"asked": asked, "state": tuner.state()}


def answer() -> None:
    """For every name on standard input the run that is never saved, a line of JSON."""
    one_thread()
    for line in sys.stdin:
        try:
            text = json.dumps(never_saved(line.strip()), allow_nan=False)
        except Exception:  # noqa: BLE001  the test that asks for it fails with it
            text = json.dumps({"error": traceback.format_exc()})
        print(text, flush=True)  # noqa: T201


@pytest.fixture(scope="module")
def elsewhere() -> Iterator[Callable[[str], dict[str, Any]]]:
    """Runs that are never saved, from another process."""
    program = [sys.executable, "-c", "from tuners.test_contract import answer; answer()"]
    with subprocess.Popen(program, cwd=Path(__file__).parents[1], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdin is not None
        assert process.stdout is not None

        def run(name: str) -> dict[str, Any]:
            process.stdin.write(f"{name}\n")
            process.stdin.flush()
            return json.loads(process.stdout.readline())

        yield run
        process.stdin.close()


@pytest.fixture(scope="module", params=tuners.names())
def name(request: pytest.FixtureRequest) -> str:
    """All tests of a preset in turn, so that they share its runs."""
    return request.param


@pytest.fixture(scope="module")
def run(name: str, elsewhere: Callable[[str], dict[str, Any]]) -> dict[str, Any]:
    """The run that is never saved."""
    return elsewhere(name)


def test_first_ask_begins_with_the_first_guess(name):
    np.testing.assert_array_equal(start(name).ask(4)[0], SPACE.first_guess(SEGMENTS))


def test_saved_restored_and_its_parameters_overwritten_it_goes_as_never_saved_in_another_process(name, run):
    here = saved_and_restored(name)
    assert run.get("error") is None, run["error"]
    for mine, theirs in zip(here["asked"], run["asked"], strict=True):
        np.testing.assert_array_equal(mine, theirs)
    assert json.loads(json.dumps(here["state"])) == run["state"]


def test_another_seed_asks_for_others(name, run):
    tuner = start(name, seed=4)
    assert [turn(tuner, *one) for one in TURNS[:2]] != run["asked"][:2]


def test_a_first_guess_beyond_a_bound_is_brought_inside_and_many_may_be_asked_for_at_first(name):
    tuner = tuners.build(name)
    tuner.start(np.tile(SPACE.high * 1.2, (SEGMENTS, 1)), SPACE, np.random.default_rng(0))
    asked = [turn(tuner, *one) for one in ((64, 30), (7, 14), (1, 6))]
    np.testing.assert_array_equal(asked[0][0], np.tile(SPACE.high, (SEGMENTS, 1)))


@pytest.mark.parametrize("cost", [np.nan, np.inf, 1e300, 12.0], ids=["nan", "inf", "huge", "equal"])
def test_survives_flights_that_are_all_alike_and_all_bad(name, cost):
    tuner = start(name)
    asked = play(tuner, 50, scores=lambda parameters: make_scores(np.full(len(parameters), cost), completion=0.0))
    assert SPACE.contains(asked)
    assert len(np.unique(asked, axis=0)) > 10, "it went on searching"
    json.dumps(tuner.state(), allow_nan=False)


def as_read(value: Any) -> Any:
    """A value as JSON gives it back: with lists for tuples."""
    if isinstance(value, dict):
        return {key: as_read(each) for key, each in value.items()}
    return [as_read(each) for each in value] if isinstance(value, tuple) else value


def test_settings_cannot_be_changed_and_are_plain_json(name):
    settings = tuners.build(name).settings
    plain = asdict(settings)
    assert json.loads(json.dumps(plain, allow_nan=False)) == as_read(plain)
    for key in plain:
        with pytest.raises(FrozenInstanceError):
            setattr(settings, key, None)


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
    allowed = {"hotlap.core.parameters", "hotlap.core.records", "hotlap.core.errors", "hotlap.core.renamed", "hotlap.core.own_code"}
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


def test_the_flights_of_the_contract_pass_gates_miss_gates_and_crash():
    scores = judge_gates(SPACE.from_unit(np.random.default_rng(0).random((200, SEGMENTS, 5))))
    unknown = np.isnan(scores.gate_miss)
    assert 0.1 < unknown.mean() < 0.9
    assert not unknown[:, 0].any()
    near = judge_gates(np.tile(SPACE.default / 1.5, (1, SEGMENTS, 1)))
    assert near.completion == 1.0
    assert not np.isnan(near.gate_miss).any()

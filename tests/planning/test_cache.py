"""Plans are kept between runs, under a key that changes with whatever matters."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from hotlap import planning
from hotlap.planning import cache as plan_cache
from hotlap.planning import planner
from hotlap.planning.problem import Problem
from hotlap.race.race import PlanDynamics, Race, Ramp
from hotlap.race.rotors import RotorLayout
from hotlap.reference.reference import Reference
from hotlap.system import sealed
from hotlap.system.disk_cache import source_files
from hotlap.system.sealed import CacheWarning
from reached import reached

from . import small

RACE = small.RACES["drag"]


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """An empty cache, in which one plan takes no time."""
    monkeypatch.setenv("HOTLAP_CACHE", str(tmp_path))
    monkeypatch.setattr(planner, "find_plan", lambda _: small.planned("drag")[2])
    return tmp_path / "plans"


def forbid_planning(monkeypatch) -> None:
    def fail(_):
        raise AssertionError("planned anew")

    monkeypatch.setattr(planner, "find_plan", fail)


def assert_same(a: Reference, b: Reference) -> None:
    for field in dataclasses.fields(Reference):
        assert_array_equal(getattr(a, field.name), getattr(b, field.name))


def assert_planned(expected: Reference) -> None:
    """The plan is what it should be; the planner may have taken another time."""
    assert_same(dataclasses.replace(planning.plan(RACE), cpu_time=expected.cpu_time), expected)


def test_a_plan_is_made_once(folder, monkeypatch):
    first = planning.plan(RACE)
    forbid_planning(monkeypatch)
    assert_same(planning.plan(RACE), first)
    assert [file.suffix for file in folder.iterdir()] == [".npz"]


def test_without_a_cache_nothing_is_kept(folder):
    planning.plan(RACE, cache=False)
    assert not folder.exists()


@pytest.mark.parametrize("damage", [b"", b"no zip at all", None], ids=["empty", "rubbish", "cut short"])
def test_a_damaged_file_is_planned_anew_and_mended(folder, monkeypatch, damage):
    first = planning.plan(RACE)
    file = next(folder.iterdir())
    file.write_bytes(file.read_bytes()[:3000] if damage is None else damage)
    with pytest.warns(CacheWarning, match=r"\.npz: is damaged, so it is made anew$"):
        assert_planned(first)
    forbid_planning(monkeypatch)
    planning.plan(RACE)


def test_an_archive_that_is_whole_but_not_as_it_was_written_is_planned_anew(folder):
    """Another plan, or the same one moved by five metres."""
    first = planning.plan(RACE)
    (file,) = folder.iterdir()
    moved = {name: getattr(first, name) + (5.0 if name == "position" else 0.0) for name in (*plan_cache.ARRAYS, *plan_cache.SCALARS)}
    with file.open("wb") as stream:
        np.savez(stream, **moved)
    with pytest.warns(CacheWarning, match="is damaged"):
        assert_planned(first)
    other = plan_cache.key(Problem.of(OTHERS["mass"]))
    file.rename(folder / f"{other}.npz")
    with pytest.warns(CacheWarning, match="is damaged"):
        assert plan_cache.load(other) is None


def spoilt(name: str, change: Callable[[Any], Any]) -> Callable[[Reference], Reference]:
    """A plan in which a field is not what it should be."""
    return lambda plan: dataclasses.replace(plan, **{name: change(getattr(plan, name))})


NO_PLANS_AT_ALL = {
    "a position is no number": spoilt("position", lambda values: values * np.nan),
    "a rate is infinite": spoilt("rates", lambda values: values + np.inf),
    "a row is missing": spoilt("velocity", lambda values: values[1:]),
    "a column is missing": spoilt("attitude", lambda values: values[:, :3]),
    "thrust is a table": spoilt("thrust", lambda values: values[:, None]),
    "a gate's time is no number": spoilt("gate_times", lambda values: values * np.nan),
    "gates run backwards": spoilt("gate_times", lambda values: values[::-1]),
    "no gates": spoilt("gate_times", lambda values: values[:0]),
    "rotors without rows": spoilt("rotor_thrusts", lambda values: values[0]),
    "longer than its rows": spoilt("duration", lambda value: value + 1000.0),
    "as long as a number can be": spoilt("duration", lambda _: 1e300),
    "before it begins": spoilt("duration", lambda value: -value),
    "endless": spoilt("duration", lambda _: np.inf),
    "no period": spoilt("period", lambda _: 0.0),
    "a period that is no number": spoilt("period", lambda _: np.nan),
    "a time of the planner that is no number": spoilt("cpu_time", lambda _: np.nan),
}


@pytest.mark.parametrize("spoil", NO_PLANS_AT_ALL.values(), ids=NO_PLANS_AT_ALL.keys())
def test_what_is_no_plan_is_planned_anew(folder, spoil):
    first = planning.plan(RACE)
    plan_cache.save(plan_cache.key(Problem.of(RACE)), spoil(first))
    with pytest.warns(CacheWarning, match="is no plan, so it is made anew$"):
        assert_planned(first)
    assert len(list(folder.iterdir())) == 1


def test_a_plan_with_other_arrays_is_planned_anew(folder):
    first = planning.plan(RACE)
    (file,) = folder.iterdir()
    for content in (b"", b"no archive", b"PK\x05\x06" + bytes(18)):
        sealed.write(file, content)
        with pytest.warns(CacheWarning, match="is no plan"):
            assert_planned(first)


def test_a_cache_that_cannot_be_written_is_no_error(folder):
    folder.parent.mkdir(exist_ok=True)
    folder.write_text("a file where the folder should be")
    assert planning.plan(RACE).duration > 0


def planned_with(**settings) -> Race:
    return RACE.model_copy(update={"planning": RACE.planning.model_copy(update=settings)})


def flown_on(**track) -> Race:
    return RACE.model_copy(update={"track": RACE.track.model_copy(update=track)})


def quadrotor(**values) -> Race:
    return planned_with(quadrotor=RACE.planning_model.model_copy(update=values))


OTHERS = {
    "tolerance": planned_with(tolerance=0.21),
    "nodes": planned_with(nodes=13),
    "v_max": planned_with(v_max=33.0),
    "floor": planned_with(floor=-3.0),
    "ramp": planned_with(ramp=Ramp(distance=10.0, thrust_to_weight=1.5, rate=3.0)),
    "start": flown_on(start=(0.0, 0.0, 0.51)),
    "attitude": flown_on(attitude=(0.0, 1.0, 0.0, 0.0)),
    "gates": flown_on(gates=RACE.track.gates[:-1]),
    "no end": flown_on(end=None),
    "mass": quadrotor(mass=1.01),
    "rate limit": quadrotor(rate_limit=(10.0, 10.0, 0.1)),
    "gravity": quadrotor(gravity=9.81),
    "layout": quadrotor(layout=RotorLayout.PLUS),
}


def test_the_key_changes_with_whatever_changes_the_plan():
    keys = {plan_cache.key(Problem.of(race)) for race in (RACE, *OTHERS.values())}
    assert len(keys) == 1 + len(OTHERS)


def test_the_key_of_a_plan_with_all_dynamics_changes_with_whatever_it_knows_besides():
    race = small.FULL["full"]
    others = [{"motor_time": (0.01, 0.02)}, {"rate_gain": (9.0, 9.0, 9.0)}, {"torque_damping": 0.5}]
    others += [{"drag": (0.1, 0.2, 0.3)}, {"rotor_drag": 0.01}, {"body_drag": (0.1, 0.1, 0.1)}]
    quadrotors = [race.planning_model.model_copy(update=other) for other in others]
    settings = [race.planning.model_copy(update={"quadrotor": quadrotor}) for quadrotor in quadrotors]
    settings += [race.planning.model_copy(update={"rate_share": 0.5}), race.planning.model_copy(update={"dynamics": PlanDynamics.IDEAL})]
    changed = [race.model_copy(update={"planning": planning}) for planning in settings]
    bound = race.controller.model_copy(update={"rates": (9.0, 10.0, 3.0)})
    keys = {plan_cache.key(Problem.of(other)) for other in (race, race.model_copy(update={"controller": bound}), *changed)}
    assert len(keys) == 2 + len(changed)


def test_an_end_is_another_problem_than_a_last_gate():
    gates = (*RACE.track.gates, RACE.track.gates[0].model_copy(update={"position": RACE.track.end}))
    assert plan_cache.key(Problem.of(flown_on(gates=gates, end=None))) != plan_cache.key(Problem.of(RACE))


def test_the_key_is_the_same_for_what_the_planner_never_sees():
    renamed = flown_on(name="another", provenance="elsewhere")
    noisy = RACE.model_copy(update={"noise": RACE.noise.model_copy(update={"thrust": 0.5}), "name": "another"})
    late = quadrotor(delay=0.1, name="another", motor_time=(0.1, 0.1))
    assert {plan_cache.key(Problem.of(race)) for race in (RACE, renamed, noisy, late)} == {plan_cache.key(Problem.of(RACE))}


def test_the_key_changes_with_the_code_and_the_optimiser(monkeypatch):
    usual = plan_cache.key(Problem.of(RACE))
    monkeypatch.setattr(plan_cache, "digest_sources", lambda *_, **__: "other code")
    other = plan_cache.key(Problem.of(RACE))
    monkeypatch.setattr(plan_cache, "version", lambda _: "0.0")
    assert len({usual, other, plan_cache.key(Problem.of(RACE))}) == 3


NO_PLANS = ("race", "schema", "controllers", "controller_kind", "battery", "observer")
STAND_IN_THE_PROBLEM = {f"hotlap.race.{name}" for name in NO_PLANS}  # their results, where a plan has any of them


def is_in(package: str, module: str) -> bool:
    """Whether a module belongs to a package of hotlap."""
    return f"{module}.".startswith(f"hotlap.{package}.")


def test_every_module_that_makes_plans_takes_part_and_no_other():
    made_by = reached("hotlap.planning")
    digested = source_files(*plan_cache.SOURCES, without=plan_cache.MAKE_NO_PLANS)
    assert {path for path in digested if path.parent.name == "planning"} == {made_by[name] for name in made_by if is_in("planning", name)}
    assert {made_by[name] for name in made_by if is_in("reference", name)} <= set(digested)
    assert {name for name in made_by if is_in("race", name) and made_by[name] not in digested} <= STAND_IN_THE_PROBLEM

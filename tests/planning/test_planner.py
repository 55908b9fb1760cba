"""The planner finds a way on any sensible track, and says which gate makes another one impossible."""

from __future__ import annotations

import dataclasses
import os
import signal
import threading

import casadi as ca
import numpy as np
import pytest

from hotlap.core.errors import PlanningError
from hotlap.files.descriptions import load_race
from hotlap.planning import ipopt, plan, planner
from hotlap.planning.problem import Problem
from hotlap.race.race import Race

from . import small

SQUARE = ((10.0, 0.0, 0.5), (10.0, 10.0, 0.5), (0.0, 10.0, 0.5), (0.0, 0.0, 0.5))


def at(height: float) -> tuple[tuple[float, float, float], ...]:
    """The square with its third gate at another height."""
    return (*SQUARE[:2], (0.0, 10.0, height), SQUARE[3])


IMPOSSIBLE = [
    (small.make_race([*SQUARE, (9e4, 0.0, 0.5)]), "gate 5", "more than 60 s even at"),
    (small.make_race(at(-5.0), planning={"floor": -1.0}), "gate 3", "below the floor at -1 m"),
    (small.make_race(track={"start": (0.0, 0.0, -2.0)}, planning={"floor": -1.0}), None, "the start at z = -2 m lies below the floor"),
    (small.make_race(track={"end": (0.0, 0.0, -2.0)}, planning={"floor": -1.0}), "the end", "the end: z = -2 m"),
    (small.make_race([(0.0, 800.0, 0.5), SQUARE[3]], planning={"nodes": 4}), "gate 1", "raise planning.nodes"),
]


@pytest.mark.parametrize(("race", "where", "reason"), IMPOSSIBLE, ids=[reason for *_, reason in IMPOSSIBLE])
def test_an_impossible_track_is_refused_with_its_gate(race, where, reason):
    with pytest.raises(PlanningError, match=reason) as caught:
        plan(race, cache=False)
    assert caught.value.where == where


def test_a_share_of_the_thrust_that_cannot_carry_the_drone_is_refused_before_anything_is_searched():
    race = load_race("circle-34")
    weak = race.vehicle.model_copy(update={"rotor_thrust": (0.0, 2.0)})
    race = race.model_copy(update={"vehicle": weak, "model": None, "planning": type(race.planning)()})
    with pytest.raises(PlanningError, match=r"thrust-to-weight of 0\.97 and cannot hover; raise planning\.thrust_share"):
        plan(race)


@pytest.mark.check
def test_a_drone_too_weak_for_a_climb_is_told_the_gate():
    with pytest.raises(PlanningError, match="no plan for small, gate 1") as caught:
        plan(small.make_race([(0.0, 0.0, 100.0)], quadrotor={"rotor_thrust": (0.0, 2.46)}), cache=False)
    assert caught.value.where == "gate 1"


ODD = {
    "one gate": small.make_race([(5.0, 0.0, 0.5)]),
    "gates almost at the same place": small.make_race([(10.0, 0.0, 0.5), (10.0, 1e-5, 0.5), (20.0, 0.0, 0.5)]),
    "a gate around the start": small.make_race([(0.05, 0.0, 0.5), (5.0, 0.0, 0.5)]),
    "hardly any tolerance": small.make_race(SQUARE, planning={"tolerance": 1e-4}),
    "hardly any roll": small.make_race(SQUARE, quadrotor={"rate_limit": (0.02, 0.02, 0.0)}),
    "cannot sink upright": small.make_race(SQUARE, quadrotor={"rotor_thrust": (3.0, 4.0)}),
    "start on the floor": small.make_race(SQUARE, track={"floor": 0.5}),
}


@pytest.mark.check
@pytest.mark.parametrize("race", ODD.values(), ids=ODD)
def test_an_odd_track_is_planned_all_the_same(race):
    reference = plan(race, cache=False)
    distances = np.linalg.norm(reference.position_at(reference.gate_times) - race.track.gate_positions, axis=1)
    assert distances.max() < race.planning.tolerance + 0.05


def random_race(seed: int) -> Race:
    """Twelve gates, 4 to 20 m apart in any direction."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(size=(12, 3)) * np.array([1.0, 1.0, 0.4])
    steps *= rng.uniform(4, 20, size=(12, 1)) / np.linalg.norm(steps, axis=1, keepdims=True)
    base = "split-s" if seed % 4 == 3 else "circle-34"  # with and without ramp
    return small.make_race([tuple(map(float, gate)) for gate in np.cumsum(steps, axis=0)], base=base, planning={"floor": None})


def assert_planned(race: Race) -> None:
    reference = plan(race, cache=False)
    distances = np.linalg.norm(reference.position_at(reference.gate_times) - race.track.gate_positions, axis=1)
    assert distances.max() < race.planning.tolerance + 0.15


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.check) for seed in range(1, 8))])
def test_a_random_track_is_planned(seed):
    assert_planned(random_race(seed))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8, 64))
def test_many_random_tracks_are_planned(seed):
    assert_planned(random_race(seed))


def test_a_failed_first_search_is_repeated_from_straight_lines(monkeypatch):
    problem, attempts = Problem.of(small.RACES["drag"]), []
    search = planner.plan_quadrotor

    def fail_once(problem, guess, *, barrier, iterations):
        attempts.append(guess)
        return search(problem, guess, barrier=barrier, iterations=iterations if len(attempts) > 1 else 2)

    monkeypatch.setattr(planner, "plan_quadrotor", fail_once)
    found = planner.find_plan(problem)
    assert len(attempts) == 2
    assert found.duration == pytest.approx(small.planned("drag")[2].duration, rel=1e-3)


def test_a_search_that_never_ends_names_the_gate_that_it_misses(monkeypatch):
    search = planner.plan_quadrotor
    monkeypatch.setattr(planner, "plan_quadrotor", lambda problem, guess, **options: search(problem, guess, **{**options, "iterations": 2}))
    with pytest.raises(PlanningError, match=r"gate \d: the optimiser did not converge; ") as caught:
        planner.find_plan(Problem.of(small.RACES["drag"]))
    assert caught.value.where in {f"gate {k}" for k in range(1, 5)}


@pytest.mark.check
def test_a_detour_is_refused_unless_another_search_confirms_it(monkeypatch):
    problem, search, usual = Problem.of(small.RACES["drag"]), planner.plan_quadrotor, small.planned("drag")[2].duration
    stretch = iter([2.0, 3.0, 4.0, 2.0, 2.0])

    def slowly(problem, guess, **options):
        solution, factor = search(problem, guess, **options), next(stretch)
        trajectory = dataclasses.replace(solution.trajectory, durations=factor * solution.trajectory.durations)
        return dataclasses.replace(solution, trajectory=trajectory)

    monkeypatch.setattr(planner, "plan_quadrotor", slowly)
    monkeypatch.setattr(planner, "refuse_coarse", lambda *_: None)
    with pytest.raises(PlanningError, match="found only a detour of"):
        planner.find_plan(problem)
    assert planner.find_plan(problem).duration == pytest.approx(2 * usual, rel=1e-3)


def test_ctrl_c_during_the_search_arrives(monkeypatch):
    build = ca.nlpsol

    def interrupted(*arguments):
        solver = build(*arguments)

        def solve(**inputs):
            timer = threading.Timer(0.02, os.kill, (os.getpid(), signal.SIGINT))
            timer.start()
            result = solver(**inputs)  # CasADi swallows the exception
            timer.join()
            return result

        return _Solver(solve, solver.stats)

    monkeypatch.setattr(ipopt.ca, "nlpsol", interrupted)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background processes ignore it
    try:
        with pytest.raises(KeyboardInterrupt):
            plan(small.RACES["drag"], cache=False)
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)


@dataclasses.dataclass
class _Solver:
    solve: object
    stats: object

    def __call__(self, **inputs):
        return self.solve(**inputs)


def test_it_plans_outside_of_the_main_thread():
    found = []
    thread = threading.Thread(target=lambda: found.append(plan(small.RACES["drag"], cache=False)))
    thread.start()
    thread.join()
    assert found[0].duration == pytest.approx(small.planned("drag")[3].duration, rel=1e-6)

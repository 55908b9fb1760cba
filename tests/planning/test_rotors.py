"""Vehicles of more than four rotors are planned with the limits of each of them."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.planning.planner import find_plan
from hotlap.planning.problem import Problem
from hotlap.planning.sampling import sample
from hotlap.reference.reference import Reference

from . import small

ANGLES = 2 * np.pi * (np.arange(6) + 0.5) / 6
ARM = 0.25  # m
SIX: dict[str, Any] = {
    "rotors": tuple((ARM * np.cos(a), ARM * np.sin(a), (-1.0) ** k) for k, a in enumerate(ANGLES)),
    "arm": ARM,
    "rotor_thrust": (0.1, 8 / 3),
}
FOUR: dict[str, Any] = {"rotor_thrust": (0.15, 4.0)}  # as much in all


@cache
def planned(rotors: int, *, full: bool) -> tuple[Problem, Reference]:
    own, said = (small.OWN, small.WITH_ALL) if full else ({}, {})
    problem = Problem.of(small.make_race(small.HILL[:2], planning=said, quadrotor={**own, **(SIX if rotors == 6 else FOUR)}))
    return problem, sample(problem, find_plan(problem), cpu_time=0.0)


@pytest.mark.parametrize("full", [False, pytest.param(True, marks=pytest.mark.check)], ids=["ideal", "full"])
def test_six_rotors_are_planned_within_their_limits_and_as_fast_as_four_that_push_as_much(full):
    problem, reference = planned(6, full=full)
    thrusts = reference.rotor_thrusts[: reference.planned_rows]
    assert thrusts.shape[1] == 6
    assert thrusts.min() >= 0.1 - 1e-6
    assert thrusts.max() <= 8 / 3 + 1e-6
    assert thrusts.max() > 2.6
    assert_allclose(thrusts.sum(axis=1) / problem.quadrotor.mass, reference.thrust[: reference.planned_rows], rtol=1e-9)
    assert reference.duration == pytest.approx(planned(4, full=full)[1].duration, rel=0.02)

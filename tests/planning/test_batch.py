"""Evaluating all intervals at once changes no value."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.testing import assert_allclose

from hotlap.planning.batch import evaluate
from hotlap.planning.full_stage import full_stage
from hotlap.planning.stage import point_mass_stage, quadrotor_stage


def test_it_equals_the_mapped_function():
    rng, count = np.random.default_rng(1), 5
    for stage, parameters in ((point_mass_stage(), 2), (quadrotor_stage(), 18), (full_stage(), 28)):
        rows = [rng.uniform(0.5, 1.5, size=(count, size)) for size in (stage.nx, stage.nu, 1)]
        shared = rng.uniform(0.5, 1.5, size=(1, parameters))
        symbols = [ca.MX.sym("a", *value.shape) for value in (*rows, shared)]
        batch = ca.Function("batch", symbols, evaluate(stage.jacobian, *symbols))
        mapped = stage.jacobian.map(count)(*[value.T for value in rows], np.tile(shared.T, count))
        for found, expected in zip(batch(*rows, shared), mapped, strict=True):
            assert_allclose(np.asarray(found), np.asarray(expected).T, rtol=1e-12)


def test_constants_and_what_rows_share_are_repeated():
    x, shared = ca.SX.sym("x"), ca.SX.sym("s")
    function = ca.Function("f", [x, shared], [ca.vertcat(x + shared, 2 * shared, 7.0)])
    a, b = ca.MX.sym("a", 3, 1), ca.MX.sym("b", 1, 1)
    batch = ca.Function("g", [a, b], evaluate(function, a, b))
    assert_allclose(np.asarray(batch([1, 2, 3], 10)), [[11, 20, 7], [12, 20, 7], [13, 20, 7]])

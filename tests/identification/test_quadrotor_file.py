"""The file is the vehicle that was fitted: with zeros where the fit had none, and the base's values where the log tells nothing."""

from __future__ import annotations

import math
import tomllib
from types import SimpleNamespace

import numpy as np
import pytest

from hotlap.files.descriptions import load_quadrotor
from hotlap.identification.estimates import estimates_of
from hotlap.identification.fit import Fit
from hotlap.identification.identify import Identification, ThrustMap
from hotlap.identification.model import with_numbers
from hotlap.identification.quadrotor_file import quadrotor_of, text_of
from hotlap.identification.replay import replay
from hotlap.identification.unknowns import AXES, unknowns_of

CHANGED = {"inflow": 0.02, "body_drag": (0.01, 0.02, 0.03), "drag": (0.2, 0.3, 0.4)}
UNTOLD = 1e6  # variance of what a log does not tell


def identified(base, quadratic, *, thrust_known=False, untold=()):
    """What a fit of these forms would have told, each number of it away from the base."""
    here = SimpleNamespace(has_battery=False, output=1, air=np.ones((9, 3)), force=None, rate_command=None)
    unknowns = unknowns_of(base, [here], quadratic, straight=True)
    random = np.random.default_rng(4)
    theta = np.array([one.start for one in unknowns]) + 0.02 * random.uniform(1, 2, len(unknowns))
    covariance = np.diag([UNTOLD if one.name in untold else 1e-14 for one in unknowns])
    fit = Fit(unknowns, theta, covariance, {})
    estimates = estimates_of(fit, base, [here], thrust_known=thrust_known)
    which = "thrust" if thrust_known else "mass"
    known = ThrustMap(fit.numbers["full"], 0.0, 0.2, math.nan, math.nan)
    return Identification(base, ("a.csv",), 60.0, which, estimates, known, (), ()), fit.numbers


@pytest.mark.parametrize("thrust_known", [True, False])
@pytest.mark.parametrize("quadratic", [(), ("x",), ("x", "y", "z")])
@pytest.mark.parametrize("name", ["five-inch", "flightgoggles", "hummingbird", "x500"])
def test_the_file_is_the_vehicle_that_was_fitted(name, quadratic, thrust_known):
    base = load_quadrotor(name).model_copy(update=CHANGED)
    found, numbers = identified(base, quadratic, thrust_known=thrust_known)
    mine, fitted = quadrotor_of(found, "mine"), with_numbers(base, numbers, thrust_known=thrust_known)
    assert mine.drag == pytest.approx([numbers.get(f"drag_{axis}", 0.0) for axis in AXES], rel=1e-5)
    assert mine.body_drag == pytest.approx([numbers.get(f"body_drag_{axis}", 0.0) for axis in AXES], rel=1e-5)
    assert mine.rotor_drag == pytest.approx(numbers.get("rotor_drag", 0.0), rel=1e-5)
    assert mine.delay == pytest.approx(numbers["delay"], rel=1e-5)
    for key in ("mass", "rotor_thrust", "motor_time", "inflow", "rate_gain", "inertia", "torque_ratio"):
        assert getattr(mine, key) == pytest.approx(getattr(fitted, key), rel=1e-5), key
    written = tomllib.loads(text_of(found, name))
    assert written["inflow"] == 0.0
    assert list(written["drag"]) == list(mine.drag)


def test_the_file_replays_the_fit():
    base = load_quadrotor("five-inch").model_copy(update=CHANGED)
    found, numbers = identified(base, ("x",))
    random = np.random.default_rng(1)
    commands = np.repeat(np.column_stack([random.uniform(5, 20, 20), random.uniform(-2, 2, (20, 3))]), 25, axis=0)
    flown = replay(quadrotor_of(found, "mine"), commands)
    np.testing.assert_allclose(flown, replay(with_numbers(base, numbers, thrust_known=False), commands), atol=1e-3)


def test_what_a_log_does_not_tell_of_an_axis_stays_the_bases():
    base = load_quadrotor("flightgoggles").model_copy(update=CHANGED)
    found, numbers = identified(base, ("x",), untold=("drag_y",))
    mine = quadrotor_of(found, "mine")
    assert mine.drag[1] == base.drag[1]
    assert mine.body_drag[1] == base.body_drag[1]
    assert mine.drag[0] == pytest.approx(numbers["drag_x"], rel=1e-5)
    assert "Not told" in text_of(found, "flightgoggles")


def test_drag_along_an_axis_is_written_whole_where_one_of_its_forms_is_told():
    base = load_quadrotor("flightgoggles").model_copy(update=CHANGED)
    found, numbers = identified(base, ("x",), untold=("drag_x",))
    mine = quadrotor_of(found, "mine")
    assert (mine.drag[0], mine.body_drag[0]) == pytest.approx((numbers["drag_x"], numbers["body_drag_x"]), rel=1e-5)
    assert "Not told, by itself: drag x" in text_of(found, "flightgoggles")

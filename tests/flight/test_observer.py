"""The observer finds what the model leaves out, and the controller makes up for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.dynamics.parameter_layout import MODEL
from hotlap.flight import observer
from hotlap.flight.controller import Controller
from hotlap.flight.program import run
from hotlap.race.controllers import ControllerKind
from hotlap.reference.attitude import thrust_axis
from hotlap.reference.scenario import Scenario

from .scenarios import TUNED, fly, make_reference, make_scenario

GAINS = {"mpc": TUNED, "mpc_drag": TUNED, "geometric": (8.0, 12.0, 4.0, 5.0, 10.0, 3.0)}
KINDS = ("mpc", *(pytest.param(kind, marks=pytest.mark.check) for kind in ("mpc_drag", "geometric")))  # a minute of compiling
ON = {"offset_free": True, "reference_drag": True}
DRAG = {"drag": (0.4, 0.4, 0.2)}


def scenario_of(kind: str, vehicle: dict | None = None, **settings: dict) -> Scenario:
    """The small race, flown offset-free by a kind of controller."""
    scenario = make_scenario(vehicle, **settings)
    race = scenario.race.with_controller(ControllerKind(kind))
    return replace(scenario, race=race.model_copy(update={"controller": race.controller.model_copy(update=ON)}))


def logged(scenario: Scenario, kind: str):
    """The log of one flight."""
    return fly(scenario, np.tile(GAINS[kind], (1, 2, 1)), log=[0]).logs[0]


@pytest.mark.parametrize("kind", KINDS)
def test_a_wrong_mass_is_found_and_made_up_for(kind):
    scenario = scenario_of(kind, {"mass": 1.2 * 0.716})
    log = logged(scenario, kind)
    late = log.times > 1.5
    thrust, share = log.commands[late, 0], np.einsum("ij,ij->i", log.estimates[late, 1:], thrust_axis(log.states[late, 3:7]))
    assert_allclose(log.estimates[late, 0] * thrust + share, thrust / 1.2, rtol=0.03)  # at a steady thrust the two cannot be told apart
    assert (log.estimates[late, 0] < 0.95).all()
    height = np.interp(log.times, scenario.reference.times, scenario.reference.position[:, 2])
    off = logged(make_scenario({"mass": 1.2 * 0.716}), "mpc")
    assert np.abs(log.states[late, 2] - height[late]).max() < 0.05 < np.abs(off.states[off.times > 1.5, 2] - height[off.times > 1.5]).max()


@pytest.mark.parametrize("kind", KINDS)
def test_on_a_vehicle_that_is_its_model_it_finds_nothing(kind):
    log = logged(scenario_of(kind, {**DRAG, "delay": 0.0275}, model={**DRAG, "delay": 0.0275}), kind)
    assert_allclose(log.estimates[:, 0], 1.0, atol=0.03)
    assert_allclose(log.estimates[:, 1:], 0.0, atol=0.35)


@pytest.mark.parametrize("kind", KINDS)
def test_known_drag_is_no_disturbance(kind):
    """With a drag that the model does not know the disturbance takes its place."""
    known, unknown = scenario_of(kind, DRAG, model=DRAG), scenario_of(kind, DRAG)
    mine, other = (np.abs(logged(scenario, kind).estimates[200:, 1:]).mean() for scenario in (known, unknown))
    assert mine < 0.1
    assert other > 0.5


def test_where_it_is_off_nothing_is_estimated():
    estimates = logged(make_scenario({"mass": 0.9}), "mpc").estimates
    assert_array_equal(estimates, np.tile([1.0, 0, 0, 0], (len(estimates), 1)))


@pytest.mark.parametrize("kind", KINDS)
def test_one_that_learns_nothing_flies_as_without(kind):
    """But for rounding, and the table of the reference that is made from its accelerations."""
    scenario = scenario_of(kind, {"mass": 0.75})
    still = scenario.race.controller.observer.model_copy(update={"thrust": 0.0, "acceleration": 0.0})
    controllers = (scenario.race.controller.model_copy(update={"offset_free": on, "observer": still}) for on in (True, False))
    on, off = (replace(scenario, race=scenario.race.model_copy(update={"controller": controller})) for controller in controllers)
    assert_allclose(logged(on, kind).states[:, :3], logged(off, kind).states[:, :3], atol=2e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_the_controller_alone_estimates_what_is_estimated_in_flight(kind):
    noise = {"position": 0.05, "rates": 0.1}
    scenario = scenario_of(kind, {**DRAG, "delay": 0.0475, "mass": 0.75}, model={**DRAG, "delay": 0.0275}, noise=noise)
    log = fly(scenario, np.tile(GAINS[kind], (1, 2, 1)), numbers="float64", log=[0]).logs[0]
    controller = Controller(scenario, np.array(GAINS[kind]))
    for i, (time, state) in enumerate(zip(log.times[:-1], log.states[:-1], strict=True)):
        assert_allclose(controller.command(time, state), log.commands[i], rtol=0, atol=1e-9)
        assert_allclose([controller.thrust_effectiveness, *controller.disturbance], log.estimates[i], rtol=0, atol=1e-9)


def observe_plainly(estimate: np.ndarray, x: np.ndarray, sent: float, drag: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """The equations of the module, in numpy."""
    k, d, v, axis, root, _ = np.split(estimate, [1, 4, 7, 10, 11])
    h, g, least, most, speed_gain, d_gain, k_gain, up, down = numbers
    gap = np.sqrt(np.clip(sent, least, most)) - root
    after = root + np.where(gap > 0, up, down) * gap
    thrust, now = (after**2 + root**2) / 2, thrust_axis(x[3:7])
    z = (axis + now) / 2
    ahead = v + h * (k * thrust * z - [0, 0, g] - drag + d)
    error = x[7:] - ahead
    change = 0.0 if sent > 0.97 * most else k_gain * (z @ error) * thrust / (thrust**2 + 4)
    return np.concatenate(
        [np.clip(k + change, 0.6, 1.4), np.clip(d + d_gain * error, -12, 12), ahead + speed_gain * error, now, after, [0]]
    )


@pytest.mark.parametrize("sent", [8.0, 25.0])
def test_an_observation_is_that_of_the_equations(sent):
    rng, after = np.random.default_rng(0), np.zeros(observer.ESTIMATE_SIZE)
    numbers = np.array([0.01, 9.81, 1.0, 20.0, 0.18, 0.24, 0.9, 0.4, 0.3])
    for _ in range(20):
        x = rng.normal(size=10)
        x[3:7] /= np.linalg.norm(x[3:7])
        estimate = np.concatenate([[1 + 0.4 * rng.normal()], 9 * rng.normal(size=3), rng.normal(size=6), [4.0, 0.0]])
        drag = rng.normal(size=3)
        run(observer.observation_stage(), [estimate, x, np.array([sent]), drag, numbers, after])
        assert_allclose(after, observe_plainly(estimate, x, sent, drag, numbers), atol=1e-12)


def test_a_target_is_turned_by_the_least_tilt_until_thrust_makes_up_for_an_acceleration():
    rng = np.random.default_rng(1)
    for _ in range(20):
        target = rng.normal(size=14)
        target[3:7] /= np.linalg.norm(target[3:7])
        target[10] = 10 + 5 * rng.random()
        acceleration, before, z = 2 * rng.normal(size=3), target.copy(), thrust_axis(target[3:7])
        run(observer.target_stage(), [target, acceleration, target])
        assert_allclose(target[10] * thrust_axis(target[3:7]), before[10] * z - acceleration, atol=1e-5)
        cosine = z @ thrust_axis(target[3:7])
        assert 2 * (before[3:7] @ target[3:7]) ** 2 - 1 == pytest.approx(cosine, abs=1e-9), "turned by no more than its axis"


@pytest.mark.parametrize("acceleration", [(0.0, 0.0, 9.5), (0.0, 0.0, 30.0)])
def test_a_target_without_a_direction_is_kept(acceleration):
    target = np.zeros(14)
    target[3], target[10] = 1.0, 10.0
    before = target.copy()
    run(observer.target_stage(), [target, np.array(acceleration), target])
    assert_array_equal(target, before)


def test_without_drag_the_thrust_of_a_reference_is_its_acceleration():
    reference = make_reference()
    tilted = replace(reference, thrust=reference.thrust + 3.0)
    table = observer.drag_free(tilted, 9.81)
    wanted = np.gradient(reference.velocity, reference.period, axis=0) + [0, 0, 9.81]
    assert_allclose(table[:, 10:11] * thrust_axis(table[:, 3:7]), wanted, atol=1e-9)


def test_drags_that_the_controller_ignores_are_none():
    numbers, race = np.arange(1.0, 1 + sum(MODEL.values())), make_scenario().race
    assert_array_equal(observer.known_drag(race, numbers), [1.0, 2.0, *[0.0] * 7])
    assert_array_equal(observer.known_drag(scenario_of("mpc").race, numbers), numbers)

import math

import pytest
from pydantic import ValidationError

from hotlap.files.descriptions import load_quadrotor, load_race
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import ControllerSettings, GateRule, JudgeSettings, PlanningSettings, Race, Ramp


@pytest.fixture
def race():
    return load_race("circle-34")


def test_the_model_is_the_vehicle_unless_told(race):
    bare = Race(name="r", track=race.track, vehicle=race.vehicle)
    assert bare.control_model == bare.vehicle
    assert race.control_model == race.model != race.vehicle


def test_a_plan_without_a_quadrotor_gets_a_share_of_the_model(race):
    bare = Race(name="r", track=race.track, vehicle=load_quadrotor("split-s-racer"), planning=PlanningSettings(thrust_share=0.5))
    assert bare.planning_model.max_acceleration == pytest.approx(0.5 * bare.vehicle.max_acceleration)


def test_a_plan_without_a_quadrotor_stays_below_the_controllers_limit(race):
    bare = Race(name="r", track=race.track, vehicle=load_quadrotor("flightmare"), controller=ControllerSettings(thrust=(0.1, 20.0)))
    assert bare.planning_model.max_acceleration == pytest.approx(0.95 * 20.0)


def test_a_thrust_bound_that_is_not_set_is_what_the_models_rotors_give(race):
    strong, heavy = load_quadrotor("flightmare"), load_quadrotor("flightmare").model_copy(update={"mass": 1.0})
    bare = Race(name="r", track=race.track, vehicle=strong, model=heavy)
    assert bare.controller.thrust == (0.1, heavy.max_acceleration) != (0.1, strong.max_acceleration)
    assert bare == Race.model_validate(bare.model_dump())
    assert race.controller.thrust == (0.1, 20.0), "what a race says stays"


def test_controller_and_vehicle_have_as_many_rotors(race):
    angles = (math.radians(60) * n for n in range(6))
    spots = tuple((0.2 * math.cos(angle), 0.2 * math.sin(angle), (-1.0) ** k) for k, angle in enumerate(angles))
    six = Quadrotor.model_validate({**race.vehicle.model_dump(), "rotors": spots, "arm": 0.2})
    with pytest.raises(ValidationError, match="model: has 4 rotors, and the vehicle 6"):
        Race(name="r", track=race.track, vehicle=six, model=race.vehicle)
    assert Race(name="r", track=race.track, vehicle=six).control_model.rotor_count == 6


def test_a_plan_is_free_until_a_share_or_a_quadrotor_is_given(race):
    bare = Race(name="r", track=race.track, vehicle=race.vehicle)
    assert bare.planning.free
    assert not race.planning.free
    assert not bare.with_share(0.5).planning.free
    assert bare.with_share(bare.thrust_share).planning_model == bare.planning_model


def test_v_max_is_the_speed_at_which_drag_and_tilted_thrust_balance(race):
    push = math.sqrt(race.planning_model.max_acceleration**2 - race.planning_model.gravity**2)
    assert race.planning_drag * race.planning.v_max == pytest.approx(push)


def test_without_v_max_the_plan_has_the_quadrotors_own_drag(race):
    quadrotor = load_quadrotor("split-s-racer").model_copy(update={"drag": (0.3, 0.3, 0.6)})
    bare = Race(name="r", track=race.track, vehicle=quadrotor)
    assert bare.planning_drag == pytest.approx(0.4)


@pytest.mark.parametrize(("values", "distance"), [({}, 1.3), ({"rule": GateRule.CLOSEST}, 1.3), ({"rule": "released"}, 1.2)])
def test_the_gate_distance_follows_the_rule(values, distance):
    assert JudgeSettings(**values).distance == distance
    assert JudgeSettings(**values, distance=0.7).distance == 0.7


@pytest.mark.parametrize(
    ("settings", "values", "message"),
    [
        (ControllerSettings, {"period": 0.003}, "period: a multiple"),
        (ControllerSettings, {"period": 0.1}, "period: an MPC follows with up to 0.05 s, not 0.1 s"),
        (ControllerSettings, {"nodes": 10}, r"10 nodes over a horizon of up to 3.5 s lie 0.35 s apart, .* set 18 nodes, or high\[4\] = 4"),
        (ControllerSettings, {"nodes": 100, "horizon_unit": 3.0}, r"high\[4\]: a horizon of 21 s is longer than 14 s"),
        (ControllerSettings, {"nodes": 40, "solver": "real_time"}, 'solver: "real_time" converges with up to 20 nodes'),
        (ControllerSettings, {"thrust": (5.0, 5.0)}, "thrust: the least"),
        (ControllerSettings, {"low": (300.0, 100, 1, 1, 1)}, r"default\[0\]: 200 is not within"),
        (ControllerSettings, {"high": (1.0, 1500, 100, 1000, 7)}, r"low\[0\]: 1 is not below"),
        (ControllerSettings, {"nodes": 1}, "greater than or equal to 2"),
        (JudgeSettings, {"distance": 0.0}, "greater than 0"),
        (Ramp, {"distance": 1.0, "thrust_to_weight": 0.9, "rate": 1.0}, "greater than 1"),
        (PlanningSettings, {"tolerance": 0.0}, "greater than 0"),
    ],
)
def test_impossible_settings_are_refused(settings, values, message):
    with pytest.raises(ValidationError, match=message):
        settings(**values)


def test_every_part_of_a_race_is_in_its_fingerprint(race):
    changed = [
        race.model_copy(update={"vehicle": race.vehicle.model_copy(update={"delay": 0.046})}),
        race.model_copy(update={"track": race.track.model_copy(update={"end": None})}),
        race.model_copy(update={"noise": race.noise.model_copy(update={"wind": 0.1})}),
    ]
    assert len({race.fingerprint, *(other.fingerprint for other in changed)}) == 4


def test_the_solver_is_the_one_that_converges():
    def law(**settings):
        return ControllerSettings(**settings).law

    assert law() == law(sweeps=5) == law(period=0.0025, solver="real_time") == "mpc"
    assert law(nodes=18) == law(sweeps=1) == law(period=0.02) == law(horizon_unit=0.55) == law(solver="line_search") == "mpc-line_search"
    assert law(kind="mpc_drag", nodes=100) == "mpc_drag-line_search"
    assert law(kind="geometric", nodes=2, period=0.1, solver="line_search") == "geometric"

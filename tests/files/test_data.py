"""The built-in files: whatever is added to data/ is tested here without editing a test."""

import math

import numpy as np
import pytest

from hotlap.feasibility import describe
from hotlap.feasibility.race import unknown_latency
from hotlap.files.descriptions import Kind, load_quadrotor, load_race, load_track, names
from hotlap.race.gate_plane import plane_of
from hotlap.race.race import ControllerSettings, GateRule, JudgeSettings, NoiseSettings, PlanDynamics

TABLE_I = {"circle-20": 20, "circle-34": 34, "drop-20": 20, "flip-16": 16, "spiral-53": 53, "qualifier-20": 20, "final-22": 22}
DEFAULT = [*TABLE_I, "spiral20-53", "soccer-medium-20"]
AIRSIM = [name for name in names(Kind.RACE) if name.startswith("airsim-")]
PAPER = [*DEFAULT, *AIRSIM]
REAL = [name for name in names(Kind.RACE) if name.startswith("real-")]
GATES = [name for name in names(Kind.TRACK) if name.endswith("-gates")]


@pytest.mark.parametrize("name", names(Kind.TRACK))
def test_every_track_loads_and_says_where_it_is_from(name):
    track = load_track(name)
    assert track.provenance
    assert describe(track)


@pytest.mark.parametrize("name", names(Kind.QUADROTOR))
def test_every_quadrotor_loads_and_says_where_it_is_from(name):
    quadrotor = load_quadrotor(name)
    assert quadrotor.name == name
    assert quadrotor.provenance
    assert describe(quadrotor)


@pytest.mark.parametrize("name", names(Kind.RACE))
def test_every_race_loads_and_its_plan_leaves_the_vehicle_some_thrust(name):
    race = load_race(name)
    assert race.name == name
    assert race.provenance
    assert race.planning_model.max_acceleration < race.vehicle.max_acceleration * 1.0001
    assert race.planning_model.max_acceleration < race.controller.thrust[1]
    assert not race.planning.free, "its plan is fixed, so that results can be compared"
    assert all(plan <= limit for plan, limit in zip(race.planning_model.rate_limit, race.controller.rates, strict=True))


@pytest.mark.parametrize("name", PAPER)
def test_the_number_in_a_races_name_is_v_max(name):
    assert load_race(name).planning.v_max == float(name.rsplit("-", 1)[1])


@pytest.mark.parametrize(("name", "v_max"), TABLE_I.items())
def test_table_i_is_there(name, v_max):
    race = load_race(name)
    assert race.planning.v_max == v_max
    assert race.planning.tolerance == 0.2


@pytest.mark.parametrize("name", DEFAULT)
def test_the_default_suite_is_a_hummingbird_with_45_ms_that_its_controller_does_not_know_of(name):
    race = load_race(name)
    hummingbird = load_quadrotor("hummingbird")
    assert race.vehicle == hummingbird.model_copy(update={"delay": 0.045})
    assert race.control_model == hummingbird.model_copy(update={"rotor_drag": 0.0})
    assert unknown_latency(race) == 0.045
    assert race.controller == ControllerSettings(lag_lead=0.0, offset_free=False, reference_drag=False)
    assert race.noise == NoiseSettings()
    assert race.judge == JudgeSettings()


@pytest.mark.parametrize("name", AIRSIM)
def test_the_airsim_suite_is_its_own_quadrotor_judged_by_closest_approach(name):
    race = load_race(name)
    airsim = load_quadrotor("airsim")
    assert race.vehicle == airsim.model_copy(update={"delay": 0.0125})
    assert race.control_model == airsim.model_copy(update={"body_drag": (0.0, 0.0, 0.0)})
    assert (race.judge.rule, race.judge.distance, race.judge.window, race.judge.crash) == (GateRule.CLOSEST, 1.3, (1.0, 2.0), 10.0)
    assert race.controller == ControllerSettings(lag_lead=0.0, offset_free=False, reference_drag=False)
    assert race.noise == NoiseSettings()


@pytest.mark.parametrize("name", [*PAPER, "split-s"])
def test_what_reproduces_the_paper_has_its_gates_and_its_planning_model(name):
    race = load_race(name)
    assert not race.track.has_openings
    assert race.judge.rule is not GateRule.OPENING
    assert race.planning.dynamics is PlanDynamics.IDEAL


@pytest.mark.parametrize("name", REAL)
def test_the_real_suite_has_openings_and_one_setting_for_all(name):
    race, base = load_race(name), load_race("real-circle")
    assert race.judge.rule is GateRule.OPENING
    assert race.planning.model_copy(update={"nodes": base.planning.nodes, "v_max": base.planning.v_max}) == base.planning
    assert race.controller.lag_lead == 0.5
    assert (race.planning.v_max is None) == ("airsim" in name)
    assert race.planning.dynamics is PlanDynamics.FULL
    assert race.noise == NoiseSettings()
    assert race.control_model == race.vehicle, "controller and planner know the vehicle"
    vehicle = load_quadrotor("airsim-122m") if "airsim" in name else load_quadrotor("hummingbird").model_copy(update={"delay": 0.045})
    assert race.vehicle == vehicle
    assert race.controller.thrust[1] == pytest.approx(race.vehicle.max_acceleration, rel=2e-3)


def test_both_vehicles_fly_the_same_real_tracks():
    hummingbird = {load_race(name).track.name for name in REAL if "airsim" not in name}
    assert hummingbird == {load_race(name).track.name for name in REAL if "airsim" in name} == set(GATES)


@pytest.mark.parametrize("name", GATES)
def test_a_track_with_real_gates_has_the_positions_of_the_papers_and_looks_along_the_flight(name):
    real, plain = load_track(name), load_track(name.removesuffix("-gates"))
    assert np.array_equal(real.waypoints, plain.waypoints)
    points = np.vstack([real.start, real.waypoints])
    legs = np.diff(points, axis=0) / np.linalg.norm(np.diff(points, axis=0), axis=1)[:, None]
    for gate, before, behind in zip(real.counted, legs, legs[1:], strict=False):
        assert gate.side == 1.6
        assert gate.rotation[:, 0] @ (before + behind) > 0
    assert "inferred" in real.provenance


@pytest.mark.parametrize("name", [name for name in names(Kind.RACE) if load_race(name).track.has_openings])
def test_a_vehicle_fits_through_every_opening(name):
    race = load_race(name)
    rooms = [plane.room for gate in race.track.counted if (plane := plane_of(gate, race.judge.distance))]
    assert min(rooms) > 1.3 * race.vehicle.outer_radius


def test_the_airsim_vehicle_of_real_races_has_the_air_of_122_metres():
    old, new = load_quadrotor("airsim"), load_quadrotor("airsim-122m")
    thinner = 1.210716 / 1.225
    assert new.rotor_thrust[1] / old.rotor_thrust[1] == pytest.approx(thinner, rel=1e-4)
    assert np.divide(new.body_drag, old.body_drag) == pytest.approx([thinner] * 3, rel=1e-4)
    assert (new.mass, new.arm, new.inertia) == (old.mass, old.arm, old.inertia)


def test_only_qualifier_and_soccer_medium_are_planned_with_the_strong_model():
    strong = {name for name in names(Kind.RACE) if load_race(name).planning_model.name == "airsim-plan-strong"}
    assert strong == {"qualifier-20", "airsim-qualifier-20", "soccer-medium-20"}


def test_the_planning_models_have_the_ratios_that_were_recovered():
    for name in ("airsim-plan", "airsim-plan-strong"):
        plan = load_quadrotor(name)
        assert plan.torque_matrix[0, 0] / plan.inertia[0] == pytest.approx(23.0)
        assert (plan.gravity, plan.rate_limit) == (9.801, (10, 10, 0))
    split = load_quadrotor("split-s-plan")
    assert split.torque_matrix[0, 0] / split.inertia[0] == pytest.approx(150)
    assert split.torque_ratio / split.inertia[2] == pytest.approx(29.4, abs=0.02)
    assert split.thrust_to_weight == pytest.approx(2.4725)
    assert load_quadrotor("split-s-racer").thrust_to_weight == pytest.approx(3.3)


def test_the_hummingbirds_drag_and_rate_loop_are_rotors_own():
    hummingbird = load_quadrotor("hummingbird")
    assert hummingbird.rotor_drag == 8.06428e-5 / math.sqrt(8.54858e-6)
    assert hummingbird.rate_gain == (0.1 / 0.007, 0.1 / 0.007, 0.03 / 0.012)
    assert hummingbird.rotor_thrust[1] == pytest.approx(8.54858e-6 * 838**2, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "gates", "length"),
    [
        ("circle", 12, 120.0362),
        ("drop", 12, 134.0418),
        ("flip", 12, 165.2655),
        ("spiral", 12, 181.6554),
        ("spiral20", 20, 372.6611),
        ("qualifier", 20, 333.5836),
        ("final", 26, 507.2664),
        ("soccer-medium", 25, 473.9886),
        ("split-s", 20, 190.0512),
        ("togt-7g", 7, 80.5223),
        ("a2rl-10g", 10, 68.8843),
        ("lsy-level0", 4, 6.6296),
        ("iros2022", 4, 9.1325),
        ("flightgoggles-hard", 11, 223.3051),
        ("dynopt-7", 7, 193.3598),
    ],
)
def test_no_coordinate_has_moved(name, gates, length):
    track = load_track(name)
    legs = np.diff(np.vstack([track.start, track.waypoints]), axis=0)
    assert len(track.gates) == gates
    assert np.linalg.norm(legs, axis=1).sum() == pytest.approx(length, abs=1e-4)


def test_the_authors_end_lies_five_metres_behind_the_last_gate():
    for name in ("circle", "drop", "qualifier", "final", "soccer-medium"):
        track = load_track(name)
        assert track.end is not None
        last, before = track.gate_positions[-1], track.gate_positions[-2]
        expected = last + 5 * (last - before) / np.linalg.norm(last - before)
        assert track.end == pytest.approx(expected, abs=1e-3)


def test_what_was_inferred_says_so():
    assert "reconstructed" in load_track("final").name
    assert "beyond the vehicle" in load_race("airsim-final-22").provenance


@pytest.mark.parametrize(
    ("name", "mass", "thrust_to_weight", "source"),
    [
        ("cf21b-500", (0.03, 0.05), (1.5, 2.5), "drone-models"),
        ("three-inch", (0.15, 0.35), (4, 8), "2504.21586"),
        ("five-inch", (0.5, 0.8), (5, 9), "made up"),
        ("five-inch-delft", (0.5, 0.8), (9, 13), "2504.21586"),
        ("x500", (1.9, 2.1), (3, 5), "mrs_multirotor_simulator"),
    ],
)
def test_drones_of_every_size_are_built_in_and_say_where_they_are_from(name, mass, thrust_to_weight, source):
    quadrotor = load_quadrotor(name)
    assert mass[0] <= quadrotor.mass <= mass[1]
    assert thrust_to_weight[0] <= quadrotor.thrust_to_weight <= thrust_to_weight[1]
    assert source in quadrotor.provenance


IDENTIFIED = {  # per rotor at full speed: thrust [m/s^2], roll, pitch and yaw acceleration [rad/s^2]; w_max [rad/s], k_x and k_y, mean
    "three-inch": (14.3, 585.5, 232.75, 47.1, 4887.57, 3.545e-5),
    "five-inch-delft": (27.1, 711.0, 599.5, 35.2, 3295.50, 6.065e-5),
}


@pytest.mark.parametrize("name", IDENTIFIED)
def test_what_was_identified_is_what_the_estimates_of_mass_and_size_leave(name):
    quadrotor, (thrust, roll, pitch, yaw, fastest, drag) = load_quadrotor(name), IDENTIFIED[name]
    force = quadrotor.rotor_thrust[1]
    angular = np.abs(quadrotor.torque_matrix[:, 0]) * force / quadrotor.inertia_vector
    assert force / quadrotor.mass == pytest.approx(thrust, rel=0.01)
    assert angular == pytest.approx([roll, pitch, yaw], rel=0.01)
    assert quadrotor.rotor_drag * math.sqrt(force) / quadrotor.mass == pytest.approx(drag * fastest, rel=0.01)
    assert max(quadrotor.inertia) <= 0.91 * (quadrotor.inertia[0] + quadrotor.inertia[1])

import pytest

from hotlap.feasibility import Level, describe
from hotlap.feasibility.race import beyond, thrust_share, unknown_latency
from hotlap.files.descriptions import load_quadrotor, load_race, load_track
from hotlap.race.battery import Battery
from hotlap.race.track import Track


def findings(description, **options):
    return {finding.label: finding for finding in describe(description, **options)}


def changed(name, **changes):
    """A built-in race with some of its parts changed."""
    race = load_race(name)
    parts = {part: getattr(race, part).model_copy(update=values) for part, values in changes.items()}
    return race.model_copy(update=parts)


def test_a_tracks_figures():
    found = findings(load_track("drop"))
    assert found["gates"].value == "12"
    assert found["height"].value == "-2.0 to 18.0 m"
    assert found["sharpest turn"].remark == "at gate 5"
    assert findings(load_track("fastfly-n7"))["gates"].remark == "in 3 laps, the last one is the end"


def test_points_that_nearly_touch_are_noted():
    track = load_track("circle")
    assert findings(track)["closest points"].level is Level.FACT
    assert findings(track.model_copy(update={"start": (0.0, -1.9, -2.02)}))["closest points"].level is Level.NOTE


def test_a_start_a_point_or_a_ball_within_an_obstacle_is_a_warning():
    poles = [{"position": position, "radius": 0.3} for position in ((0.1, 0.0), (5.0, 0.1), (9.0, 0.0))]
    gates = [{"position": (5.0, 0.0, 1.0)}, {"position": (9.0, 0.0, 1.0), "radius": 0.2}, {"position": (9.0, 5.0, 1.0), "radius": 0.2}]
    track = {"name": "yard", "start": (0.0, 0.0, 1.0), "gates": gates, "laps": 2, "poles": poles}
    found = [finding for finding in describe(Track.model_validate(track)) if finding.level is Level.WARNING]
    assert [(one.value, one.remark.partition(":")[0]) for one in found] == [
        ("the start", "within pole 1"),
        ("gate 1", "within pole 2"),
        ("gate 2", "within pole 3"),
    ]
    beside = [{**pole, "position": (pole["position"][0], 0.35)} for pole in poles]
    assert not any(finding.level is Level.WARNING for finding in describe(Track.model_validate({**track, "poles": beside})))


def test_a_start_within_the_frame_of_a_gate_is_a_warning_and_an_opening_with_a_pole_in_it_is_none():
    gate = {"position": (5.0, 0.0, 1.0), "yaw": 0.0, "side": 2.0, "frame": 0.3, "depth": 0.1}
    track = {"name": "yard", "start": (5.0, 1.1, 1.0), "gates": [gate], "poles": [{"position": (5.0, 0.0), "radius": 0.1}]}
    (found,) = (finding for finding in describe(Track.model_validate(track)) if finding.level is Level.WARNING)
    assert (found.label, found.value) == ("inside an obstacle", "the start")
    assert found.remark.startswith("within the frame of gate 1")


def test_a_quadrotors_figures():
    found = findings(load_quadrotor("airsim"))
    assert found["thrust-to-weight"].value == "1.70"
    assert found["hover throttle"].value == "59%"
    assert found["top speed"].value == "23.1 m/s"


def test_slow_motors_behind_a_fast_rate_loop_are_a_warning():
    quick = load_quadrotor("hummingbird").model_copy(update={"rate_gain": (60.0, 60.0, 8.0)})
    assert findings(quick)["rate loop damping"].level is Level.WARNING
    assert findings(load_quadrotor("hummingbird"))["rate loop damping"].level is Level.FACT


def test_a_race_says_what_the_controller_does_not_know():
    found = findings(load_race("circle-34"), top_speed=20.0)
    assert found["controller's model"].remark == "differs in rotor_drag, delay"
    assert found["unknown latency"].value == "45 ms"
    assert found["unknown latency"].remark.startswith("0.90 m at top speed")
    assert findings(load_race("split-s"))["unknown latency"].remark == "the controller knows its dead time"


def test_a_prediction_over_part_of_the_lag_is_no_unknown_latency():
    race, words = load_race("real-circle"), "the controller knows its dead time, and predicts {} ms further, over part of the lag"
    assert findings(race)["unknown latency"].remark == words.format(44), "by lag_lead"
    longer = {"model": race.vehicle.model_copy(update={"delay": 0.09}), "controller": race.controller.model_copy(update={"lag_lead": 0.0})}
    assert findings(race.model_copy(update=longer))["unknown latency"].remark == words.format(45), "by a longer dead time of the model"
    whole = race.model_copy(update={"controller": race.controller.model_copy(update={"lag_lead": 1.0})})
    assert findings(whole)["unknown latency"].value == "0 ms"
    beyond_lag = {"model": race.vehicle.model_copy(update={"delay": 0.16})}
    assert findings(race.model_copy(update=beyond_lag))["unknown latency"].value == "-115 ms"


def test_a_vehicle_that_is_heavier_than_its_model_is_noted():
    race = load_race("split-s").model_copy(update={"model": None})
    assert "unknown mass" not in findings(race)

    def weighing(factor):
        """The same race where the drone has other weight than the control model."""
        return race.model_copy(update={"model": race.vehicle.model_copy(update={"mass": race.vehicle.mass / factor})})

    heavier, lighter = findings(weighing(1.08)), findings(weighing(0.92))
    assert (heavier["unknown mass"].value, heavier["unknown mass"].level) == ("8.0%", Level.NOTE)
    assert heavier["unknown mass"].remark.startswith("heavier than the control model")
    assert lighter["unknown mass"].remark.startswith("lighter")


def test_gates_in_centimetres_are_noted():
    track = load_track("drop")
    far = track.model_copy(
        update={"gates": tuple(gate.model_copy(update={"position": tuple(100 * x for x in gate.position)}) for gate in track.gates)}
    )
    assert (findings(track)["length"].level, findings(far)["length"].level) == (Level.FACT, Level.NOTE)
    assert findings(far)["length"].remark.endswith("gates are in metres")


def test_a_controller_that_does_not_predict_knows_no_latency():
    race = load_race("circle-34").model_copy(update={"model": None})
    assert unknown_latency(race) == 0
    assert unknown_latency(race.model_copy(update={"controller": race.controller.model_copy(update={"predict": False})})) == 0.045


def test_a_plan_that_takes_all_thrust_is_a_warning():
    race = changed("circle-34", vehicle={"rotor_thrust": (0.0, 2.9)})
    assert thrust_share(race) == pytest.approx(16 / (11.6 / 0.716))
    found = findings(race)["plan uses"]
    assert found.level is Level.WARNING
    assert "no tuner will help" in found.remark
    assert beyond(race) == "beyond the vehicle"


def test_a_plan_that_may_not_use_enough_thrust_to_hover_is_a_warning():
    race = changed("circle-34", vehicle={"rotor_thrust": (0.0, 2.0)})
    race = race.model_copy(update={"model": None, "planning": type(race.planning)()})
    assert race.vehicle.thrust_to_weight > 1 > race.planning_model.thrust_to_weight
    found = findings(race)
    assert found["plan cannot hover"].level is Level.WARNING
    assert beyond(race) == "no plan"
    assert "plan cannot hover" not in findings(load_race("circle-34"))


def test_a_drone_without_drag_is_said_to_have_none():
    plain = load_quadrotor("hummingbird")
    assert findings(plain)["top speed"].remark == "its drag does not hold it below 100 m/s"
    assert findings(plain.model_copy(update={"rotor_drag": 0.0}))["top speed"].remark == "no drag is given"


def test_limits_of_the_controller_that_bind_are_warnings():
    found = findings(changed("split-s", controller={"thrust": (0.1, 20.0), "rates": (10.0, 10.0, 3.0)}))
    assert found["thrust limit binds"].level is Level.WARNING
    assert found["roll rate limit binds"].value == "10 rad/s"
    assert "yaw rate limit binds" not in found
    assert "controller limits" in findings(load_race("split-s"))


def test_the_final_at_22_is_beyond_airsims_quadrotor_by_its_figures_alone():
    assert beyond(load_race("airsim-final-22")) == "beyond the vehicle"
    assert beyond(load_race("airsim-final-21")) == ""


def test_nothing_is_called_easy_or_hard_before_it_was_flown():
    words = {"easy", "moderate", "hard"}
    assert not any(words & set(f"{finding.value} {finding.remark}".split()) for finding in describe(load_race("circle-34")))


def test_a_plan_that_the_controller_caps_is_said_to_be():
    race = load_race("split-s")
    race = race.model_copy(update={"planning": type(race.planning)(thrust_share=0.9)})
    strong = race.control_model.max_acceleration
    tight, wide = (
        race.model_copy(update={"controller": race.controller.model_copy(update={"thrust": (0.1, k * strong)})}) for k in (0.9, 1.0)
    )
    assert findings(tight)["thrust limit caps the plan"].value == f"{0.95 * 0.9 * strong:.1f} m/s^2"
    assert "thrust limit caps the plan" not in findings(wide)


def test_a_battery_is_said_where_there_is_one():
    drone = load_quadrotor("hummingbird")
    assert "battery sag" not in findings(drone)
    assert findings(drone.model_copy(update={"battery": Battery(sag=0.15)}))["battery sag"].value == "15%"
    counted = drone.model_copy(update={"battery": Battery(sag_per_ampere_hour=0.6, hover_current=20.0)})
    assert findings(counted)["battery sag"].value == "20.0%", "20 A for a minute are a third of an ampere-hour"

"""A flight's result depends on its race, parameters, seed and vehicle_parameters alone; a batch is only a way to fly many."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from flight.scenarios import BORDER, GATE_TIMES, TUNED, fly, make_reference, make_scenario, parameters
from hotlap.core.errors import HotlapError
from hotlap.core.records import End, Flights
from hotlap.files.descriptions import load_race
from hotlap.flight.fly import fly_batch
from hotlap.flight.numbers import Numbers, best_numbers
from hotlap.planning.preparation import prepare
from hotlap.race import vehicle_parameters as columns
from hotlap.race.controllers import ControllerKind
from hotlap.race.race import SegmentSwitch
from hotlap.race.vehicle_parameters import VEHICLE_PARAMETERS, vehicle_parameters_of
from hotlap.reference.segmentation import SegmentClass, Segments

NOISE = {"thrust": 0.02, "rates": 0.1, "thrust_bias": 0.01, "position": 0.05, "velocity": 0.05, "attitude": 0.01}
NOISY = make_scenario(noise=NOISE, judge={"distance": 0.35})  # so tight that some flights miss
SCATTERED = parameters(40) * np.exp(0.4 * np.random.default_rng(0).standard_normal((40, 2, 5)))
PER_FLIGHT = ("gates_passed", "end", "end_time", "end_position", "lap_time", "clock_distance", "closest_distance", "closest_time")


def assert_same(one: Flights, rows, other: Flights, places) -> None:
    """Rows of one batch equal places of the other, bit for bit."""
    for name in (*PER_FLIGHT, "mean_error", "max_error"):
        np.testing.assert_array_equal(getattr(one, name)[rows], getattr(other, name)[places], err_msg=name)


@pytest.fixture(scope="module")
def whole() -> Flights:
    return fly(NOISY, SCATTERED)


def test_flights_of_the_batch_end_in_more_than_one_way(whole):
    assert 5 < whole.gates_passed.sum() < 5 * len(whole)
    assert len(set(whole.end.tolist())) > 1


@pytest.mark.parametrize("numbers", [best_numbers(), Numbers.FLOAT64])
def test_a_flight_is_the_same_alone_at_any_place_and_in_any_order(numbers):
    flown = fly(NOISY, SCATTERED[:12], numbers=numbers)
    order = np.random.default_rng(1).permutation(12)
    assert_same(fly(NOISY, SCATTERED[order], numbers=numbers, seeds=order), slice(None), flown, order)
    for i in (0, 7, 11):
        assert_same(fly(NOISY, SCATTERED[i : i + 1], numbers=numbers, seeds=[i]), slice(None), flown, [i])


def test_threads_and_logs_change_nothing(whole):
    assert_same(fly(NOISY, SCATTERED, threads=2), slice(None), whole, slice(None))
    assert_same(fly(NOISY, SCATTERED, log=[3, 17]), slice(None), whole, slice(None))


def test_the_same_seed_is_the_same_noise_and_another_is_not():
    flown = fly(NOISY, 3, seeds=[5, 5, 6])
    assert_same(flown, [0], flown, [1])
    assert flown.mean_error[0] != flown.mean_error[2]


def test_lanes_fly_as_plain_floats_do_while_flights_are_stable():
    scenario = make_scenario(noise=NOISE)
    lanes, scalar = fly(scenario, 8, log=range(8)), fly(scenario, 8, numbers="float64", log=range(8))
    np.testing.assert_array_equal(lanes.gates_passed, scalar.gates_passed)
    apart = [np.abs(lanes.logs[i].states[:, :3] - scalar.logs[i].states[:, :3]).max() for i in range(8)]
    assert 0 < max(apart) < 2e-4


@pytest.mark.parametrize("kind", [ControllerKind.MPC, pytest.param(ControllerKind.GEOMETRIC, marks=pytest.mark.check)])
@pytest.mark.parametrize("period", [0.005, 0.02])
def test_a_path_with_rows_at_another_period_is_the_same_path(period, kind):
    usual = make_scenario(noise=NOISE)
    usual = replace(usual, race=usual.race.with_controller(kind))
    asked = np.tile(usual.space.default if kind is ControllerKind.GEOMETRIC else TUNED, (8, 2, 1))
    flown, expected = fly(replace(usual, reference=make_reference(period)), asked), fly(usual, asked)
    assert (expected.gates_passed == 5).all()
    np.testing.assert_array_equal(flown.gates_passed, expected.gates_passed)
    np.testing.assert_allclose(flown.mean_error, expected.mean_error, rtol=0.1)
    np.testing.assert_allclose(flown.clock_distance, expected.clock_distance, atol=0.02)


def test_the_order_of_the_columns_of_vehicles_is_written_once(monkeypatch):
    """In another order, the same vehicles fly the same flights."""
    rows = np.random.default_rng(0).uniform(0.9, 1.1, (8, len(VEHICLE_PARAMETERS))) * vehicle_parameters_of(NOISY.race.vehicle)
    expected, drawn = fly(NOISY, 8, vehicle_parameters=rows), fly(NOISY, 8)
    order = np.random.default_rng(1).permutation(len(VEHICLE_PARAMETERS))
    monkeypatch.setattr(columns, "VEHICLE_PARAMETERS", tuple(VEHICLE_PARAMETERS[i] for i in order))
    assert_same(fly(NOISY, 8, vehicle_parameters=rows[:, order]), slice(None), expected, slice(None))
    assert_same(fly(NOISY, 8), slice(None), drawn, slice(None))


def test_a_real_race_is_flown_alike_by_lanes_and_plain_floats():
    scenario = prepare("circle-34")
    asked = np.tile(TUNED, (8, len(scenario.segments), 1))
    lanes, scalar = (fly_batch(scenario, asked, np.arange(8), numbers=kind)[0] for kind in (best_numbers(), Numbers.FLOAT64))
    assert (lanes.end == End.FINISHED).sum() >= 7
    np.testing.assert_array_equal(lanes.gates_passed, scalar.gates_passed)
    np.testing.assert_allclose(lanes.mean_error, scalar.mean_error, atol=2e-3)


def test_a_vehicle_acts_on_its_flight_alone_and_that_of_the_race_changes_nothing(whole):
    vehicle_parameters = np.tile(vehicle_parameters_of(NOISY.race.vehicle), (40, 1))
    assert_same(fly(NOISY, SCATTERED, vehicle_parameters=vehicle_parameters), slice(None), whole, slice(None))
    vehicle_parameters[4, VEHICLE_PARAMETERS.index("mass")] *= 1.3
    heavy = fly(NOISY, SCATTERED, vehicle_parameters=vehicle_parameters)
    others = np.delete(np.arange(40), 4)
    assert_same(heavy, others, whole, others)
    assert heavy.mean_error[4] != whole.mean_error[4]


def test_without_noise_and_with_a_true_model_the_reference_is_kept():
    flown = fly(make_scenario())
    assert flown.end.tolist() == [End.FINISHED]
    assert flown.max_error[0] < 0.25
    np.testing.assert_allclose(flown.lap_time, GATE_TIMES[-1])


def test_a_controller_that_knows_its_dead_time_flies_what_one_that_does_not_cannot():
    """Default weights on circle-34 with its 45 ms: compensate first, tune second."""
    race = load_race("circle-34")
    knowing = race.model_copy(update={"model": race.control_model.model_copy(update={"delay": race.vehicle.delay})})
    complete = []
    for flown in (race, knowing):
        scenario = prepare(flown)
        asked = np.repeat(scenario.space.first_guess(len(scenario.segments))[None], 32, axis=0)
        flights = fly_batch(scenario, asked, np.arange(32), numbers=best_numbers())[0]
        complete.append(int((flights.end == End.FINISHED).sum()))
    assert complete[1] == 32
    assert complete[0] < 28


def test_a_command_acts_when_its_dead_time_is_over():
    """Rotors hover until the first command arrives, 2 periods and 3 steps after it was given."""
    log = fly(make_scenario({"delay": 0.0275}), log=[0]).logs[0]
    hover = log.rotor_thrusts[0]
    changed = np.abs(log.rotor_thrusts - hover).max(axis=1) > 1e-5 * hover.max()
    assert log.times[np.argmax(changed)] == pytest.approx(0.03)
    soon = fly(make_scenario({"delay": 0.02}), log=[0]).logs[0]
    assert soon.times[np.argmax(np.abs(soon.rotor_thrusts - hover).max(axis=1) > 1e-5 * hover.max())] == pytest.approx(0.03)
    sooner = fly(make_scenario({"delay": 0.0175}), log=[0]).logs[0]
    assert sooner.times[np.argmax(np.abs(sooner.rotor_thrusts - hover).max(axis=1) > 1e-5 * hover.max())] == pytest.approx(0.02)


def test_weights_of_a_segment_act_from_its_beginning():
    asked = parameters(2)
    asked[1, 1, :4] *= 0.3
    logs = fly(make_scenario(), asked, seeds=[0, 0], log=[0, 1]).logs
    differ = np.flatnonzero(np.any(logs[0].commands != logs[1].commands, axis=1))
    assert logs[0].times[differ[0]] == pytest.approx(BORDER)


def test_weights_for_each_node_change_nothing_where_all_segments_are_alike():
    by_node, by_time = (
        make_scenario(noise=NOISE, controller={"segment_switch": segment_switch})
        for segment_switch in (SegmentSwitch.NODE, SegmentSwitch.TIME)
    )
    assert_same(fly(by_node, 8), slice(None), fly(by_time, 8), slice(None))


@pytest.mark.parametrize("segment_switch", [SegmentSwitch.NODE, SegmentSwitch.DISTANCE])
def test_the_next_segment_may_act_before_its_beginning(segment_switch):
    asked = parameters(2)
    asked[1, 1, :4] *= 0.3
    logs = fly(
        make_scenario(controller={"segment_switch": segment_switch, "segment_switch_distance": 3.0}), asked, seeds=[0, 0], log=[0, 1]
    ).logs
    differ = np.flatnonzero(np.any(logs[0].commands != logs[1].commands, axis=1))
    assert logs[0].times[differ[0]] < BORDER


def test_a_log_is_the_flight_at_every_control_step():
    scenario = make_scenario(noise=NOISE)
    flown = fly(scenario, 1, log=[0])
    log, settings = flown.logs[0], scenario.race.controller
    np.testing.assert_allclose(np.diff(log.times), settings.period)
    assert log.times[-1] == pytest.approx(GATE_TIMES[-1], abs=settings.period)
    assert log.states.shape == (len(log.times), 13)
    low, high = scenario.race.vehicle.rotor_thrust
    assert low <= log.rotor_thrusts.min() <= log.rotor_thrusts.max() <= high * (1 + 1e-6)
    assert settings.thrust[0] <= log.commands[:, 0].min() + 1e-6
    assert log.commands[:, 0].max() <= settings.thrust[1] + 1e-6
    assert (np.abs(log.commands[:, 1:]).max(axis=0) <= np.array(settings.rates) + 1e-6).all()
    np.testing.assert_allclose(np.linalg.norm(log.states[:, 3:7], axis=1), 1, atol=1e-5)
    reference = scenario.reference.position_at(log.times)
    errors = np.linalg.norm(log.states[1:, :3] - reference[1:], axis=1)
    assert flown.mean_error[0] == pytest.approx(errors.mean(), rel=1e-4)
    assert flown.max_error[0] == pytest.approx(errors.max(), rel=1e-4)


def test_a_flight_ends_at_its_first_miss():
    flown = fly(make_scenario(judge={"distance": 1e-6}))
    assert (flown.end[0], flown.gates_passed[0]) == (End.MISSED, 0)
    assert flown.end_time[0] == GATE_TIMES[0]
    assert np.isnan(flown.clock_distance[0, 1:]).all()


@pytest.mark.parametrize(
    "noise", [{name: value} for name, value in NOISE.items()] + [{"measured_position": 0.1}, {"measured_velocity": 0.1}, {"wind": 1.0}]
)
def test_every_kind_of_noise_makes_flights_differ(noise):
    quiet, noisy = fly(make_scenario(), 2), fly(make_scenario(noise=noise), 2)
    assert quiet.mean_error[0] == quiet.mean_error[1]
    assert len({quiet.mean_error[0], *noisy.mean_error.tolist()}) == 3


def test_lane_steps_are_counted_and_refilled():
    numbers = best_numbers()
    _, effort = fly_batch(NOISY, np.tile(SCATTERED, (2, 1, 1)), np.arange(80), numbers=numbers, threads=1)
    assert effort.lane_steps % numbers.lanes == 0
    assert 0.75 < effort.useful_share < 1
    _, alone = fly_batch(NOISY, SCATTERED[:1], np.arange(1), numbers=numbers, threads=1)
    assert alone.useful_share == 1 / numbers.lanes


def test_no_flights_are_no_flights():
    assert len(fly(make_scenario(), 0)) == 0


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"asked": np.ones((2, 1, 5))}, "parameters must have shape"),
        ({"asked": parameters(2) * np.nan}, "finite and positive"),
        ({"asked": -parameters(2)}, "finite and positive"),
        ({"seeds": [-1, 0]}, "seeds must not be negative"),
        ({"seeds": [0, 2**53]}, "seeds must not be negative"),
        ({"vehicle_parameters": np.ones((1, len(VEHICLE_PARAMETERS)))}, "a row for each of 2 flights"),
        ({"vehicle_parameters": np.ones((2, 3))}, "must have the columns"),
        ({"log": [2]}, "log must name flights"),
        ({"log": [0, 0]}, "log must name flights"),
    ],
)
def test_what_does_not_fit_is_refused(change, reason):
    options = {"seeds": [0, 1], **change}
    with pytest.raises(HotlapError, match=reason):
        fly(make_scenario(), options.pop("asked", parameters(2)), **options)


def test_records_have_a_row_for_every_flight(whole):
    for field in fields(Flights):
        if field.name in PER_FLIGHT:
            assert len(getattr(whole, field.name)) == 40


def test_pieces_of_one_segment_fly_with_its_weights():
    """Three pieces of which the first and the last share, and three segments of which two are given the same values."""
    scenario, (a, b) = make_scenario(noise=NOISE), SCATTERED[0]
    starts, kinds = np.array([0.0, 0.8, BORDER]), (SegmentClass.ASCENT, SegmentClass.FLAT, SegmentClass.ASCENT)
    shared, apart = (replace(scenario, segments=Segments(starts, kinds, scenario.segments.duration, owners)) for owners in ((0, 1, 0), ()))
    one, other = fly(shared, np.array([[a, b]] * 8)), fly(apart, np.array([[a, b, a]] * 8))
    assert_same(one, slice(None), other, slice(None))
    assert one.gate_segments.tolist() == shared.segments.at(one.gate_times).tolist()
    assert set(one.gate_segments.tolist()) <= {0, 1}
    assert not np.array_equal(fly(apart, np.array([[a, b, b]] * 8)).mean_error, one.mean_error)

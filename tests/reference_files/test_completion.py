"""What a file leaves out follows from the rest."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.files.descriptions import load_quadrotor
from hotlap.race.race import PlanDynamics, Race
from hotlap.race.track import Gate
from hotlap.reference.attitude import rotate, thrust_axis
from hotlap.reference.reference import Reference, row_times
from hotlap.reference.run_out import extend
from hotlap.reference_files import flatness
from hotlap.reference_files.csv import ReadReference, read_reference, save_reference
from hotlap.reference_files.thrust_vectors import planned_thrust

from .flights import RACE, Q, U, V, W, assert_same_flight, changed, some, stack, tilt, write


def accelerations(reference: Reference) -> dict[str, np.ndarray]:
    """Of the planned rows and the last one, from thrust, gravity and drag."""
    rows = reference.planned_rows + 1
    vectors = thrust_axis(reference.attitude[:rows]) * reference.thrust[:rows, None] - RACE.planning_drag * reference.velocity[:rows]
    vectors[:, 2] -= RACE.planning_model.gravity
    return dict(zip(("a_x", "a_y", "a_z"), vectors.T, strict=True))


LESS = {
    "thrusts": (Q, V, W),
    "rates and thrusts": (Q, V),
    "attitudes, rates and thrusts": (V,),
    "all but positions": (),
    "velocities": (Q, W, U),
    "rates": (Q, V, U),
    "velocities, rates and thrusts": (Q,),
}


@pytest.mark.parametrize("kept", LESS.values(), ids=LESS)
def test_what_is_left_out_follows_from_the_rest(whole, reference, tmp_path, kept):
    read = read_reference(write(tmp_path / "less.csv", some(whole, *kept)), RACE)
    assert_same_flight(read.reference, reference)
    assert read.notes
    assert all("follow" in note for note in read.notes)


def test_a_whole_file_needs_no_remark(whole, tmp_path):
    assert read_reference(write(tmp_path / "whole.csv", whole), RACE).notes == ()


def test_given_accelerations_count(whole, reference, tmp_path):
    path = write(tmp_path / "less.csv", {**some(whole, V), **accelerations(reference)})
    read = read_reference(path, RACE)
    assert_same_flight(read.reference, reference)
    rows = reference.planned_rows
    assert_allclose(read.reference.thrust[:rows], reference.thrust[:rows], atol=1e-6)  # jumps included


def test_accelerations_that_are_none_of_these_velocities_are_left_out(whole, reference, tmp_path):
    read = read_reference(write(tmp_path / "less.csv", {**some(whole, V), **dict.fromkeys(("a_x", "a_y", "a_z"), 0 * whole["t"])}), RACE)
    assert any("a_x, a_y, a_z are not the derivative of the velocities: left out" in note for note in read.notes)
    assert_same_flight(read.reference, reference)


def test_positions_in_millimetres_are_enough_for_the_attitudes(whole, reference, tmp_path):
    rounded = {name: np.round(values, 3) for name, values in some(whole).items()}
    found = read_reference(write(tmp_path / "less.csv", rounded), RACE).reference
    assert np.quantile(tilt(found, reference), 0.9) < 3


def test_rotor_thrusts_that_follow_turn_the_drone_as_it_turns(whole, reference, tmp_path):
    found = read_reference(write(tmp_path / "less.csv", some(whole, V)), RACE).reference
    rows = reference.planned_rows
    assert found.rotor_thrusts[:rows].min() >= 0
    assert_allclose(found.rotor_thrusts[:rows].sum(axis=1), RACE.planning_model.mass * found.thrust[:rows])
    assert np.median(np.abs(found.rotor_thrusts[:rows] - reference.rotor_thrusts[:rows])) < 0.05


def test_a_yaw_turns_the_attitudes_and_leaves_the_thrust_where_it_is(whole, reference, tmp_path):
    yaw = 0.4 * whole["t"]
    plain = read_reference(write(tmp_path / "less.csv", some(whole, V)), RACE).reference
    found = read_reference(write(tmp_path / "yawed.csv", {**some(whole, V), "yaw_deg": np.degrees(yaw)}), RACE).reference
    rows = reference.planned_rows
    assert_allclose(thrust_axis(found.attitude[:rows]), thrust_axis(plain.attitude[:rows]), atol=1e-6)
    left = rotate(found.attitude[:rows], np.tile([0.0, 1.0, 0.0], (rows, 1)))
    heading = np.column_stack([np.cos(yaw), np.sin(yaw), 0 * yaw])[:rows]
    assert_allclose((left * heading).sum(axis=1), 0, atol=1e-6)


def test_roll_pitch_and_yaw_are_attitudes(whole, reference, tmp_path):
    w, x, y, z = stack(whole, Q).T
    angles = {
        "roll": np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
        "pitch": np.arcsin(np.clip(2 * (w * y - z * x), -1, 1)),
        "yaw": np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    }
    read = read_reference(write(tmp_path / "angles.csv", {**some(whole, V), **angles}), RACE)
    assert_same_flight(read.reference, reference)
    assert any("attitudes are those of roll, pitch and yaw" in note for note in read.notes)


def test_thrusts_that_do_not_belong_to_the_accelerations_are_left_out_and_that_is_said(whole, reference, tmp_path):
    read = read_reference(write(tmp_path / "odd.csv", changed(whole, U, 0 * stack(whole, U))), RACE)
    assert "u_1 to u_4 do not explain the accelerations and are left out" in read.notes[-1]
    assert_same_flight(read.reference, reference)


def with_drags() -> tuple[Race, Reference]:
    """A race that plans with all drags of its vehicle, and a circle that is flown with these."""
    race = RACE.model_copy(
        update={
            "vehicle": load_quadrotor("airsim"),
            "model": None,
            "planning": RACE.planning.model_copy(update={"quadrotor": None, "v_max": None, "dynamics": PlanDynamics.FULL}),
        }
    )
    times, speed = row_times(6.0), 2.0
    angle = np.column_stack([speed / 6.0 * (times**2 / 2), np.zeros_like(times)])[:, 0]  # ever faster on a circle of 6 m
    position = 6.0 * np.column_stack([np.sin(angle), 1 - np.cos(angle), 0 * angle]) + [0.0, 0.0, 2.0]
    turn = speed / 6.0 * times
    velocity = (6.0 * turn)[:, None] * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    across = np.column_stack([-np.sin(angle), np.cos(angle), 0 * angle])
    acceleration = speed * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]) + (6.0 * turn**2)[:, None] * across
    vectors = planned_thrust(race, velocity, acceleration)
    attitude = flatness.attitudes_along(vectors, np.array([1.0, 0.0, 0.0, 0.0]))
    rates, thrust = flatness.rates_of(attitude, 0.01), flatness.along_axis(vectors, attitude)
    rotors = flatness.rotor_thrusts(race.planning_model, thrust, rates, 0.01)
    reference = Reference(position, attitude, velocity, rates, thrust, rotors, np.array([6.0]), 6.0)
    track = race.track.model_copy(update={"start": (0.0, 0.0, 2.0), "gates": (Gate(position=tuple(position[-1].tolist())),), "end": None})
    return race.model_copy(update={"track": track}), extend(reference, race.planning_model.gravity, race.planning_drag)


def test_a_plan_with_all_drags_is_read_back_without_a_remark(tmp_path):
    race, reference = with_drags()
    save_reference(tmp_path / "flight.csv", reference)
    read = read_reference(tmp_path / "flight.csv", race)
    assert read.notes == ()
    rows = reference.planned_rows
    assert_allclose(read.reference.thrust[: rows - 1], reference.thrust[: rows - 1], rtol=1e-9)


def test_attitudes_that_follow_lean_against_all_drags(tmp_path):
    race, reference = with_drags()
    save_reference(tmp_path / "flight.csv", reference)
    with (tmp_path / "flight.csv").open() as file:
        rows = [row[:4] + row[8:11] for row in csv.reader(file)]
    (tmp_path / "less.csv").write_text("\n".join(",".join(row) for row in rows))
    found: ReadReference = read_reference(tmp_path / "less.csv", race)
    assert np.quantile(tilt(found.reference, reference), 0.98) < 0.5
    dragless = race.model_copy(update={"vehicle": race.vehicle.model_copy(update={"body_drag": (0.0, 0.0, 0.0)})})
    assert np.quantile(tilt(read_reference(tmp_path / "less.csv", dragless).reference, reference), 0.98) > 1.5

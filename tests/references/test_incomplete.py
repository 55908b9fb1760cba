"""What a file leaves out follows from the rest, what it says otherwise is understood, and what does not belong together is refused."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.core.errors import InputError
from hotlap.files.descriptions import load_quadrotor
from hotlap.race.race import PlanDynamics, Race
from hotlap.race.track import Gate
from hotlap.reference.attitude import CONJUGATE, product, rotate, thrust_axis
from hotlap.reference.reference import Reference, row_times
from hotlap.reference.run_out import extend
from hotlap.references import flatness
from hotlap.references.csv import COLUMNS, ReadReference, read_reference, save_reference
from hotlap.references.thrust_vectors import planned_thrust
from planning import small

Columns = dict[str, np.ndarray]

RACE = small.RACES["drag"]
P, Q, V, W = ("p_x", "p_y", "p_z"), ("q_w", "q_x", "q_y", "q_z"), ("v_x", "v_y", "v_z"), ("w_x", "w_y", "w_z")
U = ("u_1", "u_2", "u_3", "u_4")


@pytest.fixture(scope="module")
def reference() -> Reference:
    """A plan with its run-out."""
    return extend(small.planned("drag")[3], RACE.planning_model.gravity, RACE.planning_drag)


@pytest.fixture(scope="module")
def whole(reference, tmp_path_factory) -> Columns:
    """The columns of its file."""
    path = tmp_path_factory.mktemp("whole") / "flight.csv"
    save_reference(path, reference)
    return dict(zip(COLUMNS, np.genfromtxt(path, delimiter=",", skip_header=1).T, strict=True))


def write(path: Path, columns: Columns, *, separator: str = ",", header: bool = True) -> Path:
    """Columns as a file."""
    lines = [separator.join(columns)] if header else []
    lines += [separator.join(map(repr, row)) for row in np.column_stack(list(columns.values())).tolist()]
    path.write_text("\n".join(lines) + "\n")
    return path


def some(whole: Columns, *groups: tuple[str, ...]) -> Columns:
    """Time, position and some of the other columns."""
    return {name: whole[name] for name in ("t", *P, *(name for group in groups for name in group))}


def changed(whole: Columns, names: tuple[str, ...], values: np.ndarray) -> Columns:
    """The columns with some of them replaced."""
    return {**whole, **dict(zip(names, values.T, strict=True))}


def stack(whole: Columns, names: tuple[str, ...]) -> np.ndarray:
    return np.column_stack([whole[name] for name in names])


def accelerations(reference: Reference) -> dict[str, np.ndarray]:
    """Of the planned rows and the last one, from thrust, gravity and drag."""
    rows = reference.planned_rows + 1
    vectors = thrust_axis(reference.attitude[:rows]) * reference.thrust[:rows, None] - RACE.planning_drag * reference.velocity[:rows]
    vectors[:, 2] -= RACE.planning_model.gravity
    return dict(zip(("a_x", "a_y", "a_z"), vectors.T, strict=True))


def tilt(found: Reference, expected: Reference) -> np.ndarray:
    """Angles between the thrust axes of planned rows [deg]."""
    rows = expected.planned_rows
    cosines = (thrust_axis(found.attitude[:rows]) * thrust_axis(expected.attitude[:rows])).sum(axis=1)
    return np.degrees(np.arccos(np.clip(cosines, -1, 1)))


def assert_same_flight(found: Reference, expected: Reference, *, rates: float = 0.05, thrust: float = 0.1) -> None:
    """In the middle of the rows: where thrusts jump, differences cannot tell on which side of a row."""
    rows = expected.planned_rows
    assert_allclose(found.position[:rows], expected.position[:rows], atol=1e-6)
    assert np.median(tilt(found, expected)) < 0.1
    assert np.quantile(tilt(found, expected), 0.95) < 1.0
    turned = np.abs((found.attitude[:rows] * expected.attitude[:rows]).sum(axis=1))
    assert np.degrees(2 * np.arccos(min(np.median(turned), 1.0))) < 1.0
    assert np.median(np.abs(found.rates[:rows] - expected.rates[:rows])) < rates
    assert np.median(np.abs(found.thrust[:rows] - expected.thrust[:rows])) < thrust
    assert_allclose(found.gate_times, expected.gate_times, atol=0.02)


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


def text_with(whole: Columns, change: Callable[[str], str], *, header: bool = True) -> str:
    """The file as text, changed."""
    names, rows = ",".join(whole), np.column_stack(list(whole.values())).tolist()
    return change("\n".join([names] * header + [",".join(map(repr, row)) for row in rows]) + "\n")


FORMS: dict[str, tuple[Callable[[str], str], bool, str]] = {
    "semicolons": (lambda text: text.replace(",", ";"), True, ""),
    "tabs": (lambda text: text.replace(",", "\t"), True, ""),
    "spaces": (lambda text: text.replace(",", "  "), True, ""),
    "decimal commas": (lambda text: text.replace(",", ";").replace(".", ","), True, "decimal commas are read as points"),
    "comments": (lambda text: "# made by hand\n" + text.replace("\n", "\n% a remark\n", 3), True, ""),
    "a header that is a comment": (lambda text: "# " + text.replace(",", " "), True, ""),
    "no header": (lambda text: text, False, "it has no header; its 18 columns are read as t, p_x, p_y"),
    "no header but an index": (
        lambda text: "\n".join(f"{k},{line}" for k, line in enumerate(text.splitlines())),
        False,
        "it has no header; its 19 columns are read as an index, t, p_x",
    ),
    "other names": (lambda text: text.replace("t,p_x,p_y,p_z", "time,x,y,z", 1).replace("v_x", "vel_x", 1).replace("q_w", "qw"), True, ""),
    "units in brackets": (lambda text: text.replace("t,p_x", "t [s],p_x [m]", 1), True, ""),
    "quotation marks": (lambda text: text.replace("t,p_x", '"t","p_x"', 1), True, ""),
}


@pytest.mark.parametrize(("change", "header", "note"), FORMS.values(), ids=FORMS)
def test_the_form_of_a_file_changes_nothing(whole, reference, tmp_path, change, header, note):
    path = tmp_path / "form.csv"
    path.write_text(text_with(whole, change, header=header))
    read = read_reference(path, RACE)
    assert_allclose(read.reference.table, reference.table, atol=1e-9)
    assert len(read.notes) == bool(note)
    assert all(note in said for said in read.notes)


@pytest.mark.parametrize(("groups", "names"), [((V,), "v_z"), ((Q,), "q_z"), ((Q, V), "v_z"), ((), "p_z")])
def test_without_a_header_the_number_of_columns_says_what_they_are(whole, reference, tmp_path, groups, names):
    read = read_reference(write(tmp_path / "bare.csv", some(whole, *groups), header=False), RACE)
    assert f", {names}" in read.notes[0]
    assert_same_flight(read.reference, reference)


def test_units_that_names_tell_are_turned_into_si_units_and_that_is_said(whole, reference, tmp_path):
    columns = {**whole, **{name: np.degrees(whole[name]) for name in W}, "t": 1e3 * whole["t"]}
    renamed = {**{f"{name} [deg/s]" if name in W else "t_ms" if name == "t" else name: values for name, values in columns.items()}}
    read = read_reference(write(tmp_path / "units.csv", renamed), RACE)
    assert_allclose(read.reference.table, reference.table, atol=1e-9)
    assert [note.partition(": ")[2] for note in read.notes] == ["t, w_x, w_y, w_z: read in ms, deg/s"]


def test_a_unit_that_nobody_knows_is_refused(whole, tmp_path):
    renamed = {("p_x [ft]" if name == "p_x" else name): values for name, values in whole.items()}
    with pytest.raises(InputError, match=r"p_x \[ft\]: the unit ft is not known"):
        read_reference(write(tmp_path / "units.csv", renamed), RACE)


def turned_down(whole: Columns, *, swapped: bool) -> Columns:
    """The same flight in a world of z down and a body of z down, x north, y east; swapped: where the track's x points east."""
    half = np.array([0.0, 1.0, 0.0, 0.0])
    turn = np.sqrt(0.5) * np.array([0.0, 1.0, 1.0, 0.0]) if swapped else half
    matrix = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]]) if swapped else np.diag([1, -1, -1])
    columns = changed(whole, P, stack(whole, P) @ matrix)
    columns = changed(columns, V, stack(whole, V) @ matrix)
    columns = changed(columns, W, stack(whole, W) * [1, -1, -1])
    return changed(columns, Q, product(product((turn * CONJUGATE)[None], stack(whole, Q)), half[None]))


@pytest.mark.parametrize("swapped", [False, True])
def test_a_file_with_z_down_is_the_same_flight_and_that_is_said(whole, reference, tmp_path, swapped):
    read = read_reference(write(tmp_path / "ned.csv", turned_down(whole, swapped=swapped)), RACE)
    signs = np.sign((read.reference.attitude * reference.attitude).sum(axis=1, keepdims=True))
    assert_allclose(read.reference.attitude * signs, reference.attitude, atol=1e-9)
    assert_allclose(read.reference.position, reference.position, atol=1e-9)
    assert_allclose(read.reference.rates, reference.rates, atol=1e-9)
    assert len(read.notes) == 1
    assert "read as NED (z down)" in read.notes[0]


def test_positions_with_z_down_alone_are_enough(whole, reference, tmp_path):
    read = read_reference(write(tmp_path / "ned.csv", some(turned_down(whole, swapped=False), V)), RACE)
    assert_same_flight(read.reference, reference)


def test_rows_that_are_there_twice_are_dropped_and_that_is_said(whole, reference, tmp_path):
    rows = np.sort(np.append(np.arange(len(whole["t"])), [20, 50]))
    read = read_reference(write(tmp_path / "twice.csv", {name: values[rows] for name, values in whole.items()}), RACE)
    assert_allclose(read.reference.table, reference.table, atol=1e-9)
    assert [note.partition(": ")[2] for note in read.notes] == ["2 rows that are there twice were dropped"]


def test_of_two_rows_that_differ_in_thrust_alone_the_later_one_holds(whole, reference, tmp_path):
    rows = np.sort(np.append(np.arange(len(whole["t"])), [50]))
    columns = {name: values[rows] for name, values in whole.items()}
    for name in U:
        columns[name] = np.where(np.arange(len(rows)) == 50, columns[name][49], columns[name])  # as it was until then
    found = read_reference(write(tmp_path / "twice.csv", columns), RACE).reference
    assert_allclose(found.thrust, reference.thrust, atol=1e-9)


def in_world(whole: Columns) -> Columns:
    return changed(whole, W, rotate(stack(whole, Q), stack(whole, W)))


FOREIGN: dict[str, tuple[Callable[[Columns], Columns], str]] = {
    "rates in degrees": (
        lambda c: changed(c, W, np.degrees(stack(c, W))),
        "w_x, w_y, w_z: are body rates in rad/s.* rates in degrees",
    ),
    "rates in the world": (
        in_world,
        "w_x, w_y, w_z: .* world frame; .*out: they follow from the attitudes",
    ),
    "no rates": (lambda c: changed(c, W, 0 * stack(c, W)), "w_x, w_y, w_z: .* are all zero"),
    "rates of z down": (lambda c: changed(c, W, stack(c, W) * [1, -1, -1]), "w_x, w_y, w_z: .* look like rates of a body with z down"),
    "shuffled rates": (lambda c: changed(c, W, np.roll(stack(c, W), 150, axis=0)), r"w_x, w_y, w_z: .* do not fit \("),
    "no velocities": (lambda c: changed(c, V, 0 * stack(c, V)), "v_x, v_y, v_z: .* are all zero; .*: they follow from the positions"),
    "velocities in km/h": (lambda c: changed(c, V, 3.6 * stack(c, V)), "v_x, v_y, v_z: .*in m/s.* look like km/h"),
    "velocities in the body": (
        lambda c: changed(c, V, rotate(stack(c, Q) * CONJUGATE, stack(c, V))),
        "v_x, v_y, v_z: .* look as if they were in the body frame",
    ),
    "quaternions x, y, z, w": (
        lambda c: changed(some(c, Q, V), Q, np.roll(stack(c, Q), -1, axis=1)),
        r"q_w, q_x, q_y, q_z: .* look as if they were in the order x, y, z, w",
    ),
    "world to body": (lambda c: changed(some(c, Q, V), Q, stack(c, Q) * CONJUGATE), "q_w, q_x, q_y, q_z: .* from world to body"),
    "yaw in degrees": (lambda c: {**some(c, V), "yaw": 90 + 0 * c["t"]}, "line 2, yaw: 90 rad is many turns; .* call the column yaw_deg"),
}


@pytest.mark.parametrize(("change", "message"), FOREIGN.values(), ids=FOREIGN)
def test_columns_that_do_not_belong_together_are_refused_with_what_they_look_like(whole, tmp_path, change, message):
    with pytest.raises(InputError, match=message) as caught:
        read_reference(write(tmp_path / "foreign.csv", change(whole)), RACE)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("noise", [0.002, 0.01])
def test_measured_values_belong_together(whole, tmp_path, noise):
    rng = np.random.default_rng(0)
    sizes = {**dict.fromkeys(P, 0.003), **dict.fromkeys(Q, noise), **dict.fromkeys(V, 0.1), **dict.fromkeys(W, 0.3)}
    noisy = {name: values + sizes.get(name, 0.0) * rng.standard_normal(len(values)) for name, values in whole.items()}
    assert read_reference(write(tmp_path / "noisy.csv", noisy), RACE).reference.duration == pytest.approx(whole["t"][-1])


def test_a_turn_about_the_thrust_axis_that_does_not_belong_is_left_out_and_that_is_said(whole, reference, tmp_path):
    read = read_reference(write(tmp_path / "odd.csv", {**whole, "w_z": 4 * np.cos(whole["t"])}), RACE)
    assert "w_z does not belong to the attitudes" in read.notes[0]
    assert_same_flight(read.reference, reference)


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


def test_a_flight_that_begins_elsewhere_in_every_frame_is_refused_as_it_stands(whole, reference, tmp_path):
    away = replace(reference).position[0] + [0.0, 3.0, 0.0]
    race = RACE.model_copy(update={"track": RACE.track.model_copy(update={"start": tuple(away.tolist())})})
    with pytest.raises(InputError, match=r"line 2, p_x: begins 3.00 m away"):
        read_reference(write(tmp_path / "whole.csv", whole), race)


def test_rates_that_are_missed_in_a_few_turns_alone_are_missed_all_the_same(tmp_path):
    times = row_times(4.0)
    angles = np.column_stack([0 * times, 0.8 * np.clip((times - 2) / 0.2, 0, 1), 0 * times])  # level, a turn of 0.2 s, and leaning
    columns = dict(zip(("t", *P), np.column_stack([times, times, 0 * times, 0 * times]).T, strict=True))
    columns |= dict(zip((*V, *Q, *W), np.column_stack([np.tile([1, 0, 0], (len(times), 1)), np.zeros((len(times), 7))]).T, strict=True))
    columns = changed(columns, Q, flatness.attitudes_of_angles(angles))
    with pytest.raises(InputError, match=r"w_x, w_y, w_z: .* are all zero"):
        read_reference(write(tmp_path / "seldom.csv", columns), RACE)

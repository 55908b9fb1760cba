"""Columns that do not belong together are refused, with what they look like."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from hotlap.core.errors import InputError
from hotlap.reference.attitude import CONJUGATE, rotate
from hotlap.reference.reference import row_times
from hotlap.reference_files import flatness
from hotlap.reference_files.csv import read_reference

from .flights import RACE, Columns, P, Q, V, W, assert_same_flight, changed, some, stack, write


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


def test_rates_that_are_missed_in_a_few_turns_alone_are_missed_all_the_same(tmp_path):
    times = row_times(4.0)
    angles = np.column_stack([0 * times, 0.8 * np.clip((times - 2) / 0.2, 0, 1), 0 * times])  # level, a turn of 0.2 s, and leaning
    columns = dict(zip(("t", *P), np.column_stack([times, times, 0 * times, 0 * times]).T, strict=True))
    columns |= dict(zip((*V, *Q, *W), np.column_stack([np.tile([1, 0, 0], (len(times), 1)), np.zeros((len(times), 7))]).T, strict=True))
    columns = changed(columns, Q, flatness.attitudes_of_angles(angles))
    with pytest.raises(InputError, match=r"w_x, w_y, w_z: .* are all zero"):
        read_reference(write(tmp_path / "seldom.csv", columns), RACE)

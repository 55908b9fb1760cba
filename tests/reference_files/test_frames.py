"""Files in other frames than the track's are understood."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.core.errors import InputError
from hotlap.reference.attitude import CONJUGATE, product
from hotlap.reference_files.csv import read_reference

from .flights import RACE, Columns, P, Q, V, W, assert_same_flight, changed, some, stack, write


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


def test_a_yaw_of_ned_is_turned_with_the_rest(whole, tmp_path):
    yaw = 0.5 + 0.4 * whole["t"]
    up = read_reference(write(tmp_path / "up.csv", {**some(whole, V), "yaw": yaw}), RACE)
    down = read_reference(write(tmp_path / "down.csv", {**some(turned_down(whole, swapped=False), V), "yaw": -yaw}), RACE)
    assert_allclose(down.reference.attitude, up.reference.attitude, atol=1e-9)


def test_a_flight_that_begins_elsewhere_in_every_frame_is_refused_as_it_stands(whole, reference, tmp_path):
    away = replace(reference).position[0] + [0.0, 3.0, 0.0]
    race = RACE.model_copy(update={"track": RACE.track.model_copy(update={"start": tuple(away.tolist())})})
    with pytest.raises(InputError, match=r"line 2, p_x: begins 3.00 m away"):
        read_reference(write(tmp_path / "whole.csv", whole), race)

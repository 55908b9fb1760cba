"""mpc.yaml loads as the ROS parameter server would load it, and says what was tuned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import yaml

from exporters.studies import VALUES, alternating, tune
from flight.scenarios import make_scenario
from hotlap.exporters import export
from hotlap.exporters.rpg_mpc import number

LISTS = ("L_pos_xy", "L_pos_z", "L_attitude", "L_velocity", "L_horizon")
NEEDED = {  # what rpg_mpc refuses to start without
    *("Q_pos_xy", "Q_pos_z", "Q_attitude", "Q_velocity", "R_thrust", "R_pitchroll", "R_yaw"),
    *("max_bodyrate_xy", "max_bodyrate_z", "min_thrust", "max_thrust"),
}


def load(folder, scenario=None):
    with tune(folder / "study", scenario) as opened:
        (path,) = export(opened, "rpg_mpc", folder / "mpc.yaml")
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def test_lists_hold_the_segments_in_order_bit_for_bit(tmp_path):
    content = load(tmp_path)
    np.testing.assert_array_equal(np.array([content[name] for name in LISTS]).T, VALUES)
    assert all(isinstance(value, float) for name in LISTS for value in content[name])


def test_pieces_that_share_a_segment_repeat_its_values_in_the_order_flown(tmp_path):
    content = load(tmp_path, replace(make_scenario(), segments=alternating()))
    np.testing.assert_array_equal(np.array([content[name] for name in LISTS]).T, VALUES[[0, 1, 0]])


def test_a_controller_without_lists_flies_the_first_segment(tmp_path):
    content = load(tmp_path)
    assert [content[f"Q_{name[2:]}"] for name in LISTS] == VALUES[0].tolist()


def test_everything_that_the_controller_asks_for_is_there_and_positive(tmp_path):
    content = load(tmp_path, make_scenario(controller={"thrust": (0.0, 20.0), "input_weights": (1.0, 2.0, 3.0), "rates": (9.0, 10.0, 3.0)}))
    assert all(content[name] > 0 for name in NEEDED)
    assert [content[name] for name in ("R_thrust", "R_pitchroll", "R_yaw")] == [1.0, 2.0, 3.0]
    assert (content["max_bodyrate_xy"], content["max_bodyrate_z"], content["max_thrust"]) == (9.0, 3.0, 20.0)


@pytest.mark.parametrize("value", [1e-5, 2.5e-7, 1e22, 1.0, 0.1, 1 + 1e-15, 3])
def test_numbers_are_floats_to_yaml(value):
    read = yaml.safe_load(number(value))
    assert isinstance(read, float)
    assert read == value

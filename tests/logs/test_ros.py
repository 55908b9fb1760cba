"""ROS: messages of a motion capture system, a power module and an offboard computer, and what they leave out."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.logs.readers import read
from logs.ros_written import write_tracked
from logs.written import make_flight

FLIGHT = make_flight(60)


def test_pose_twist_battery_and_target_are_read(tmp_path):
    log = read(write_tracked(tmp_path / "bag", FLIGHT))
    expected = {
        "position": FLIGHT.position,
        "attitude": FLIGHT.attitude,
        "velocity": FLIGHT.velocity,
        "rate_command": FLIGHT.rate_command,
        "thrust_command": FLIGHT.thrust[:, None],
        "battery": FLIGHT.volts[:, None],
        "current": np.full((60, 1), 12.5),
    }
    assert set(log.signals) == set(expected)
    for name, values in expected.items():
        np.testing.assert_allclose(log.signals[name].values, values, atol=1e-6, err_msg=name)


@pytest.mark.parametrize(
    ("settings", "missing"),
    [
        ({"amperes": float("nan")}, {"current"}),
        ({"amperes": float("nan"), "volts": float("nan")}, {"current", "battery"}),
        ({"mask": 0b111}, {"rate_command"}),
        ({"mask": 0b1}, {"rate_command"}),
        ({"mask": 0b1000000}, {"thrust_command"}),
        ({"mask": 0b1000111}, {"rate_command", "thrust_command"}),
        ({"mask": 0b10000000}, set()),
    ],
)
def test_what_was_not_measured_or_not_asked_for_is_missing(tmp_path, settings, missing):
    whole = {"position", "attitude", "velocity", "rate_command", "thrust_command", "battery", "current"}
    log = read(write_tracked(tmp_path / "bag", FLIGHT, **settings))
    assert set(log.signals) == whole - missing
    for name in missing:
        measured = name in {"battery", "current"}
        assert (f"{name}: logged, but never measured" if measured else f"/target: its mask says that {name} does not count") in log.notes

"""Drones of one's own on tracks of one's own: nothing is set but the drone, the track and the size of its gates.

All are made up, and ordinary. What the numbers of a drone say is not tuned to; one of each kind that people fly.
"""

from __future__ import annotations

import pytest

import hotlap

DRONES = {
    "five-inch": """
mass = 0.65
inertia = [2.5e-3, 2.2e-3, 4.3e-3]
arm = 0.11
rotor_thrust = [0.1, 11.0]
torque_ratio = 0.016
motor_time = [0.025, 0.035]
drag = [0.3, 0.3, 0.1]
rate_gain = [22.0, 22.0, 8.0]
delay = 0.02
""",
    "27 g": """
mass = 0.027
inertia = [9.0e-6, 9.0e-6, 1.6e-5]
arm = 0.033
rotor_thrust = [0.0, 0.19]
torque_ratio = 0.006
motor_time = [0.03, 0.05]
drag = [0.25, 0.25, 0.1]
rate_gain = [16.0, 16.0, 6.0]
delay = 0.02
""",
    "ten-inch": """
mass = 2.6
inertia = [0.034, 0.030, 0.058]
arm = 0.23
rotor_thrust = [0.3, 24.0]
torque_ratio = 0.02
motor_time = [0.055, 0.075]
body_drag = [0.05, 0.05, 0.08]
rate_gain = [11.0, 11.0, 4.0]
delay = 0.03
""",
    "60 ms": """
mass = 0.48
inertia = [1.6e-3, 1.5e-3, 2.7e-3]
arm = 0.095
rotor_thrust = [0.05, 6.4]
torque_ratio = 0.013
motor_time = [0.02, 0.03]
drag = [0.2, 0.2, 0.05]
rate_gain = [20.0, 20.0, 8.0]
delay = 0.06
""",
}
YARD = """track = { start = [0.0, 0.0, 1.0], floor = 0.0, gates = [[5.0, 1.0, 1.5], [10.0, 4.0, 1.5], [12.0, 9.0, 2.0], [8.0, 13.0, 2.5],
    [2.0, 12.0, 1.5], [-2.0, 7.0, 1.5], [0.0, 2.0, 1.2]] }
judge.distance = 0.5
planning.tolerance = 0.1
"""
ROOM = """track = { start = [0.0, 0.0, 0.6], floor = 0.0, gates = [[1.5, 0.3, 1.0], [2.8, 1.4, 1.3], [2.4, 2.9, 1.0], [0.9, 3.2, 0.7],
    [-0.4, 2.0, 1.1]] }
judge.distance = 0.25
planning.tolerance = 0.05
"""
FIELD = """track = { start = [0.0, 0.0, 2.0], floor = 0.0, gates = [[14.0, 3.0, 3.0], [28.0, 14.0, 5.0], [24.0, 32.0, 4.0],
    [6.0, 38.0, 3.0], [-8.0, 26.0, 6.0], [-6.0, 10.0, 4.0]] }
judge.distance = 1.0
planning.tolerance = 0.2
"""
BARN = """track.start = [0.0, 0.0, 1.0]
track.floor = 0.0
track.opening = { side = 1.4 }
track.gates = [{ position = [4.0, 0.0, 1.5], yaw = 0.3 }, { position = [8.0, 3.0, 2.0], yaw = 1.3 },
    { position = [7.0, 8.0, 1.5], yaw = 2.4 }, { position = [2.0, 10.0, 2.2], yaw = -3.0 }, { position = [-3.0, 8.0, 1.5], yaw = -2.0 },
    { position = [-3.0, 3.0, 1.2], yaw = -1.0 }, { position = [0.0, 0.5, 1.2], yaw = 0.0 }]
"""
RACES = {
    "yard": ("five-inch", YARD, 2.45),
    "room": ("27 g", ROOM, 1.8),
    "field": ("ten-inch", FIELD, 5.6),
    "barn": ("60 ms", BARN, 2.75),
}


@pytest.mark.parametrize("name", ["yard", *(pytest.param(name, marks=pytest.mark.check) for name in ("room", "field", "barn"))])
def test_a_drone_of_ones_own_is_flown_boldly_and_its_controller_holds(name, tmp_path, monkeypatch):
    monkeypatch.setattr("hotlap.api.tuned._report", lambda *_: ((), None, {}))
    drone, track, lap = RACES[name]
    (tmp_path / "drone.toml").write_text(DRONES[drone], encoding="utf-8")
    (tmp_path / f"{name}.toml").write_text(f'vehicle = "drone.toml"\n{track}', encoding="utf-8")
    tuned = hotlap.tune(tmp_path / f"{name}.toml", out=tmp_path / "study")
    assert tuned.confirmed
    assert tuned.validation is not None
    assert tuned.validation.rate >= 0.95
    assert tuned.result.best.lap_time < lap
    again = hotlap.fly(tmp_path / f"{name}.toml", parameters=tmp_path / "study", seed=1, flights=200)
    assert again.complete.rate >= 0.9, "also with noise that nothing was chosen by"

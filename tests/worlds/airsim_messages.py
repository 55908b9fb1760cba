"""What AirSim's server says, in north, east, down and front, right, down."""

from __future__ import annotations

from typing import Any

import numpy as np

TURN = np.array([1, -1, -1])  # between these frames and ours


def state_told(state: np.ndarray, stamp: int, *, landed: bool) -> dict[str, Any]:
    """A state of ours, shape (13,), as `getMultirotorState` tells it."""
    return {
        "collision": {"has_collided": False},
        "kinematics_estimated": {
            **pose_told(state[:3] * TURN, state[3:7] * [1, *TURN]),
            "linear_velocity": vector_told(state[7:10] * TURN),
            "angular_velocity": vector_told(state[10:13] * TURN),
            "linear_acceleration": vector_told([0, 0, 0]),
            "angular_acceleration": vector_told([0, 0, 0]),
        },
        "timestamp": stamp,
        "landed_state": int(not landed),
    }


def state_meant(kinematics: dict[str, Any], before: np.ndarray) -> np.ndarray:
    """The state that a pose or kinematics stand for; a pose leaves velocity and rates as they were."""
    state = before.copy()
    state[:3] = TURN * _list(kinematics["position"])
    state[3:7] = [1, *TURN] * _list(kinematics["orientation"], "wxyz")
    if "linear_velocity" in kinematics:
        state[7:10] = TURN * _list(kinematics["linear_velocity"])
        state[10:13] = TURN * _list(kinematics["angular_velocity"])
    return state


def rotors_told(thrusts: np.ndarray) -> list[dict[str, float]]:
    """Rotor thrusts in our order, as `getRotorStates` tells them."""
    front_left, front_right, back_right, back_left = thrusts.tolist()
    return [{"thrust": thrust, "torque_scaler": 0.0, "speed": 0.0} for thrust in (front_right, back_left, front_left, back_right)]


def vector_told(vector: Any) -> dict[str, float]:
    return {f"{axis}_val": float(value) for axis, value in zip("xyz", vector, strict=True)}


def pose_told(position: Any, orientation: Any) -> dict[str, Any]:
    turned = {f"{axis}_val": float(value) for axis, value in zip("wxyz", orientation, strict=True)}
    return {"position": vector_told(position), "orientation": turned}


def _list(table: dict[str, float], axes: str = "xyz") -> np.ndarray:
    return np.array([table[f"{axis}_val"] for axis in axes])

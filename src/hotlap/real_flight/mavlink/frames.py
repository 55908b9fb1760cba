"""Frames: states and commands between MAVLink (north, east, down; forward, right, down) and hotlap (z up; forward, left, up).

Both the world and the body are turned by half a turn about x: vectors change the signs of y and z, and so do quaternions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hotlap.core.records import Floats
from hotlap.logs.frames import HALF_TURN, from_angles, turn, turn_attitude
from hotlap.reference.attitude import CONJUGATE, product, rotate

LOCAL_NED, LOCAL_FRD, BODY_FRD = 1, 20, 12  # MAV_FRAME
WORLDS = (LOCAL_NED, LOCAL_FRD)


def state_of_odometry(message: Any) -> Floats | None:
    """The state of an ODOMETRY message, shape (13,); None: its frames are not known here, or the velocity is in another world."""
    if message.frame_id not in WORLDS or message.child_frame_id not in (message.frame_id, BODY_FRD):
        return None
    attitude = turn_attitude([message.q])[0]
    velocity = np.array([message.vx, message.vy, message.vz]) * HALF_TURN
    if message.child_frame_id == BODY_FRD:
        velocity = rotate(attitude[None], velocity[None])[0]
    position = np.array([message.x, message.y, message.z]) * HALF_TURN
    rates = np.array([message.rollspeed, message.pitchspeed, message.yawspeed]) * HALF_TURN
    return np.concatenate([position, attitude, velocity, rates])


def motion_of_position(message: Any) -> Floats:
    """Position and velocity of a LOCAL_POSITION_NED message, shape (6,)."""
    return np.concatenate(turn([[message.x, message.y, message.z], [message.vx, message.vy, message.vz]]))


def attitude_of_quaternion(message: Any) -> Floats:
    """Attitude and rates of an ATTITUDE_QUATERNION message, shape (7,)."""
    attitude = turn_attitude([[message.q1, message.q2, message.q3, message.q4]])[0]
    return np.concatenate([attitude, np.array([message.rollspeed, message.pitchspeed, message.yawspeed]) * HALF_TURN])


def attitude_of_angles(message: Any) -> Floats:
    """Attitude and rates of an ATTITUDE message, shape (7,)."""
    attitude = turn_attitude(from_angles([message.roll], [message.pitch], [message.yaw]))[0]
    return np.concatenate([attitude, np.array([message.rollspeed, message.pitchspeed, message.yawspeed]) * HALF_TURN])


def turned_on(motion: Floats, time: float) -> Floats:
    """Attitude and rates, shape (7,), a little later or earlier [s]: it goes on turning as it does."""
    half = time / 2 * motion[4:]
    later = product(motion[None, :4], np.concatenate([[1.0], half])[None])[0]
    return np.concatenate([later / np.linalg.norm(later), motion[4:]])


def odometry_of(state: Floats) -> dict[str, Any]:
    """The fields of an ODOMETRY message for a state, shape (13,), as PX4 fills them: velocity in the body."""
    velocity = rotate((state[3:7] * CONJUGATE)[None], state[None, 7:10])[0] * HALF_TURN
    x, y, z = (state[:3] * HALF_TURN).tolist()
    vx, vy, vz = velocity.tolist()
    p, q, r = (state[10:13] * HALF_TURN).tolist()
    attitude = turn_attitude(state[None, 3:7])[0].tolist()
    motion = {"vx": vx, "vy": vy, "vz": vz, "rollspeed": p, "pitchspeed": q, "yawspeed": r}
    return {"frame_id": LOCAL_NED, "child_frame_id": BODY_FRD, "x": x, "y": y, "z": z, "q": attitude, **motion}


def rates_told(rates: Floats) -> list[float]:
    """Body rates, shape (3,), as MAVLink has them; it is its own inverse."""
    return (rates * HALF_TURN).tolist()

"""Airframe: what of a quadrotor acts on its body, as numbers for the equations of motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hotlap.dynamics.parameter_layout import airframe_layout
from hotlap.race.quadrotor import Quadrotor


def airframe_parameters(quadrotor: Quadrotor) -> NDArray[np.float64]:
    """A quadrotor's values of `airframe_layout`."""
    values = {
        "mass": quadrotor.mass,
        "gravity": quadrotor.gravity,
        "inertia": quadrotor.inertia_vector,
        "torques": quadrotor.torque_matrix,
        "drag": quadrotor.drag,
        "rotor_drag": quadrotor.rotor_drag,
        "body_drag": quadrotor.body_drag,
    }
    return np.concatenate([np.ravel(values[name]) for name in airframe_layout(quadrotor.rotor_count)])

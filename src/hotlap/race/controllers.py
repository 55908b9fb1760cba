"""Controllers: the kinds there are, and the parameters by which each can be tuned; the control laws are in `flight`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hotlap.core.parameters import ParameterSpace
from hotlap.race.controller_kind import ControllerKind


@dataclass(frozen=True)
class Tunable:
    """The tunable parameters of a controller, K for each segment.

    Attributes:
        names: of the parameters.
        low: least values.
        high: largest values.
        default: first values.
        log_step: relative size of a step in logarithms.
    """

    names: tuple[str, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    default: tuple[float, ...]
    log_step: tuple[float, ...]


_WEIGHTS = Tunable(
    names=("Q_pos_xy", "Q_pos_z", "Q_attitude", "Q_velocity", "horizon"),
    low=(1.0, 100.0, 1.0, 1.0, 1.0),  # the authors' files
    high=(1000.0, 1500.0, 100.0, 1000.0, 7.0),
    default=(200.0, 500.0, 50.0, 10.0, 4.0),
    log_step=(1.0, 1.0, 1.0, 1.0, 0.5),  # the horizon acts on everything at once: half steps
)

TUNABLE: Mapping[ControllerKind, Tunable] = {
    ControllerKind.MPC: _WEIGHTS,
    ControllerKind.MPC_DRAG: _WEIGHTS,
    ControllerKind.GEOMETRIC: Tunable(
        names=("k_pos_xy", "k_pos_z", "k_vel_xy", "k_vel_z", "k_attitude", "k_yaw"),
        low=(0.5, 0.5, 0.5, 0.5, 1.0, 0.3),
        high=(40.0, 60.0, 20.0, 20.0, 40.0, 20.0),
        default=(8.0, 12.0, 4.0, 5.0, 10.0, 3.0),
        log_step=(1.0, 1.0, 1.0, 1.0, 1.0, 1.0),
    ),
}


def space_of(kind: ControllerKind, low: tuple[float, ...], high: tuple[float, ...], default: tuple[float, ...]) -> ParameterSpace:
    """The parameter space of a controller with given bounds and defaults, each of K values."""
    tunable = TUNABLE[kind]
    return ParameterSpace(tunable.names, np.array(low), np.array(high), np.array(default), np.array(tunable.log_step))

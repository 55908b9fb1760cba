"""Controller kinds by name; imports nothing that takes time."""

from __future__ import annotations

from enum import StrEnum


class ControllerKind(StrEnum):
    """Which controller flies.

    MPC: model-predictive, as in the paper (Eq. 3).
    MPC_DRAG: the same with a model that knows the drag of the vehicle; about half as fast.
    GEOMETRIC: geometric tracking on SE(3) (Lee, Leok, McClamroch, CDC 2010) with the reference's inputs fed forward.
    """

    MPC = "mpc"
    MPC_DRAG = "mpc_drag"
    GEOMETRIC = "geometric"

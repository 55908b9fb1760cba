"""Weights that hotlap tuned, set on an AcadosOcpSolver stage by stage. This file and its JSON need numpy and nothing of hotlap.

    weights = TunedWeights("acados_weights.json")
    times = weights.apply(solver, time, position)    # before each solve; then set yref of each stage to the reference at its time

The solver is to have `weights.nodes` shooting intervals and a LINEAR_LS or NONLINEAR_LS cost of the output y = (x, u), and x alone at
the end, in this order: position p, attitude q (w, x, y, z; body to world), velocity v; collective thrust per mass, body rates. The
quaternion of yref is to have the sign of the measured one: |q - q_ref| is charged as it stands.

The cost that was tuned is a plain sum over the nodes; acados multiplies a stage's cost by its time step, and the end's by 1. So W is
divided by the time step here. This holds whatever `cost_scaling` the stages of the solver were made with: setting new time steps sets
the factors of the stages to them. That of the end is to be 1, its default.

What the tuned controller flew with stands in the JSON under `flown_with`, and what of it no weights bring to acados under `not_reproduced`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np


class TunedWeights:
    """Weights and horizon of each segment, and when they hand over.

    Args:
        path: the JSON file that was written beside this one.

    Attributes:
        nodes: N, shooting intervals.
        low, high: shape (4,), bounds of the inputs.
        not_reproduced: what the tuned controller did besides, and acados does not: a sentence for each.
        piece: of the reference, that the drone flies with.
    """

    def __init__(self, path: str | Path) -> None:
        self.data = json.loads(Path(path).read_text(encoding="utf-8"))
        self.nodes = self.data["nodes"]
        self.low, self.high = np.array(self.data["low"]), np.array(self.data["high"])
        self.not_reproduced = self.data["not_reproduced"]
        self._starts = np.array([piece["start"] for piece in self.data["pieces"]])
        self.reset()

    def reset(self) -> None:
        """Begin a flight."""
        self.piece = -1

    def apply(self, solver: Any, time: float, position: Any = None) -> np.ndarray:
        """Set time steps and weights for the control step at a time.

        Where the time step changes, what the solver begins with is still laid on the old one: interpolate it.

        Args:
            solver: an AcadosOcpSolver.
            time: [s] since the start of the reference.
            position: [m] (3,) of the drone, for handing over by distance.

        Returns:
            Shape (N + 1,) [s], at which the reference of each stage is to be taken.
        """
        ahead = time + self.data["lead"]
        self.piece = self._piece_flown(ahead, position)
        spacing = self._segment(self.piece)["spacing"]
        times = ahead + spacing * np.arange(self.nodes + 1)
        solver.set_new_time_steps(np.full(self.nodes, spacing))
        for stage, segment in enumerate(self._segments(times)):
            last = stage == self.nodes
            scale = 1.0 if last else spacing
            solver.cost_set(stage, "W", np.diag(segment["W_e" if last else "W"]) / scale)
        return times

    def _segments(self, times: np.ndarray) -> list[dict[str, Any]]:
        """The segment whose weights each stage has."""
        if self.data["segment_switch"] == "node":
            return [self._segment(self._piece_at(float(time))) for time in times]
        return [self._segment(self.piece)] * len(times)

    def _segment(self, piece: int) -> dict[str, Any]:
        return self.data["segments"][self.data["pieces"][piece]["segment"]]

    def _piece_at(self, time: float) -> int:
        """The piece that the reference is in, which changes with its rows."""
        row = int(time / self.data["period"] + 1e-6)
        return max(int(np.searchsorted(self._starts, row * self.data["period"], side="right")) - 1, 0)

    def _piece_flown(self, time: float, position: Any) -> int:
        """By the reference's time, or by how close the drone has come to the next piece's first point."""
        if self.data["segment_switch"] != "distance":
            return self._piece_at(time)
        if self.piece < 0:
            return 0
        if self.piece + 1 == len(self._starts):
            return self.piece
        away = np.linalg.norm(np.asarray(position) - self.data["pieces"][self.piece + 1]["point"])
        return self.piece + int(away < self.data["distance"])

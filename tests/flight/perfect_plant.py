"""Flights of a plant that is the controller's model, without noise: what is left of the error is the controller's."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from hotlap.dynamics import models
from hotlap.flight.control_loop import ControlLoop, allocate_control_loop
from hotlap.flight.controller import _steps
from hotlap.flight.fly import prepare, settings_of
from hotlap.flight.job import Job, Settings
from hotlap.flight.numbers import Numbers
from hotlap.flight.registry import CONTROLLERS
from hotlap.flight.segment_switch import FRESH
from hotlap.race.controllers import ControllerKind
from hotlap.reference.scenario import Scenario

MODELS = {ControllerKind.MPC: "node_map", ControllerKind.MPC_DRAG: "drag_node_map"}
LOST = 100.0  # m: the error of a flight that has left the world


class Lane:
    """One lane's controller in float64, of which everything can be read."""

    def __init__(self, scenario: Scenario, parameters: np.ndarray) -> None:
        law, whole = scenario.race.controller.law, np.tile(parameters, (1, len(scenario.segments), 1))
        self.job: Job = prepare(scenario, whole, np.zeros(1, dtype=np.int64), Numbers.FLOAT64, None, ())[0]
        self.settings: Settings = settings_of(scenario)
        self.memory: Any = CONTROLLERS[law].allocate(self.settings, 1, np.float64)
        self.loop: ControlLoop = allocate_control_loop(3, 1, np.float64)
        begin, self._step = _steps(law)
        begin(self.job, self.settings, self.memory, self.loop)
        self._piece = FRESH

    def command(self, tick: int, state: np.ndarray) -> np.ndarray:
        """The command of a control step, shape (4,)."""
        self.loop.seen[:, 0], period = state, self.settings.period
        self._piece = self._step(self.job, self.settings, self.memory, self.loop, self._piece, tick * period, period)
        return self.loop.history[0, :, 0].copy()


@cache
def _model(kind: ControllerKind) -> Any:
    return getattr(models, MODELS[kind])()


def mean_error(scenario: Scenario, parameters: np.ndarray) -> float:
    """[m] Mean distance from the reference up to the last gate, with the same parameters in all segments."""
    lane, node = Lane(scenario, parameters), _model(scenario.race.controller.kind)
    period, state, errors = lane.settings.period, lane.job.table[0, :10].copy(), []
    for tick in range(int(scenario.reference.lap_time / period)):
        state = np.array(node(state, lane.command(tick, state), period, lane.memory.constants[:, 0])).ravel()
        state[3:7] /= np.linalg.norm(state[3:7])
        errors.append(np.linalg.norm(state[:3] - scenario.reference.position_at(np.array([(tick + 1) * period]))[0]))
        if not errors[-1] < LOST:
            return LOST
    return float(np.mean(errors))

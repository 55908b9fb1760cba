"""The control loop around a controller: the measured state, its prediction over the dead time, and the commands given before."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from hotlap.dynamics.parameter_layout import MODEL
from hotlap.flight.compile import compiled_dynamics
from hotlap.flight.job import Job, Settings
from hotlap.flight.lanes import number
from hotlap.flight.numbers import INLINE, aligned_zeros
from hotlap.flight.observer import EFFECTIVENESS, ESTIMATE_SIZE, OBSERVER_SIZE, begin_observer, push, thrust_command


class ControlLoop(NamedTuple):
    """Memory of the control loop around the controller; raw floats (..., lanes), or numbers (...).

    Attributes:
        seen: (10,) state p q v as measured, then as predicted.
        history: (H, 4) commands, the newest first.
        shift: (1,) share of a node by which a plan moves on.
        span: (1,) [s] of a prediction.
        predicted: (10,) state after it.
        acted: (4,) command that acts meanwhile, as the model understands it.
        push: (3,) [m/s^2] (world) acceleration that acts meanwhile besides the model.
        estimate, observer, known_drag: (E,), (G,), (M,) of the observer; see `observer`.
        sent, drag: (1,), (3,) thrust that was commanded and deceleration, of its present step.
    """

    seen: Any
    history: Any
    shift: Any
    span: Any
    predicted: Any
    acted: Any
    push: Any
    estimate: Any
    observer: Any
    known_drag: Any
    sent: Any
    drag: Any


def allocate_control_loop(commands: int, lanes: int, kind: type[np.floating[Any]]) -> ControlLoop:
    """Raw memory, of one kind of float, for so many commands; a lane without a flight computes with ones, so that it divides by no zero."""
    sizes = ((10,), (commands, 4), (1,), (1,), (10,), (4,), (3,), (ESTIMATE_SIZE,), (OBSERVER_SIZE,), (sum(MODEL.values()),), (1,), (3,))
    loop = ControlLoop(*(aligned_zeros((*size, lanes), kind) for size in sizes))
    for array in (loop.seen[3], loop.estimate[EFFECTIVENESS], loop.observer, loop.known_drag):
        array.fill(1)
    return loop


@njit(**INLINE)
def begin_control_loop(job: Job, s: Settings, loop: ControlLoop, k: int) -> None:
    """Prepare a lane for a new flight: the commands before it were those of hovering."""
    loop.history[:, :, k] = 0
    loop.history[:, 0, k] = s.gravity
    begin_observer(loop, job.observer, job.known_drag, k)


def predictor(propagate: Callable[..., None]) -> Any:
    """A compiled function of (settings, parameters of the model, loop) that predicts the state at the time when the command will act.

    It integrates the model over the dead time, with the commands that were given before and act meanwhile.

    Args:
        propagate: the model: (state, input, duration, parameters, state after it).
    """

    @njit(**INLINE)
    def predict(s: Settings, constants: Any, p: ControlLoop) -> None:
        for n in range(s.predicted_periods, -1, -1):
            duration = s.predicted_rest if n == s.predicted_periods else s.period
            if duration > 0:
                p.span[0] = number(p.seen[0], duration)
                for a in range(4):
                    p.acted[a] = p.history[n, a]
                if s.offset_free:
                    p.acted[0] *= p.estimate[EFFECTIVENESS]
                propagate(p.seen, p.acted, p.span, constants, p.predicted)
                if s.corrected:
                    push(p.predicted, p.push, p.span[0], 7)
                for i in range(10):
                    p.seen[i] = p.predicted[i]

    return predict


predict = predictor(compiled_dynamics("node_map"))


@njit(**INLINE)
def issue(s: Settings, p: ControlLoop, command: Any) -> None:
    """Put the command of this control step at the head of the history."""
    for n in range(len(p.history) - 1, 0, -1):
        for a in range(4):
            p.history[n, a] = p.history[n - 1, a]
    for a in range(4):
        p.history[0, a] = command[a]
    if s.offset_free:
        p.history[0, 0] = thrust_command(s, p, command[0])

"""IPOPT: solve a shooting program between bounds, quietly, and let Ctrl-C through."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Any

import casadi as ca
import numpy as np

from hotlap.planning.problem import Floats, Trajectory
from hotlap.planning.shooting import Shooting

OPTIONS = {
    "print_level": 0,
    "sb": "yes",  # no banner
    "tol": 1e-4,
    "constr_viol_tol": 1e-5,
    "dual_inf_tol": 1e-2,
    "compl_inf_tol": 1e-4,
    "acceptable_tol": 1e-3,
    "acceptable_constr_viol_tol": 1e-5,
    "acceptable_obj_change_tol": 1e-5,
    "acceptable_iter": 5,
    "linear_solver": "mumps",
    "mumps_mem_percent": 200,
    "mu_strategy": "monotone",  # the adaptive barrier finds wrong laps
}


@dataclass(frozen=True)
class Limits:
    """What a solution must keep to.

    Attributes:
        low, high: bounds of every duration, state and control.
        tolerance: [m] radius of the ball around each waypoint, one for all or shape (M,); infinite where there is none.
        thrust: [m/s^2] largest norm of a control, where the program constrains it.
    """

    low: Trajectory
    high: Trajectory
    tolerance: float | Floats
    thrust: float = np.inf


@dataclass(frozen=True)
class Solution:
    """Where IPOPT ended.

    Attributes:
        trajectory: its last iterate.
        converged: whether that is a solution.
        status: IPOPT's own word for it.
        iterations: how many it took.
        misses: shape (M,) [m] distance of the end of each phase from its waypoint, beyond the tolerance.
        gaps: shape (M,) largest violation of the equations of motion within each phase.
    """

    trajectory: Trajectory
    converged: bool
    status: str
    iterations: int
    misses: Floats
    gaps: Floats


def solve(
    shooting: Shooting, waypoints: Floats, model: Floats, guess: Trajectory, limits: Limits, *, barrier: float, iterations: int
) -> Solution:
    """Minimise the duration.

    Args:
        shooting: the program.
        waypoints: shape (M, 3) [m] (world).
        model: parameters of the stage.
        guess: where to begin.
        limits: what to keep to.
        barrier: first value of the barrier parameter mu: small for a good guess.
        iterations: after how many to give up.

    Raises:
        KeyboardInterrupt: on Ctrl-C.
    """
    options = {
        "ipopt": {**OPTIONS, "mu_init": barrier, "max_iter": iterations},
        "print_time": False,
        "error_on_fail": False,
        "show_eval_warnings": False,
        "no_nlp_grad": True,
        "calc_lam_p": False,
        **shooting.derivatives,
    }
    solver = ca.nlpsol("minimum_time", "ipopt", shooting.program, options)
    lowest, highest = _constraint_bounds(shooting, limits)
    with _interruptible():
        result = solver(
            x0=shooting.pack(guess),
            p=shooting.parameters(waypoints, model),
            lbx=shooting.pack(limits.low),
            ubx=shooting.pack(limits.high),
            lbg=lowest,
            ubg=highest,
        )
    return _read(shooting, waypoints, limits, result, solver.stats())


def _constraint_bounds(shooting: Shooting, limits: Limits) -> tuple[Floats, Floats]:
    """Of gaps, balls, thrusts and linear rows."""
    thrusts = shooting.total * shooting.thrust_ball
    highest = np.concatenate([
        np.zeros(shooting.gap_rows),
        np.broadcast_to(limits.tolerance, shooting.phases) ** 2,
        np.full(thrusts, limits.thrust**2),
    ])  # fmt: skip
    lowest = np.where(np.arange(shooting.nonlinear_rows) < shooting.gap_rows, 0.0, -np.inf)
    return np.append(lowest, shooting.linear.low), np.append(highest, shooting.linear.high)


def _read(shooting: Shooting, waypoints: Floats, limits: Limits, result: Any, stats: Any) -> Solution:
    """The solution, and where it fails if it does."""
    trajectory = shooting.unpack(np.asarray(result["x"]).ravel())
    gaps = np.abs(np.asarray(result["g"]).ravel()[: shooting.gap_rows])
    distances = np.linalg.norm(trajectory.states[trajectory.ends, :3] - waypoints, axis=1)
    return Solution(
        trajectory=trajectory,
        converged=bool(stats["success"]),
        status=str(stats["return_status"]),
        iterations=int(stats["iter_count"]),
        misses=np.maximum(distances - limits.tolerance, 0.0),
        gaps=np.maximum.reduceat(gaps.reshape(shooting.stage.nx, -1).max(axis=0), np.append(0, shooting.ends[:-1])),
    )


@contextmanager
def _interruptible() -> Iterator[None]:
    """Raise KeyboardInterrupt after the block if Ctrl-C was pressed in it.

    CasADi stops IPOPT when a Python signal handler raises, but swallows the exception.
    """
    if threading.current_thread() is not threading.main_thread():  # signals never arrive here
        yield
        return
    previous = signal.getsignal(signal.SIGINT)
    if not callable(previous):  # ignored, or handled outside of Python
        yield
        return
    caught: list[BaseException] = []

    def handle(number: int, frame: FrameType | None) -> None:
        try:
            previous(number, frame)
        except BaseException as error:
            caught.append(error)
            raise

    signal.signal(signal.SIGINT, handle)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous)
        if caught:
            raise caught[0]

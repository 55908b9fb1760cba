"""Controller: the tuned controller alone, for other simulators and for real vehicles.

It runs the same compiled functions as the flights that tuned it, in float64, one control step a call.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.core.errors import HotlapError
from hotlap.core.parameters import Parameters
from hotlap.flight.command_log import CommandLog
from hotlap.flight.control_loop import ControlLoop, allocate_control_loop, begin_control_loop
from hotlap.flight.fly import predicting, prepare, settings_of
from hotlap.flight.job import Job, Settings
from hotlap.flight.kernel_cache import keep
from hotlap.flight.lanes import as_numbers
from hotlap.flight.numbers import COMPILE, Numbers
from hotlap.flight.observer import (
    DISTURBANCE,
    EFFECTIVENESS,
    EFFECTIVENESS_LIMITS,
    LARGEST_DISTURBANCE,
    VELOCITY,
    begin_with,
    follow_clock,
)
from hotlap.flight.registry import CONTROLLERS
from hotlap.flight.segment_switch import FRESH
from hotlap.reference.scenario import Scenario

STATE = 10  # p q v; body rates may follow and are not used
MOST_AGE = 0.25  # s
LEAST_STEP = 1e-6  # s: a state that is measured no later than the one before teaches nothing


class Controller:
    """Computes the commands of one drone, control step by control step.

    Args:
        scenario: what is flown; its race's model and controller settings count, not its vehicle.
        parameters: shape (S, K) or, for all segments alike, (K,).

    Raises:
        HotlapError: parameters that do not fit.
    """

    def __init__(self, scenario: Scenario, parameters: Parameters) -> None:
        whole = np.array(np.broadcast_to(parameters, (len(scenario.segments), scenario.space.size)), dtype=np.float64)
        self._job, _ = prepare(scenario, whole[None], np.zeros(1, dtype=np.int64), Numbers.FLOAT64, None, ())
        self._settings = settings_of(scenario)._replace(stop_early=False)  # the same work at every step
        self._race, self._dead_time, self._known_delay = scenario.race, scenario.race.prediction, scenario.race.control_model.delay
        law = scenario.race.controller.law
        self._memory = CONTROLLERS[law].allocate(self._settings, 1, np.float64)
        self._begin, self._step = _steps(law)
        commands = math.ceil((max(self._dead_time, self._known_delay) + MOST_AGE) / self._settings.period) + 4
        self._loop = allocate_control_loop(commands, 1, np.float64)
        self._log = CommandLog(self._loop.history[:, :, 0], self._settings.period)
        self.reset()

    def reset(self, thrust_effectiveness: float = 1.0, disturbance: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        """Start anew, from hovering: forget the plan, the commands given before and what was learnt.

        Args:
            thrust_effectiveness: [-] where its estimate begins, 0.6 to 1.4: the thrust expected over that commanded, as hovering
                shows it.
            disturbance: shape (3,) [m/s^2] (world) where its estimate begins, up to 12 along each axis.

        Raises:
            HotlapError: an estimate out of range, or one of a controller that is not offset-free.
        """
        low, high = EFFECTIVENESS_LIMITS
        start = np.array([thrust_effectiveness, *disturbance], dtype=np.float64)
        if not (len(start) == 4 and low <= start[0] <= high and (np.abs(start[1:]) <= LARGEST_DISTURBANCE).all()):
            limits = f"a thrust effectiveness from {low:g} to {high:g} and three accelerations up to {LARGEST_DISTURBANCE:g} m/s^2"
            raise HotlapError(f"estimates begin with {limits}, not {start.tolist()}")
        if not self.is_offset_free and start.tolist() != [1.0, 0.0, 0.0, 0.0]:
            raise HotlapError("this controller estimates nothing: controller.offset_free is off, or the plan leaves no thrust for it")
        self._piece, self._time, self._measured = FRESH, -np.inf, -np.inf
        self._begin(self._job, self._settings, self._memory, self._loop)
        begin_with(self._loop, start, self._settings.gravity)
        self._log.reset()

    @property
    def is_offset_free(self) -> bool:
        """Whether it estimates what its model leaves out, and makes up for it; see `Scenario.offset_free`."""
        return self._settings.offset_free

    @property
    def thrust_effectiveness(self) -> float:
        """Estimated thrust over the thrust that was commanded [-]; 1 where it is not estimated."""
        return float(self._loop.estimate[EFFECTIVENESS, 0])

    @property
    def disturbance(self) -> NDArray[np.float64]:
        """Estimated acceleration that nothing else explains, shape (3,) [m/s^2] (world); 0 where it is not estimated."""
        return self._loop.estimate[DISTURBANCE:VELOCITY, 0].copy()

    def command(self, time: float, state: NDArray[np.float64], age: float = 0.0) -> NDArray[np.float64]:
        """Compute the command that is to be sent now; to be called about once in every control period, in order of time.

        The plan moves on, and the observer looks back, over the time that has passed since the call before. Over a known dead time (the
        model's `delay`) the state is predicted through the commands that were given before.

        Args:
            time: [s] since the start of the reference.
            state: shape (10,) or (13,): position [m], attitude (w, x, y, z) and velocity [m/s] (world); rates are not used.
            age: [s] since the state was measured, up to 0.25; the state is predicted over it as over the dead time.

        Returns:
            Shape (4,): collective thrust per mass [m/s^2] and body rates [rad/s].

        Raises:
            HotlapError: a state that is not finite, a time that does not go on, or an age out of range.
        """
        if not 0 <= age <= MOST_AGE:
            raise HotlapError(f"the age of a state must be from 0 to {MOST_AGE:g} s, not {age:g}")
        if len(state) < STATE or not np.isfinite(state[:STATE]).all():
            raise HotlapError("the state must be ten finite numbers: position, attitude (w, x, y, z), velocity")
        if not self._time < time < np.inf:
            raise HotlapError(f"time must go on: {time:g} s comes after {self._time:g} s")
        seen = self._loop.seen[:, 0]
        seen[:] = state[:STATE]
        seen[3:7] *= np.sign(seen[3:7] @ self._attitude(time)) or 1.0  # q and -q are one attitude; the nearer one is meant
        elapsed, observed = (self._log.rounded(min(span, 1e3)) for span in (time - self._time, time - age - self._measured))
        observed = max(observed, LEAST_STEP)
        follow_clock(self._loop, self._race, observed)
        settings = self._settings if age == 0 else predicting(self._settings, self._dead_time + age)
        settings = self._log.lay_out(settings, elapsed, self._known_delay + age, observed)
        self._piece = self._step(self._job, settings, self._memory, self._loop, self._piece, float(time), float(elapsed))
        self._time, self._measured = time, max(self._measured, time - age)
        self._log.keep()
        return self._loop.history[0, :, 0].copy()

    def _attitude(self, time: float) -> NDArray[np.float64]:
        """Attitude of the reference at a time, to the nearest row before it, shape (4,)."""
        row = min(max(int(time / self._settings.table_period), 0), len(self._job.table) - 1)
        return self._job.table[row, 3:7]


@cache
def _steps(law: str) -> tuple[Any, Any]:
    """Two compiled functions of a controller: start anew, and one control step."""
    begin, aim, control = CONTROLLERS[law].begin, CONTROLLERS[law].aim, CONTROLLERS[law].control

    def begin_one(job: Job, s: Settings, memory: Any, loop: ControlLoop) -> None:
        """Forget the flight before."""
        begin(job, s, memory, 0)
        begin_control_loop(job, s, loop, 0)

    def step_one(job: Job, s: Settings, memory: Any, loop: ControlLoop, piece: int, time: float, elapsed: float) -> int:
        """One control step; returns the piece of the reference whose parameters it has used."""
        now = aim(job, s, memory, loop, 0, 0, piece, time, elapsed)
        control(s, as_numbers(memory, 0), as_numbers(loop, 0))
        return now

    return keep(njit(**COMPILE)(begin_one), f"{law}-begin"), keep(njit(**COMPILE)(step_one), f"{law}-step")

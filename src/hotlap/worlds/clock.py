"""Clock: control periods and dead time in whole steps of a simulator."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError

Floats = NDArray[np.float64]
NEARLY = 1e-6  # of a step: as good as whole


@dataclass(frozen=True)
class Clock:
    """Control periods of a flight in steps of a simulator.

    Where the steps do not divide the period, a period ends with the step that ends nearest to it, and what is read then is carried over
    the rest, which is less than a step.

    Attributes:
        step: [s] of the simulator.
        period: [s] of the control loop.
        delay: [s] dead time of the vehicle, taken to the nearest step.
    """

    step: float
    period: float
    delay: float = 0.0

    @property
    def divides(self) -> bool:
        """Whether a period has a whole number of steps."""
        return abs(self.period / self.step - round(self.period / self.step)) < NEARLY

    @property
    def delay_periods(self) -> int:
        """Whole control periods of the dead time."""
        return math.floor(round(self.delay / self.step) * self.step / self.period + NEARLY)

    @property
    def older_steps(self) -> int:
        """Steps at the beginning of each period in which the older command still acts: the dead time beyond whole periods."""
        return round((self.delay - self.delay_periods * self.period) / self.step)

    def steps_in(self, tick: int) -> int:
        """Steps of a period, counted from 0."""
        return self._steps_until(tick + 1) - self._steps_until(tick)

    def rest_after(self, tick: int) -> float:
        """[s] by which the end of a period lies behind the steps that were flown."""
        rest = (tick + 1) * self.period - self._steps_until(tick + 1) * self.step
        return rest if abs(rest) > NEARLY * self.step else 0.0

    def check(self, name: str, lanes: int) -> None:
        """Refuse steps that make no control periods.

        Raises:
            InputError: names world and step.
        """
        step, period = f"{1e3 * self.step:g} ms", f"the control period of {1e3 * self.period:g} ms"
        if self.step > self.period * (1 + NEARLY):
            raise InputError("", "on", f"a step of {name}, {step}, is longer than {period}")
        if lanes > 1 and not self.divides:
            raise InputError("", "on", f"steps of {name}, {step}, do not divide {period}, and its lanes share one clock")

    def _steps_until(self, tick: int) -> int:
        return round(tick * self.period / self.step + NEARLY)


def carry(state: Floats, time: float) -> Floats:
    """A state, shape (13,), a little later or earlier [s]: place and attitude go on as they do."""
    if not time:
        return state
    carried, (w, x, y, z), (a, b, c) = state.copy(), state[3:7], time / 2 * state[10:13]
    carried[:3] += time * state[7:10]
    carried[3:7] += (-x * a - y * b - z * c, w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a)
    carried[3:7] /= np.linalg.norm(carried[3:7])
    return carried

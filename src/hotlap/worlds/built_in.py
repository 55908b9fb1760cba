"""The built-in world: the flight core, many flights at a time, thousands of times faster than real time."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hotlap.course import Course
from hotlap.parameters import Parameters
from hotlap.records import Flights

if TYPE_CHECKING:
    from hotlap.flight.batch import Effort
    from hotlap.flight.numbers import Numbers

NAME = "built-in"


class BuiltIn:
    """Flies in the flight core; its first flight on a machine compiles for half a minute.

    Args:
        numbers: kind of number that flights are computed in, of `flight.numbers.Numbers`; "": the fastest here.
        threads: how many; 0 for one a processor.

    Attributes:
        name: "built-in".
        takes_truth: it does.
        effort: what the last batch took.
    """

    def __init__(self, numbers: str = "", threads: int = 0) -> None:
        self.name, self.takes_truth = NAME, True
        self.effort: Effort | None = None
        self._numbers, self._threads = numbers, threads

    @cached_property
    def numbers(self) -> Numbers:
        """Kind of number that flights are computed in."""
        from hotlap.flight.numbers import Numbers, best_numbers  # noqa: PLC0415  the flight core loads a compiler

        return Numbers(self._numbers) if self._numbers else best_numbers()

    @property
    def needs_compiling(self) -> bool:
        """Whether the next flight has to wait for the compiler."""
        from hotlap.flight import kernel_cache, simulate  # noqa: PLC0415

        return not kernel_cache.is_filled(simulate.worker(self.numbers))

    def prepare(self, course: Course) -> None:
        """Compile, or load what was compiled: flies once."""
        self.fly(course, course.space.first_guess(len(course.segments))[None], np.zeros(1, dtype=np.int64))

    def fly(
        self,
        course: Course,
        parameters: Parameters,
        seeds: NDArray[np.int64],
        *,
        truth: NDArray[np.float64] | None = None,
        log: Sequence[int] = (),
    ) -> Flights:
        """Fly a batch; see `World.fly`. The columns of `truth` are `flight.plant.TRUTH`."""
        from hotlap.flight.batch import fly_batch  # noqa: PLC0415

        flights, self.effort = fly_batch(course, parameters, seeds, numbers=self.numbers, threads=self._threads, truth=truth, log=log)
        return flights

"""Progress: what a call says while it works."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from hotlap.tuning.loop import Batch


Rounds = Callable[[str, int, int], AbstractContextManager[Callable[[str], None]]]
"""(unit, wanted, done) -> a context that gives the function to be called with a few words on each piece that has ended."""


class Progress(Protocol):
    """Is told how the work of a call goes on; the command line shows it as bars and lines on standard error."""

    def note(self, text: str) -> None:
        """A remark beside the result."""
        ...

    def working(self, text: str) -> AbstractContextManager[None]:
        """Something that takes its time, as long as the context lasts."""
        ...

    def flights(self, budget: int, flown: int, seconds: float = 0.0, spent: float = 0.0) -> AbstractContextManager[Callable[[Batch], None]]:
        """The search of a tuning.

        Args:
            budget: flights at most.
            flown: flights before it went on.
            seconds: of wall time at most; 0: flights are counted, not time.
            spent: [s] of them before it went on.

        Returns:
            A context that gives the function to be called after each batch.
        """
        ...

    def pieces(self, unit: str, wanted: int, done: int, *, even: bool = True) -> AbstractContextManager[Callable[[str], None]]:
        """Pieces of work, as the runs of a comparison.

        Args:
            unit: what they are, in the plural.
            wanted: how many in all.
            done: how many of them were there before.
            even: whether each takes about as long as the others; else the words tell how much time is left.

        Returns:
            A context that gives the function to be called with a few words on each piece that has ended.
        """
        ...

    def rounds(self, unit: str, most: int) -> AbstractContextManager[Rounds]:
        """Pieces of work that come in rounds, shown as one: the next round is known when the last one is done.

        Args:
            unit: what the pieces are, in the plural.
            most: pieces at most, of all rounds together; 0: nobody knows.

        Returns:
            A context that gives what shows a round, called as `pieces` is.
        """
        ...


class Quiet:
    """Says nothing."""

    def note(self, text: str) -> None:
        """Nothing."""

    def working(self, text: str) -> AbstractContextManager[None]:  # noqa: ARG002  as the protocol has it
        """Nothing."""
        return nullcontext()

    def flights(
        self,
        budget: int,  # noqa: ARG002
        flown: int,  # noqa: ARG002
        seconds: float = 0.0,  # noqa: ARG002
        spent: float = 0.0,  # noqa: ARG002
    ) -> AbstractContextManager[Callable[[Batch], None]]:
        """Nothing."""
        return nullcontext(lambda _: None)

    def pieces(
        self,
        unit: str,  # noqa: ARG002
        wanted: int,  # noqa: ARG002
        done: int,  # noqa: ARG002
        *,
        even: bool = True,  # noqa: ARG002
    ) -> AbstractContextManager[Callable[[str], None]]:
        """Nothing."""
        return nullcontext(lambda _: None)

    def rounds(self, unit: str, most: int) -> AbstractContextManager[Rounds]:  # noqa: ARG002
        """Nothing."""
        return nullcontext(self.pieces)

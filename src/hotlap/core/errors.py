"""What can go wrong on the ground: one base class, and children that carry what failed.

A crash of the drone is a result, never an exception.
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any

from hotlap.core.printable import printable


class HotlapError(Exception):
    """Base of every error that hotlap raises on purpose; one raised in a worker process arrives as it was."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (type(self), self.args, self.__dict__)


def _rebuild(kind: type[HotlapError], arguments: tuple[Any, ...], state: dict[str, Any]) -> HotlapError:
    """An error from its parts, whatever its constructor takes."""
    error = kind.__new__(kind, *arguments)
    error.__dict__.update(state)
    return error


class InputError(HotlapError):
    """Something that a user gave is not usable: says where, which key, and why, on one line.

    Args:
        source: the file or the command-line option.
        key: the key inside it, dotted (`controller.period`), or "" for the whole of it.
        reason: one clause that says what is wrong and what would be right.
    """

    def __init__(self, source: str, key: str, reason: str) -> None:
        self.source, self.key, self.reason = source, key, reason
        super().__init__(printable(": ".join(part for part in (source, key, reason) if part)))


class UnknownNameError(InputError):
    """A name that nothing answers to; lists the names that would have worked."""

    def __init__(self, kind: str, name: str, available: Iterable[str], source: str = "", key: str = "") -> None:
        self.kind, self.name, self.available = kind, name, tuple(sorted(set(available)))
        near = get_close_matches(name, self.available, n=1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        super().__init__(source, key, f"there is no {kind} named '{name}'{hint}; available: {', '.join(self.available)}")


class PlanningError(HotlapError):
    """No minimum-time reference was found.

    Args:
        track: its name.
        where: the gate that could not be planned through, as it is called ("gate 3", counted from 1), or None for the whole track.
        reason: why, in one clause.
    """

    def __init__(self, track: str, where: str | None, reason: str) -> None:
        self.track, self.where, self.reason = track, where, reason
        super().__init__(f"no plan for {track if where is None else f'{track}, {where}'}: {reason}")


class StudyError(InputError):
    """A study folder cannot be used as asked: another configuration, another process, another version."""


class StorageError(StudyError):
    """The disk is full, or it fails: nothing that a user gave is at fault, and the work has failed."""

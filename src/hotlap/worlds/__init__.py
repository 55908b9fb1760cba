"""Worlds by name: where flights happen; all answer to the protocol of `world.py`."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from hotlap.core.errors import UnknownNameError
from hotlap.worlds.built_in import NAME, BuiltIn
from hotlap.worlds.world import World

DEFAULT = NAME

_WORLDS: Mapping[str, Callable[[], World]] = {NAME: BuiltIn}


def names() -> tuple[str, ...]:
    """Every world."""
    return tuple(_WORLDS)


def build(name: str) -> World:
    """A world by its name.

    Raises:
        UnknownNameError: with the names that there are.
    """
    if name not in _WORLDS:
        raise UnknownNameError("world", name, _WORLDS, key="on")
    return _WORLDS[name]()


__all__ = ["DEFAULT", "BuiltIn", "World", "build", "names"]

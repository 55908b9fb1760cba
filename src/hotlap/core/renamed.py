"""Renamed: names of before go on working, and one line says the new one."""

from __future__ import annotations

import warnings


class RenamedWarning(UserWarning):
    """A name of before was used."""


def say_renamed(old: str, new: str, source: str = "") -> None:
    """Warn that something is called otherwise now.

    Args:
        old: as it was given.
        new: as it is called now.
        source: the file or option that it stands in.
    """
    warnings.warn(f"{source}: {old} is now called {new}" if source else f"{old} is now called {new}", RenamedWarning, stacklevel=3)

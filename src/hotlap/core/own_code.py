"""Own code: modules that a user has named, `--tuner my_module.MyTuner`, and nothing else of the working folder."""

from __future__ import annotations

import sys
import warnings
from importlib import import_module
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec
from multiprocessing import parent_process
from pathlib import Path
from types import ModuleType


class OwnCode(UserWarning):
    """Code of the working folder is run, since the user has named it."""


def import_own(name: str) -> ModuleType:
    """Import a module; one that is not installed is looked for in the working folder, and the user is told that its code runs.

    The working folder is on the path, last, during that import alone: what a module needs of it has to be imported at its top. What the
    module itself does to the path stays.

    Args:
        name: dotted.

    Raises:
        Exception: whatever the module raises.
    """
    here = str(Path.cwd())
    spec = _find_here(name.partition(".")[0], here)
    if spec is None:
        return import_module(name)
    if parent_process() is None:  # a worker runs what its parent has said
        warnings.warn(f"runs code of {spec.origin or here}", OwnCode, stacklevel=3)
    sys.path.append(here)
    try:
        return import_module(name)
    finally:
        sys.path[:] = [place for place in sys.path if place is not here]  # an equal one that the module has added is not ours


def find_own(name: str) -> ModuleSpec | None:
    """Where `import_own` finds a module; None where there is none. Nothing is imported, no package around it either.

    Args:
        name: dotted.

    Raises:
        ValueError: the name is none, or of a module that does not say where it is from.
    """
    top, *inner = name.split(".")
    spec = _find_here(top, str(Path.cwd())) or find_spec(top)
    for part in inner:
        if spec is not None:
            spec = PathFinder.find_spec(f"{spec.name}.{part}", list(spec.submodule_search_locations or ()))
    return spec


def _find_here(top: str, here: str) -> ModuleSpec | None:
    """Where the working folder has the first part of a name; None where that is found elsewhere, or nowhere."""
    return None if top in sys.modules or find_spec(top) else PathFinder.find_spec(top, [here])

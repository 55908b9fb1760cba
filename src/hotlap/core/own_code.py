"""Own code: modules that a user has named, `--tuner my_module.MyTuner`, and nothing else of the working folder."""

from __future__ import annotations

import sys
import warnings
from importlib import import_module
from importlib.machinery import PathFinder
from importlib.util import find_spec
from multiprocessing import parent_process
from pathlib import Path
from types import ModuleType


class OwnCode(UserWarning):
    """Code of the working folder is run, since the user has named it."""


def import_own(name: str) -> ModuleType:
    """Import a module; one that is not installed is looked for in the working folder, and the user is told that its code runs.

    The working folder is on the path, last, during that import alone: what a module needs of it has to be imported at its top.

    Args:
        name: dotted.

    Raises:
        Exception: whatever the module raises.
    """
    top, here = name.partition(".")[0], str(Path.cwd())
    spec = None if top in sys.modules or find_spec(top) else PathFinder.find_spec(top, [here])
    if spec is None:
        return import_module(name)
    if parent_process() is None:  # a worker runs what its parent has said
        warnings.warn(f"runs code of {spec.origin or here}", OwnCode, stacklevel=3)
    path = list(sys.path)
    sys.path.append(here)
    try:
        return import_module(name)
    finally:
        sys.path[:] = path

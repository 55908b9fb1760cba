"""Needed: files and modules of the user that work reads where it is done, and that must be the same on every worker of a cluster."""

from __future__ import annotations

import hashlib
import platform
from importlib.machinery import ModuleSpec
from pathlib import Path

from hotlap.core.errors import InputError
from hotlap.core.own_code import find_own
from hotlap.system.disk_cache import digest_sources

Needed = tuple[tuple[str, str], ...]
"""(file or module, digest of its content)."""

_loaded: dict[str, str] = {}
"""Digests of the modules that this process has worked with: it goes on with what it has loaded, whatever lies there now."""


def digest_needed(what: str) -> str:
    """Sixteen hexadecimal digits of a file, or of a module as it lies there now; "" where there is none.

    Args:
        what: a path, or the dotted name of a module, which is looked for as `import_own` does, and not imported.
    """
    path = Path(what)
    try:
        if path.is_file():
            return _digest(path)
        spec = find_own(what)
        return "" if spec is None else _digest_module(spec)
    except (OSError, ImportError, ValueError):
        return ""


def check_needed(needed: Needed) -> None:
    """Refuse work that reads something else here than where it was asked for.

    Raises:
        InputError: a file or module is not here, is another one, or was another one when this process loaded it.
    """
    for what, digest in needed:
        loaded = _loaded.get(what, "")
        if loaded == digest:
            continue
        here = digest_needed(what)
        if here != digest or loaded:
            raise InputError("", "cluster", f"{what} {_fault(here, digest, loaded)}")
        if not Path(what).is_file():
            _loaded[what] = digest


def _fault(here: str, digest: str, loaded: str) -> str:
    """What is wrong on a worker, and what mends it.

    Args:
        here: digest of what lies there; "" where nothing does.
        digest: of what should.
        loaded: of what the worker has loaded; "" where it has not.
    """
    node = platform.node()
    if not here:
        return f"is not there on {node}, nor in its worker's folder {Path.cwd()}; install or copy it to every worker"
    if here == digest:
        return f"was another when a worker on {node} loaded it; restart the workers"
    return f"differs from ours on {node}; copy it to every worker{' and restart them' if loaded else ''}"


def _digest_module(spec: ModuleSpec) -> str:
    """Of a module's source, or of its compiled library; of all of a package.

    Raises:
        OSError: it has no file, as what is built into Python.
    """
    origin = Path(spec.origin or "")
    if origin.suffix != ".py":
        return _digest(origin)
    try:
        return digest_sources.__wrapped__(origin.parent if origin.name == "__init__.py" else origin)  # as it is now
    except SyntaxError:  # whoever imports it says where
        return _digest(origin)


def _digest(path: Path) -> str:
    """Of a file as it is."""
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]

"""Cache: where results that can be made again are kept between runs, and fingerprints of the code that made them."""

from __future__ import annotations

import hashlib
import os
import tempfile
from functools import cache
from importlib.util import find_spec
from pathlib import Path


def folder(name: str) -> Path:
    """Where results of a kind are kept: $HOTLAP_CACHE, else hotlap in $XDG_CACHE_HOME or ~/.cache; need not exist yet.

    Args:
        name: the kind, for example "plans".
    """
    own, shared = os.environ.get("HOTLAP_CACHE", ""), os.environ.get("XDG_CACHE_HOME", "")
    if own:
        return Path(own).expanduser().absolute() / name
    if Path(shared).is_absolute():  # the XDG specification has relative paths ignored
        return Path(shared) / "hotlap" / name
    try:
        return Path.home() / ".cache" / "hotlap" / name
    except RuntimeError:  # a user without a home
        return Path(tempfile.gettempdir()) / f"hotlap-{os.getuid()}" / name


@cache
def digest_sources(*sources: str | Path) -> str:
    """Sixteen hexadecimal digits that change whenever the code of the sources changes.

    Args:
        sources: dotted names of modules, which are not imported, or paths; a package or folder stands for its Python files.

    Raises:
        ModuleNotFoundError: when there is no such module.
    """
    digest = hashlib.sha256()
    for source in sources:
        for path in _files(source):
            content = path.read_bytes()
            digest.update(f"{path.name} {len(content)}\n".encode() + content)
    return digest.hexdigest()[:16]


def _files(source: str | Path) -> list[Path]:
    """The Python files of a module, file or folder, in a fixed order."""
    path = source if isinstance(source, Path) else _module_path(source)
    return sorted(path.rglob("*.py")) if path.is_dir() else [path]


def _module_path(name: str) -> Path:
    """The file of a module, or the folder of a package."""
    spec = find_spec(name)
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError(f"there is no module {name} to fingerprint", name=name)
    origin = Path(spec.origin)
    return origin.parent if origin.name == "__init__.py" else origin

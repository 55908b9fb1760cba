"""Disk cache: where results that can be made again are kept between runs, and fingerprints of the code that made them."""

from __future__ import annotations

import ast
import hashlib
import os
import sys
import tempfile
from collections.abc import Collection, Sequence
from contextlib import suppress
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
def digest_sources(*sources: str | Path, without: Collection[str] = ()) -> str:
    """Sixteen hexadecimal digits that change whenever what the sources compute could change.

    Comments, docstrings and formatting do not count. Parsing takes longer than reading: the digest of a text that was parsed before is
    looked up in the cache folder.

    Args:
        sources: dotted names of modules, which are not imported, or paths; a package or folder stands for its Python files.
        without: dotted names of modules to leave out, a tuple.

    Raises:
        ModuleNotFoundError: when there is no such module.
    """
    texts = [(path.name, path.read_bytes()) for path in source_files(*sources, without=without)]
    as_written = hashlib.sha256(f"{sys.implementation.cache_tag}\n".encode())
    for name, text in texts:
        as_written.update(f"{name} {len(text)}\n".encode() + text)
    kept = folder("digests") / as_written.hexdigest()[:32]
    with suppress(OSError, UnicodeDecodeError):
        known = kept.read_text(encoding="ascii")
        if len(known) == 16:
            return known
    found = _digest_code(texts)
    with suppress(OSError):
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_text(found, encoding="ascii")
    return found


def source_files(*sources: str | Path, without: Collection[str] = ()) -> list[Path]:
    """The Python files of modules, packages, files and folders, in a fixed order.

    Args:
        sources: as for `digest_sources`.
        without: likewise.

    Raises:
        ModuleNotFoundError: when there is no such module.
    """
    left_out = {path for name in without for path in _files(name)}
    return [path for source in sources for path in _files(source) if path not in left_out]


def _digest_code(texts: Sequence[tuple[str, bytes]]) -> str:
    """Sixteen hexadecimal digits of files' syntax trees, given by name and text."""
    digest = hashlib.sha256()
    for name, text in texts:
        tree = ast.parse(text)
        for node in ast.walk(tree):
            body = getattr(node, "body", None)
            if isinstance(body, list):
                node.body = [part for part in body if not _is_docstring(part)]  # pyright: ignore[reportAttributeAccessIssue]
        code = ast.dump(tree).encode()
        digest.update(f"{name} {len(code)}\n".encode() + code)
    return digest.hexdigest()[:16]


def _is_docstring(statement: ast.stmt) -> bool:
    """Whether a statement is a text by itself, which computes nothing."""
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant) and isinstance(statement.value.value, str)


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

"""Disk cache: where results that can be made again are kept between runs, and fingerprints of the code that made them."""

from __future__ import annotations

import ast
import atexit
import hashlib
import os
import shutil
import sys
import tempfile
import warnings
from collections.abc import Collection, Sequence
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from hotlap.core.errors import InputError
from hotlap.system import sealed
from hotlap.system.ownership import TEMPORARY, doubt, is_private, make_private, temporary
from hotlap.system.sealed import CacheWarning


def folder(name: str, *below: str) -> Path:
    """Where results of a kind are kept: $HOTLAP_CACHE, else hotlap in $XDG_CACHE_HOME or ~/.cache; need not exist yet.

    Compiled code is loaded from there, so a folder that others own, may write to or may replace is not used: `system/ownership.py`. In
    place of the usual one hotlap-UID in the folder of temporary files is taken; where that is no better a new one, which goes with the
    process. Processes that are started find it in the environment.

    Args:
        name: the kind, for example "plans".
        below: folders in it.

    Raises:
        InputError: $HOTLAP_CACHE names a folder that cannot be trusted, or that of an unknown user.
    """
    own = os.environ.get("HOTLAP_CACHE", "")
    if own:
        try:
            place = Path(own).expanduser().absolute().joinpath(name, *below)
        except RuntimeError:
            raise InputError("HOTLAP_CACHE", "", f"the home of {own.partition('/')[0]} is not known") from None
        reason = doubt(place)
        if reason:
            raise InputError("HOTLAP_CACHE", "", f"{reason}, so nothing is read from it: name a folder that is yours alone (chmod 700)")
        return place
    instead, usual = temporary(), _usual()
    if instead is None:
        reason = "this user has no home" if usual is None else doubt(usual.joinpath(name, *below))
        instead = _instead(reason) if reason else usual
    return instead.joinpath(name, *below)  # pyright: ignore[reportOptionalMemberAccess]  one of them is there


def _usual() -> Path | None:
    """The folder for a user who has named none; None for one without a home."""
    shared = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if shared.is_absolute():  # the XDG specification has relative paths ignored
        return shared / "hotlap"
    try:
        home = Path.home()
    except RuntimeError:
        return None
    return home / ".cache" / "hotlap" if home.is_absolute() else None


def _instead(reason: str) -> Path:
    """A folder for this process and those that it starts, in place of the usual one; says why."""
    place = _lasting()
    if place is None:
        place = Path(tempfile.mkdtemp(prefix="hotlap-")).absolute()
        atexit.register(_remove, place, os.getpid())
    os.environ[TEMPORARY] = str(place)
    warnings.warn(f"{reason}, so what is computed is kept in {place}; HOTLAP_CACHE=FOLDER names another one", CacheWarning, stacklevel=3)
    return place


def _lasting() -> Path | None:
    """One's own folder among the temporary ones, the same for every process; None where it is, or could become, somebody else's."""
    place = Path(tempfile.gettempdir()).absolute() / f"hotlap-{os.getuid()}"
    with suppress(OSError):
        if doubt(place):
            return None
        make_private(place)
        return place if is_private(place) else None
    return None


def _remove(place: Path, maker: int) -> None:
    """Remove a temporary folder, in the process that has made it."""
    if os.getpid() == maker:
        shutil.rmtree(place, ignore_errors=True)


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
    note = folder("digests") / f"{as_written.hexdigest()[:32]}.txt"
    known = sealed.read(note)
    if known is not None:
        return known.decode("ascii")
    found = _digest_code(texts)
    sealed.write(note, found.encode("ascii"))
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

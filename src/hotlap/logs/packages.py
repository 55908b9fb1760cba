"""Packages that read the logs of other programs: they are loaded when a log needs them."""

from __future__ import annotations

import contextlib
import io
import os
import warnings
from collections.abc import Iterator
from importlib import import_module
from types import ModuleType

from hotlap.core.errors import HotlapError, InputError

STANDARD_ERROR = 2  # its descriptor


def load(module: str, kind: str, name: str) -> ModuleType:
    """Import a module of a package.

    Args:
        module: its name.
        kind: of the log, in words.
        name: of the file.

    Raises:
        InputError: the package is not there.
    """
    try:
        return import_module(module)
    except ImportError:
        package = module.partition(".")[0]
        raise InputError(name, "", f"is {kind}, and {package} is missing, which reads it: pip install 'hotlap[logs]'") from None


@contextlib.contextmanager
def quietly(kind: str, name: str) -> Iterator[None]:
    """Let a package print nothing, and turn whatever it raises over a damaged file into one line.

    Raises:
        InputError: the file cannot be read.
    """
    nowhere = io.StringIO()
    try:
        with contextlib.redirect_stdout(nowhere), contextlib.redirect_stderr(nowhere), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except (HotlapError, OSError):
        raise
    except Exception as error:  # noqa: BLE001  packages raise all kinds over bytes that are damaged
        reason = " ".join(str(error).split())[:120]
        told = f"{type(error).__name__}: {reason}" if reason else type(error).__name__
        raise InputError(name, "", f"cannot be read as {kind}: it is cut short or damaged ({told})") from None


@contextlib.contextmanager
def without_remarks() -> Iterator[None]:
    """Let the compiled code of a package write nothing to standard error, which Python cannot turn aside."""
    try:
        kept = os.dup(STANDARD_ERROR)
    except OSError:  # closed: there is nothing to keep clean
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, STANDARD_ERROR)
        yield
    finally:
        os.dup2(kept, STANDARD_ERROR)
        os.close(kept)
        os.close(nowhere)

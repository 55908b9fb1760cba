"""Log: what a command says and does, with times: to a file, and with `--verbose` to standard error what is not said there anyway.

What is said goes through `output.note` and `failures.complain`; what is only done is a record of the level DEBUG.
"""

from __future__ import annotations

import logging
import os
import platform
import shlex
import sys
import time
from argparse import Namespace
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from hotlap.core.errors import HotlapError, InputError
from hotlap.core.version import __version__

LOG = logging.getLogger("hotlap")
LOG.addHandler(logging.NullHandler())  # who asks for no log is not given one
LIBRARIES = ("numpy", "numba", "casadi")  # whose versions are worth knowing
IN_FILE = "%(asctime)s %(levelname)s %(message)s"
SHOWN = "hotlap: %(asctime)s %(message)s"


@contextmanager
def logged(options: Namespace, name: str, arguments: Sequence[str]) -> Iterator[None]:
    """Log what runs within, if that is asked for.

    Args:
        options: `verbose` and `log_file` count.
        name: of the command.
        arguments: as it was called.

    Raises:
        InputError: the file cannot be written.
    """
    handlers = _handlers(options)
    if not handlers:
        yield
        return
    LOG.setLevel(logging.DEBUG)
    for handler in handlers:
        LOG.addHandler(handler)
    begun = time.monotonic()
    LOG.debug("%s", shlex.join(["hotlap", name, *arguments]))
    LOG.debug("%s", _surroundings())
    try:
        yield
    except BaseException as error:
        LOG.log(logging.ERROR, "%s", error if isinstance(error, HotlapError | OSError) else repr(error))
        LOG.debug("it arose after %.2f s:", time.monotonic() - begun, exc_info=error)
        raise
    else:
        LOG.debug("done after %.2f s", time.monotonic() - begun)
    finally:
        for handler in handlers:
            LOG.removeHandler(handler)
            handler.close()
        LOG.setLevel(logging.NOTSET)


def _handlers(options: Namespace) -> list[logging.Handler]:
    """What takes the records."""
    handlers = list[logging.Handler]()
    if options.log_file is not None:
        try:
            file = logging.FileHandler(options.log_file, encoding="utf-8", errors="backslashreplace")
        except OSError as error:
            raise InputError(str(options.log_file), "", f"cannot be written: {error.strerror or error}") from None
        file.setFormatter(logging.Formatter(IN_FILE))
        handlers.append(file)
    if options.verbose:
        shown = logging.StreamHandler(sys.stderr)
        shown.addFilter(lambda record: record.levelno == logging.DEBUG)  # all else is said anyway
        shown.setFormatter(logging.Formatter(SHOWN, datefmt="%H:%M:%S"))
        handlers.append(shown)
    return handlers


def _surroundings() -> str:
    """Versions, machine and folders, which a report of a fault needs."""
    from hotlap.system.disk_cache import folder  # noqa: PLC0415  only for who asks

    libraries = ", ".join(f"{name} {_version(name)}" for name in LIBRARIES)
    where = f"in {Path.cwd()}, caches in {folder('plans').parent}"
    machine = f"{platform.system()} {platform.machine()}, {os.cpu_count()} processors"
    return f"hotlap {__version__}, Python {platform.python_version()}, {libraries}; {machine}; {where}"


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "missing"

"""Failures: an error as one line on standard error, and with `--json` as one JSON document on standard output, too."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from hotlap.cli.words import as_command
from hotlap.core.errors import HotlapError, InputError, UnknownNameError
from hotlap.core.printable import printable


def wants_json(arguments: Sequence[str]) -> bool:
    """Whether `--json` stands among what was asked for, understood or not."""
    options = arguments[: arguments.index("--")] if "--" in arguments else arguments
    return "--json" in options


def complain(message: str, status: int) -> int:
    """One line on standard error; gives the exit status back."""
    sys.stderr.write(f"hotlap: {printable(as_command(message))}\n")
    return status


def describe(error: HotlapError | OSError, status: int) -> dict[str, Any]:
    """An error as plain values; see docs/commands.md.

    Args:
        error: what went wrong.
        status: with which the program exits.
    """
    source, key, reason = "", "", str(error)
    if isinstance(error, InputError):
        source, key, reason = error.source, error.key, error.reason
    elif isinstance(error, OSError):
        source, reason = str(error.filename), error.strerror or str(error)
    is_option = source.startswith("-") or source.isupper()
    told = {
        "file": None if is_option else source or None,
        "option": source if is_option else None,
        "key": key or None,
        "reason": as_command(reason),
        "status": status,
    }
    return {"error": {**told, **({"available": list(error.available)} if isinstance(error, UnknownNameError) else {})}}


def print_json(error: HotlapError | OSError, status: int) -> None:
    """Print an error as JSON; where nobody reads it, or it cannot be written, the line on standard error is all."""
    try:
        sys.stdout.write(json.dumps(describe(error, status), indent=2) + "\n")
        sys.stdout.flush()
    except OSError:
        drop_output()


def drop_output() -> None:
    """Let what is still to be flushed go nowhere, so that the interpreter does not fail over it again."""
    with suppress(OSError), Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        os.dup2(nowhere.fileno(), sys.stdout.fileno())

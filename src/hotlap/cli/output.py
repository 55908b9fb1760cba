"""Output: results to standard output, as text or as one JSON document; everything else to standard error."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NoReturn

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.text import Text

from hotlap.cli.log import LOG
from hotlap.cli.words import as_command
from hotlap.core.finite import finite

Line = str | Text


class Plain(Console):
    """A console that prints words as they are, and lets a broken pipe be heard of.

    Args:
        stderr: to standard error, else to standard output.
    """

    def __init__(self, *, stderr: bool) -> None:
        super().__init__(stderr=stderr, highlight=False, markup=False, emoji=False)

    def on_broken_pipe(self) -> NoReturn:
        """Rich would end the program here."""
        raise BrokenPipeError


def present(*, as_json: bool, document: Mapping[str, Any], lines: Iterable[Line]) -> None:
    """Print the result of a command, in one of its two forms.

    Args:
        as_json: print `document`, else `lines`.
        document: plain values; numbers that are not finite become null.
        lines: text for people.
    """
    if as_json:
        sys.stdout.write(json.dumps(finite(document), indent=2, allow_nan=False) + "\n")
        return
    console = Plain(stderr=False)
    for line in lines:
        console.print(line, soft_wrap=True)


def note(text: str) -> None:
    """Say something beside the result."""
    told = as_command(text)
    LOG.info("%s", told)
    Plain(stderr=True).print(told, soft_wrap=True)


@contextmanager
def working(text: str) -> Iterator[None]:
    """Say what takes its time: a spinner with a clock on a terminal, else one line."""
    console, begun = Plain(stderr=True), time.monotonic()
    if not console.is_terminal:
        note(f"{text} ...")
        yield
        LOG.debug("%s: %.2f s", text, time.monotonic() - begun)
        return
    LOG.info("%s ...", text)
    words = TextColumn("{task.description}", markup=False)
    with Progress(SpinnerColumn(), words, TimeElapsedColumn(), console=console, transient=True) as progress:
        progress.add_task(f"{text} ...", total=None)
        yield
    LOG.debug("%s: %.2f s", text, time.monotonic() - begun)


def table(rows: Sequence[Sequence[str]], *, right: Iterable[int] = (), indent: str = "") -> list[str]:
    """Rows with their columns aligned, whatever the width of the terminal.

    Args:
        rows: cells.
        right: columns that are aligned to the right.
        indent: before each row.
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    flush_right = set(right)
    aligned = (
        [cell.rjust(width) if j in flush_right else cell.ljust(width) for j, (cell, width) in enumerate(zip(row, widths, strict=True))]
        for row in rows
    )
    return [(indent + "  ".join(row)).rstrip() for row in aligned]


def facts(pairs: Mapping[str, str]) -> list[str]:
    """Labelled values below each other; those that are empty are left out."""
    return table([(label, value) for label, value in pairs.items() if value], indent="  ")

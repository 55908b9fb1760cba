"""Run what a page shows: python docs/transcript.py docs/tutorial.md writes what its commands print, from an empty folder.

A block whose first line is `# NAME` is a file that the reader writes; a `console` block is commands after `$ ` with what they print.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import runpy
import shlex
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

BLOCK = re.compile(r"^```(?P<language>toml|python|console)\n(?P<text>.*?)^```$", re.DOTALL | re.MULTILINE)
FILE = re.compile(r"# (\S+\.(?:toml|py))\n")
COMMAND = re.compile(r"^\$ (.*)\n", re.MULTILINE)
NUMBER = re.compile(r"-?\d+(\.\d+)?(e-?\d+)?")
VARYING = re.compile(r"[\u2800-\u28ff]|missed gate|crashed|hit the|touched|left the box")  # dots of a map, and how flights ended


COLUMNS = 112  # that a page has for a line of a program, on a screen of 1280 pixels


class CommandError(Exception):
    """A command of a page does not work."""


@dataclass(frozen=True)
class Command:
    """A command of a page.

    Attributes:
        words: as in a shell.
        printed: what the page says that it prints.
    """

    words: tuple[str, ...]
    printed: str


def perform(page: str) -> Iterator[tuple[Command, str]]:
    """Do in the working folder what a page says; each command with what it really prints."""
    for block in BLOCK.finditer(page):
        named = FILE.match(block["text"])
        if block["language"] != "console":
            if named:
                Path(named[1]).write_text(block["text"], encoding="utf-8")
            continue
        _, *parts = COMMAND.split(block["text"])
        for line, printed in zip(parts[::2], parts[1::2], strict=True):
            command = Command(tuple(shlex.split(line)), printed)
            yield command, run(command.words)


def run(words: tuple[str, ...]) -> str:
    """What a command prints.

    Raises:
        CommandError: it fails, or is none of `hotlap` and `python`.
    """
    from hotlap.cli import main  # noqa: PLC0415  reading a page takes none of it

    program, *arguments = words
    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = str(COLUMNS)
    try:
        with contextlib.redirect_stdout(io.StringIO()) as output:
            if program == "python":
                runpy.run_path(arguments[0], run_name="__main__")
            elif program != "hotlap":
                raise CommandError(f"{shlex.join(words)}: not run here")
            elif status := main(arguments):
                raise CommandError(f"{shlex.join(words)}: exit status {status}")
        return output.getvalue()
    finally:
        os.environ.pop("COLUMNS") if before is None else os.environ.update(COLUMNS=before)


def outline(printed: str) -> list[str]:
    """Lines without their numbers and without what differs from machine to machine."""
    exact = printed.replace("top speed about ", "top speed ")  # that a race which was planned before has
    return [" ".join(NUMBER.sub("0", line).split()) for line in exact.splitlines() if line.strip() and not VARYING.search(line)]


def rewrite(page: str) -> str:
    """The page with what its commands print, performed in an empty folder."""
    here = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            outputs = iter([printed for _, printed in perform(page)])
        finally:
            os.chdir(here)

    def filled(block: re.Match[str]) -> str:
        if block["language"] != "console":
            return block[0]
        lines = [f"$ {line}\n{next(outputs)}" for line in COMMAND.findall(block["text"])]
        return f"```console\n{''.join(lines)}```"

    return BLOCK.sub(filled, page)


if __name__ == "__main__":
    for name in sys.argv[1:]:
        path = Path(name)
        path.write_text(rewrite(path.read_text(encoding="utf-8")), encoding="utf-8")

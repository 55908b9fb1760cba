"""Commands: the reference of the command line, made from its parsers."""

from __future__ import annotations

import argparse
import re
import textwrap

from sphinx.application import Sphinx

from hotlap.cli.arguments import COMMANDS, Command

PLACEHOLDER = "<!-- commands -->"
WIDTH = 82  # of a usage, so that a page does not scroll
OPTIONAL = re.compile(r"\[[^]]*\]")
KEPT = "\0"


def reference() -> str:
    """Every command as a section of Markdown."""
    return "\n".join(section(name, command) for name, command in COMMANDS.items())


def section(name: str, command: Command) -> str:
    """What a command does, its usage, arguments and examples."""
    parser = command.parser(name)
    words = " ".join(parser.format_usage().removeprefix("usage: ").split())
    kept = OPTIONAL.sub(lambda option: option[0].replace(" ", KEPT), words)  # an option stays on its line
    usage = textwrap.fill(kept, WIDTH, subsequent_indent=" " * len(f"hotlap {name} "), break_on_hyphens=False).replace(KEPT, " ")
    rows = "\n".join(row(action) for action in parser._actions)  # noqa: SLF001  argparse has no other list of them
    examples = "\n\n".join(f"    {line}" for line in command.examples)
    parts = [f"## hotlap {name}", command.summary.replace("\n", " "), f"```text\n{usage}\n```", f"| argument | |\n|---|---|\n{rows}"]
    return "\n\n".join([*parts, *([f"```sh\n{chr(10).join(command.examples)}\n```"] if examples else [])]) + "\n"


def row(action: argparse.Action) -> str:
    """An argument: how it is written, and what it means."""
    value = "" if action.nargs == 0 else f" {action.metavar or action.dest.upper()}"
    written = ", ".join(f"{option}{value}" for option in action.option_strings) or str(action.metavar)
    meaning = (action.help or "").replace("|", "\\|").replace("<", "&lt;")
    return f"| `{written}` | {meaning} |"


def fill(_: Sphinx, __: str, source: list[str]) -> None:
    """Put the reference where a page asks for it."""
    if PLACEHOLDER in source[0]:
        source[0] = source[0].replace(PLACEHOLDER, reference())


def setup(app: Sphinx) -> dict[str, bool]:
    """Fill pages as they are read."""
    app.connect("source-read", fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""Docstrings: as they are written in hotlap, to what Sphinx reads.

They are plain text: indented lines are formulas or code, a bar is an absolute value, a star is a product, and `NAME: meaning` describes a
member of an enumeration.
"""

from __future__ import annotations

import re
from enum import EnumMeta
from itertools import groupby
from typing import Any

from sphinx.application import Sphinx

from hotlap.schema import Described

SECTION = re.compile(r"(Args|Attributes|Raises|Returns|Yields):$")
MEMBER = re.compile(r"([A-Z][A-Z0-9_]*): (.*)")
CODE = re.compile(r"`([^`]*)`(?=(\w?))")
SPECIAL = re.compile(r"([|*]|(?<=\w)_(?!\w))")
ARRAY = re.compile(r"~?(?:numpy\.)?ndarray\[~?tuple\[~?(?:typing\.)?Any, \.\.\.\], ~?(?:numpy\.)?dtype\[~?(?:numpy\.)?(\w+)\]\]")
ITEM = ("- ", "* ")


def prepare(_: Sphinx, __: str, ___: str, described: Any, ____: Any, lines: list[str]) -> None:
    """Change the lines of a docstring in place."""
    body, sections = split(lines)
    body = members(body) if isinstance(described, EnumMeta) else body
    lines[:] = [*marked_up(body), *attributes([escape(line) for line in sections])]


def split(lines: list[str]) -> tuple[list[str], list[str]]:
    """What stands before the first section, and the sections."""
    first = next((i for i, line in enumerate(lines) if SECTION.match(line)), len(lines))
    return lines[:first], lines[first:]


def escape(line: str) -> str:
    """A line of prose without marks of its own; what stands in backticks is code, and a word may follow it at once."""
    shown, end = "", 0
    for code in CODE.finditer(line):
        shown += SPECIAL.sub(r"\\\1", line[end : code.start()]) + f"``{code[1]}``" + ("\\ " if code[2] else "")
        end = code.end()
    return shown + SPECIAL.sub(r"\\\1", line[end:])


def members(lines: list[str]) -> list[str]:
    """Members of an enumeration as items of a list."""
    return [MEMBER.sub(r"- `\1`: \2", line) if MEMBER.fullmatch(line) else line for line in lines]


def attributes(lines: list[str]) -> list[str]:
    """The section of attributes as a list: their names are no references, as other classes have the same."""
    shown, within = [], False
    for line in lines:
        if line == "Attributes:":
            shown += [":Attributes:", ""]
            within = True
        elif within and line.startswith("    ") and not line.startswith("     "):
            names, _, meaning = line.strip().partition(": ")
            shown.append(f"    - **{names}**: {meaning}")
        else:
            within = within and (not line.strip() or line.startswith("    "))
            shown.append(f"  {line}" if within and line.strip() else line)
    return shown


def marked_up(lines: list[str]) -> list[str]:
    """Indented paragraphs as literal blocks, the rest as prose and lists."""
    shown, within = [], False
    for blank, group in groupby(lines, key=lambda line: not line.strip()):
        paragraph = list(group)
        if blank:
            continue
        indented = paragraph[0].startswith("  ")
        shown += ["::", ""] if indented and not within else []
        shown += [*(paragraph if indented else listed(paragraph)), ""]
        within = indented
    return shown


def listed(paragraph: list[str]) -> list[str]:
    """A paragraph in which items are set off from prose by blank lines."""
    shown, listing = [], False
    for line in paragraph:
        item = line.startswith(ITEM)
        if shown and item != listing and not line.startswith(" "):
            shown.append("")
        listing = item or (listing and line.startswith(" "))
        indent = "  " if listing else ""
        shown.append(line[:2] + escape(line[2:]) if item else indent + escape(line.strip()))
    return shown


def shorten(
    _: Sphinx, __: str, ___: str, described: Any, ____: Any, arguments: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """A signature with arrays as they are written; none for what is read from files, whose keys are its attributes."""
    if isinstance(described, type) and issubclass(described, Described):
        return "", None
    return ARRAY.sub(r"NDArray[\1]", arguments or "") or None, ARRAY.sub(r"NDArray[\1]", returned or "") or None


def setup(app: Sphinx) -> dict[str, bool]:
    """Change docstrings before the sections are read."""
    app.connect("autodoc-process-docstring", prepare, priority=100)
    app.connect("autodoc-process-signature", shorten)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""Docstrings: as they are written in hotlap, to what Sphinx reads.

They are plain text: indented lines are formulas or code, a bar is an absolute value, a star is a product, and `NAME: meaning` describes a
member of an enumeration.
"""

from __future__ import annotations

import re
from enum import EnumMeta
from itertools import groupby
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

from hotlap.race.schema import Described

SECTION = re.compile(r"(Args|Attributes|Raises|Returns|Yields):$")
MEMBER = re.compile(r"([A-Z][A-Z0-9_]*): (.*)")
CODE = re.compile(r"`([^`]*)`(?=(\w?))")
SPECIAL = re.compile(r"([|*]|(?<=\w)_(?!\w))")
HOME = r"~?(?:\w+\.)?"  # before a name
ARRAY = re.compile(rf"{HOME}ndarray\[{HOME}tuple\[{HOME}Any, \.\.\.\], {HOME}dtype\[{HOME}(\w+(?:\[{HOME}Any\])?)\]\]")
VALUES = ("attribute", "data", "property")
COLON = "\ue000"  # stands for a colon before which napoleon would see a type
ITEM = re.compile(r"[-*] |\d+\. ")


def prepare(_: Sphinx, kind: str, __: str, described: Any, ___: Any, lines: list[str]) -> None:
    """Change the lines of a docstring in place."""
    body, sections = split(lines)
    body = members(body) if isinstance(described, EnumMeta) else body
    lines[:] = [*marked_up(body), *attributes([escape(line) for line in sections])]
    if kind in VALUES:
        lines[:] = [line.replace(":", COLON) for line in lines]


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
    """A paragraph in which items are set off from prose by blank lines, and lines that are indented below prose stay lines."""
    shown, before, width = [], "", 0
    for line in paragraph:
        item, text = ITEM.match(line), line.strip()
        if item:
            kind, width, text = "item", item.end(), line[item.end() :]
        else:
            kind = "prose" if not line.startswith(" ") else "item" if before == "item" else "verse"
        mark = item[0] if item else {"prose": "", "item": " " * width, "verse": "| "}[kind]
        shown += [*([""] if before not in {"", kind} else []), mark + escape(text)]
        before = kind
    return shown


def shorten(
    _: Sphinx, __: str, ___: str, described: Any, ____: Any, arguments: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """A signature with arrays as they are written; none for what is read from files, whose keys are its attributes."""
    if isinstance(described, type) and issubclass(described, Described):
        return "", None
    return ARRAY.sub(r"NDArray[\1]", arguments or "") or None, ARRAY.sub(r"NDArray[\1]", returned or "") or None


def shorten_annotations(_: Sphinx, document: nodes.document) -> None:
    """The same for the types of properties and attributes."""
    for annotation in document.findall(addnodes.desc_annotation):
        if ARRAY.search(annotation.astext()):
            annotation[:] = [nodes.Text(ARRAY.sub(r"NDArray[\1]", annotation.astext()))]


def restore_colons(_: Sphinx, __: str, ___: str, ____: Any, _____: Any, lines: list[str]) -> None:
    """Bring back what `prepare` hid."""
    lines[:] = [line.replace(COLON, ":") for line in lines]


def setup(app: Sphinx) -> dict[str, bool]:
    """Change docstrings before the sections are read."""
    app.connect("autodoc-process-docstring", prepare, priority=100)
    app.connect("autodoc-process-docstring", restore_colons, priority=900)
    app.connect("autodoc-process-signature", shorten)
    app.connect("doctree-read", shorten_annotations)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

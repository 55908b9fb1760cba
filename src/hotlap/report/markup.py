"""Markup: the little HTML that pages are made of; every text is escaped on its way in."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from html import escape


def text(value: object) -> str:
    """Words as HTML."""
    return escape(str(value))


def element(name: str, content: str = "", **attributes: object) -> str:
    """An element with content that is HTML already; attributes are escaped, `class_` stands for class."""
    shown = "".join(f' {key.rstrip("_").replace("_", "-")}="{escape(str(value))}"' for key, value in attributes.items())
    return f"<{name}{shown}>{content}</{name}>"


def paragraph(words: object) -> str:
    """A paragraph."""
    return element("p", text(words))


def table(heads: Sequence[object], rows: Iterable[Sequence[object]], caption: str = "", *, numbers: Container[int] = ()) -> str:
    """A table that scrolls by itself where it is too wide.

    Args:
        heads: of the columns.
        rows: cells.
        caption: above it.
        numbers: columns that hold numbers, counted from 0.
    """
    title = element("caption", text(caption)) if caption else ""
    kinds = [{"class_": "number"} if j in numbers else {} for j in range(len(heads))]
    names = "".join(element("th", text(cell), scope="col", **kind) for cell, kind in zip(heads, kinds, strict=True))
    head = element("thead", element("tr", names))
    body = "".join(element("tr", "".join(_cell(cell, j, kinds[j]) for j, cell in enumerate(row))) for row in rows)
    return element("div", element("table", title + head + element("tbody", body)), class_="wide")


def _cell(cell: object, column: int, kind: dict[str, str]) -> str:
    """The first of a row names it."""
    return element("td", text(cell), **kind) if column else element("th", text(cell), scope="row")


def facts(pairs: Mapping[str, object]) -> str:
    """Labelled values; those that are empty are left out."""
    return element("dl", "".join(element("dt", text(label)) + element("dd", text(value)) for label, value in pairs.items() if value != ""))

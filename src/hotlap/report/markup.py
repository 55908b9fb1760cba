"""Markup: HTML elements as strings; all text and attributes are escaped."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from html import escape


def text(value: object) -> str:
    """A value as HTML text."""
    return escape(str(value))


def element(name: str, content: str = "", **attributes: object) -> str:
    """An HTML element; its content is HTML already, its attributes are escaped; `class_` is the attribute class."""
    written = "".join(f' {key.rstrip("_").replace("_", "-")}="{escape(str(value))}"' for key, value in attributes.items())
    return f"<{name}{written}>{content}</{name}>"


def paragraph(words: object) -> str:
    """A paragraph of text."""
    return element("p", text(words))


def table(heads: Sequence[object], rows: Iterable[Sequence[object]], caption: str = "", *, numbers: Container[int] = ()) -> str:
    """A table; where it is wider than the page, it scrolls on its own.

    Args:
        heads: of the columns.
        rows: cells.
        caption: above it.
        numbers: indices of the columns with numbers, which are aligned to the right.
    """
    title = element("caption", text(caption)) if caption else ""
    kinds = [{"class_": "number"} if j in numbers else {} for j in range(len(heads))]
    names = "".join(element("th", text(cell), scope="col", **kind) for cell, kind in zip(heads, kinds, strict=True))
    head = element("thead", element("tr", names))
    body = "".join(element("tr", "".join(_cell(cell, j, kinds[j]) for j, cell in enumerate(row))) for row in rows)
    return element("div", element("table", title + head + element("tbody", body)), class_="wide")


def _cell(cell: object, column: int, kind: dict[str, str]) -> str:
    """One cell; the first of a row is its head."""
    return element("td", text(cell), **kind) if column else element("th", text(cell), scope="row")


def facts(pairs: Mapping[str, object]) -> str:
    """A list of labels and values; empty values are left out."""
    return element("dl", "".join(element("dt", text(label)) + element("dd", text(value)) for label, value in pairs.items() if value != ""))

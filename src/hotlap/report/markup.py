"""Markup: HTML elements as strings; all text and attributes are escaped."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from html import escape

LONG = 28  # characters of a name, beyond which it has a line of its own in a table, or more than one as the head of a column


def text(value: object) -> str:
    """A value as HTML text; of a file's name that is no text the bytes are shown."""
    return escape(str(value).encode("utf-8", "backslashreplace").decode())


def element(name: str, content: str = "", **attributes: object) -> str:
    """An HTML element; its content is HTML already, its attributes are escaped; `class_` is the attribute class."""
    written = "".join(f' {key.rstrip("_").replace("_", "-")}="{text(value)}"' for key, value in attributes.items())
    return f"<{name}{written}>{content}</{name}>"


def paragraph(words: object) -> str:
    """A paragraph of text."""
    return element("p", text(words))


def table(heads: Sequence[object], rows: Iterable[Sequence[object]], caption: str = "", *, numbers: Container[int] = ()) -> str:
    """A table; where it is wider than the page, it scrolls on its own. A long name of a row stands on a line above its cells.

    Args:
        heads: of the columns.
        rows: cells.
        caption: above it.
        numbers: indices of the columns with numbers, which are aligned to the right.
    """
    title = element("caption", text(caption)) if caption else ""
    kinds = [["number"] if j in numbers else [] for j in range(len(heads))]
    names = "".join(element("th", text(cell), scope="col", **_class(kind, cell)) for cell, kind in zip(heads, kinds, strict=True))
    head = element("thead", element("tr", names))
    body = "".join(_row(row, kinds) for row in rows)
    return element("div", element("table", title + head + element("tbody", body)), class_="wide")


def sortable(heads: Sequence[object], rows: Iterable[Sequence[object]], *, numbers: Container[int] = ()) -> str:
    """A table that a script may sort by any column, so that every row is one line of it; arguments as for `table`."""
    kinds = [["number"] if j in numbers else [] for j in range(len(heads))]
    names = "".join(element("th", text(head), scope="col", **_class(kind)) for head, kind in zip(heads, kinds, strict=True))
    body = "".join(
        element(
            "tr", element("th", text(name), scope="row") + "".join(_data(cell, kind) for cell, kind in zip(cells, kinds[1:], strict=True))
        )
        for name, *cells in rows
    )
    head = element("thead", element("tr", names))
    return element("div", element("table", head + element("tbody", body), class_="sortable"), class_="wide")


def _data(cell: object, kind: Sequence[str]) -> str:
    return element("td", text(cell), **_class(kind))


def _row(row: Sequence[object], kinds: Sequence[Sequence[str]]) -> str:
    """The cells of a row, the first of which is its head."""
    name, *cells = row
    rest = "".join(_data(cell, kind) for cell, kind in zip(cells, kinds[1:], strict=True))
    if cells and len(str(name)) > LONG:
        head = element("th", text(name), scope="row", colspan=len(row), **_class([], name))
        return element("tr", head, class_="over") + element("tr", element("td") + rest)
    return element("tr", element("th", text(name), scope="row") + rest)


def _class(kinds: Sequence[str], cell: object = "") -> dict[str, str]:
    """The attribute of a cell of some kinds, and of one that is long; empty where it is of none."""
    every = [*kinds, *["long"] * (len(str(cell)) > LONG)]
    return {"class_": " ".join(every)} if every else {}


def facts(pairs: Mapping[str, object]) -> str:
    """A list of labels and values; empty values are left out."""
    return element("dl", "".join(element("dt", text(label)) + element("dd", text(value)) for label, value in pairs.items() if value != ""))

"""Article: text, tables and pictures for people, written once and shown as Markdown or as one HTML file that needs nothing else."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from hotlap.report.markup import element, text
from hotlap.report.markup import table as table_of
from hotlap.report.style_sheet import STYLE

KINDS = {".png": "image/png", ".svg": "image/svg+xml"}
_NUMBER = re.compile(r"([-+]?[\d.]+( ?[%(\[/].*)?|-( \[.*)?)?", re.DOTALL)
_MARKS = re.compile(r"`(?P<code>[^`]+)`|\*\*(?P<strong>\S[^*]*)\*\*|\*(?P<em>[^*\s][^*]*)\*")


@dataclass(frozen=True)
class Heading:
    """Of a section."""

    words: str

    def markdown(self) -> str:
        """A line."""
        return f"## {self.words}"

    def html(self) -> str:
        """An element."""
        return element("h2", inline(self.words))


@dataclass(frozen=True)
class Paragraph:
    """Some sentences, in which `code`, *emphasis* and **more of it** may stand."""

    words: str

    def markdown(self) -> str:
        """As it is written."""
        return self.words

    def html(self) -> str:
        """An element."""
        return element("p", inline(self.words))


@dataclass(frozen=True)
class Table:
    """Rows of cells below their heads."""

    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def markdown(self) -> str:
        """With pipes."""
        lines = [f"| {' | '.join(self.heads)} |", f"|{'---|' * len(self.heads)}"]
        return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in self.rows)])

    def html(self) -> str:
        """An element; columns of numbers are aligned to the right."""
        columns = enumerate(zip(*self.rows, strict=True))
        numbers = [j for j, column in columns if all(_NUMBER.fullmatch(cell.strip()) for cell in column)]
        return table_of(self.heads, self.rows, numbers=numbers)


@dataclass(frozen=True)
class Picture:
    """A file beside the article."""

    path: Path
    caption: str

    def markdown(self) -> str:
        """A reference to the file."""
        return f"![{self.caption}]({self.path.name})"

    def html(self) -> str:
        """The picture itself, within the page."""
        content = base64.b64encode(self.path.read_bytes()).decode("ascii")
        image = f'<img src="data:{KINDS[self.path.suffix]};base64,{content}" alt="{text(self.caption)}">'
        return element("figure", image + element("figcaption", inline(self.caption)))


@dataclass
class Article:
    """From top to bottom.

    Attributes:
        title: of all of it.
        parts: headings, paragraphs, tables and pictures.
        source: name of the file beside it that holds what it says; "" for none.
    """

    title: str
    parts: list[Heading | Paragraph | Table | Picture] = field(default_factory=list)
    source: str = ""

    def say(self, words: str) -> None:
        """A paragraph."""
        self.parts.append(Paragraph(words))

    def head(self, words: str) -> None:
        """A heading below the title."""
        self.parts.append(Heading(words))

    def table(self, heads: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
        """A table; numbers as they are written."""
        self.parts.append(Table(tuple(heads), tuple(tuple(map(str, row)) for row in rows)))

    def picture(self, path: Path, caption: str) -> None:
        """A picture, one of `KINDS`, that lies beside the article."""
        self.parts.append(Picture(path, caption))

    @property
    def pictures(self) -> list[Path]:
        """Files that were drawn."""
        return [part.path for part in self.parts if isinstance(part, Picture)]

    @property
    def markdown(self) -> str:
        """The whole, with its pictures beside it."""
        return "\n\n".join([f"# {self.title}", *(part.markdown() for part in self.parts)]) + "\n"

    @property
    def html(self) -> str:
        """The whole in one file, with its pictures in it.

        Raises:
            OSError: a picture cannot be read.
        """
        source = element("p", "The runs behind it: " + element("a", text(self.source), href=self.source)) if self.source else ""
        body = element("main", "\n".join([element("h1", text(self.title)), *(part.html() for part in self.parts), source]))
        head = '<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
        head += (
            '<meta name="color-scheme" content="light dark">' + element("title", text(f"{self.title} - hotlap")) + element("style", STYLE)
        )
        return f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>{body}</body></html>\n'


def inline(words: str) -> str:
    """Words as HTML, with the few marks that a paragraph may have."""
    return _MARKS.sub(lambda found: element(str(found.lastgroup), found[str(found.lastgroup)]), text(words))

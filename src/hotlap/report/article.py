"""Article: text, tables and pictures, written once and saved as Markdown and as one HTML file that loads nothing from elsewhere."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from markdown_it import MarkdownIt

from hotlap.report.markup import element, sortable, text
from hotlap.report.markup import table as table_of

KINDS = {".png": "image/png", ".svg": "image/svg+xml"}
_NUMBER = re.compile(r"([-+<]?[\d.]+( ?[%(\[/].*)?|-( \[.*)?)?", re.DOTALL)
_INLINE = MarkdownIt("zero").enable(["backticks", "emphasis"])  # all other characters are text, those of HTML too


@dataclass(frozen=True)
class Heading:
    """The heading of a section."""

    words: str

    def markdown(self) -> str:
        """The heading as a line of Markdown."""
        return f"## {self.words}"

    def html(self) -> str:
        """The heading as an HTML element."""
        return element("h2", inline(self.words))


@dataclass(frozen=True)
class Paragraph:
    """Some sentences; `code`, *emphasis* and **strong emphasis** are marked as in Markdown."""

    words: str

    def markdown(self) -> str:
        """The sentences as they were written."""
        return self.words

    def html(self) -> str:
        """The sentences as an HTML element."""
        return element("p", inline(self.words))


@dataclass(frozen=True)
class Table:
    """A table: the heads of its columns, rows of cells, and whether a script of the page may sort it."""

    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    sortable: bool = False

    def markdown(self) -> str:
        """The table in Markdown, columns separated by bars."""
        lines = [f"| {' | '.join(self.heads)} |", f"|{'---|' * len(self.heads)}"]
        return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in self.rows)])

    def html(self) -> str:
        """The table as an HTML element; columns of numbers are aligned to the right."""
        columns = enumerate(zip(*self.rows, strict=True))
        numbers = [j for j, column in columns if all(_NUMBER.fullmatch(cell.strip()) for cell in column)]
        return (sortable if self.sortable else table_of)(self.heads, self.rows, numbers=numbers)


@dataclass(frozen=True)
class Picture:
    """A picture: a file in the folder of the article, and its caption."""

    path: Path
    caption: str

    def markdown(self) -> str:
        """A reference to the file in Markdown."""
        return f"![{self.caption}]({self.path.name})"

    def html(self) -> str:
        """The picture with its caption as an HTML element that contains the file."""
        content = base64.b64encode(self.path.read_bytes()).decode("ascii")
        image = f'<img src="data:{KINDS[self.path.suffix]};base64,{content}" alt="{text(self.caption)}">'
        return element("figure", image + element("figcaption", inline(self.caption)))


@dataclass(frozen=True)
class Drawing:
    """HTML that is ready, and the words that stand for it in Markdown."""

    content: str
    words: str = ""

    def markdown(self) -> str:
        """The words."""
        return self.words

    def html(self) -> str:
        """The HTML as it was given."""
        return self.content


@dataclass
class Article:
    """A title, and the parts of the article from top to bottom.

    Attributes:
        title: of the whole article.
        parts: headings, paragraphs, tables, pictures and drawings.
        source: name of the file with the results that the article reports, in the same folder; "" for none.
        style: CSS of its own, beside that of every article.
        script: JavaScript of its own; without it everything can be read as well.
    """

    title: str
    parts: list[Heading | Paragraph | Table | Picture | Drawing] = field(default_factory=list)
    source: str = ""
    style: str = ""
    script: str = ""

    def say(self, words: str) -> None:
        """Add a paragraph."""
        self.parts.append(Paragraph(words))

    def head(self, words: str) -> None:
        """Add the heading of a section."""
        self.parts.append(Heading(words))

    def table(self, heads: Sequence[str], rows: Iterable[Sequence[object]], *, sortable: bool = False) -> None:
        """Add a table; cells that are no text are converted by `str`."""
        self.parts.append(Table(tuple(heads), tuple(tuple(map(str, row)) for row in rows), sortable))

    def picture(self, path: Path, caption: str) -> None:
        """Add a picture: a file of one of `KINDS` in the folder of the article."""
        self.parts.append(Picture(path, caption))

    def draw(self, html: str, words: str = "") -> None:
        """Add HTML that is ready; `words` stand for it in Markdown."""
        self.parts.append(Drawing(html, words))

    @property
    def pictures(self) -> list[Path]:
        """Paths of all pictures."""
        return [part.path for part in self.parts if isinstance(part, Picture)]

    @property
    def markdown(self) -> str:
        """The article as Markdown; its pictures stay files of their own."""
        return "\n\n".join([f"# {self.title}", *filter(None, (part.markdown() for part in self.parts))]) + "\n"

    @property
    def html(self) -> str:
        """The article as one HTML file that contains its pictures.

        Raises:
            OSError: a picture cannot be read.
        """
        source = element("p", "The runs behind it: " + element("a", text(self.source), href=self.source)) if self.source else ""
        body = element("main", "\n".join([element("h1", text(self.title)), *(part.html() for part in self.parts), source]))
        head = '<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
        head += '<meta name="color-scheme" content="light dark">' + element("title", text(f"{self.title} - hotlap"))
        head += element("style", f"{STYLE}\n{self.style}".strip())
        script = element("script", self.script) if self.script else ""
        return f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>{body}{script}</body></html>\n'


def inline(words: str) -> str:
    """Words as HTML: `code`, *emphasis* and **strong emphasis** become elements, all other marks stay text."""
    return _INLINE.renderInline(words)


def percent(share: float) -> str:
    """A share, 0 to 1, in whole per cent, without the sign."""
    return f"{100 * share:.0f}"


STYLE = """
:root { color-scheme: light dark; --ink: #1d2228; --quiet: #626b75; --line: #d9dde2; --paper: #ffffff; --accent: #0063a6;
  --more: #00000045; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e9ed; --quiet: #9aa4af; --line: #343c46; --paper: #14181d; --accent: #6cb6f0;
    --more: #ffffff60; }
}
body { margin: 0; background: var(--paper); color: var(--ink); font: 16px/1.5 system-ui, sans-serif; }
main { max-width: 72rem; margin: 0 auto; padding: 1.5rem 1rem 4rem; }
h1 { font-size: 1.6rem; line-height: 1.2; margin: 0 0 1rem; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2.5rem 0 0.5rem; }
p, figcaption { max-width: 46rem; }
figcaption { color: var(--quiet); font-size: 0.85rem; margin-top: 0.3rem; }
figure { margin: 1.5rem 0; }
img { max-width: 100%; height: auto; background: #ffffff; border-radius: 4px; }
@media screen and (prefers-color-scheme: dark) { /* light turns dark, colours stay, and the ground is that of the page */
  img { filter: invert(0.93) hue-rotate(180deg) brightness(1.15); mix-blend-mode: lighten; }
}
@media screen and (max-width: 600px) { figure:has(> img) { overflow-x: auto; } img { max-width: none; width: 34rem; } }
a { color: var(--accent); }
code { font: 0.9em ui-monospace, monospace; overflow-wrap: anywhere; }
.wide { overflow-x: auto; margin: 1rem 0; background:
  linear-gradient(to right, var(--paper) 40%, transparent) left 0 top -1px / 32px calc(100% + 2px) no-repeat local,
  linear-gradient(to left, var(--paper) 40%, transparent) right 0 top -1px / 32px calc(100% + 2px) no-repeat local,
  linear-gradient(to right, var(--more), transparent) left / 14px 100% no-repeat scroll,
  linear-gradient(to left, var(--more), transparent) right / 14px 100% no-repeat scroll; } /* a shadow where there is more */
table { border-collapse: collapse; font-size: 0.85rem; font-variant-numeric: tabular-nums; }
th, td { padding: 0.3rem 0.9rem 0.3rem 0; text-align: left; border-bottom: 1px solid var(--line); white-space: nowrap; }
thead th { color: var(--quiet); font-weight: 500; }
tbody th { font-weight: 500; }
th button { font: inherit; color: inherit; background: none; border: 0; padding: 0; margin: 0; text-align: inherit; cursor: pointer; }
th button::after { content: " \\21c5"; opacity: 0.45; }
th[aria-sort=ascending] button::after { content: " \\2191"; opacity: 1; }
th[aria-sort=descending] button::after { content: " \\2193"; opacity: 1; }
table.sortable tbody th { position: sticky; left: 0; background: var(--paper); }
tr.over th { border-bottom: 0; padding-bottom: 0; }
th.number, td.number { text-align: right; }
th.long { white-space: normal; min-width: 10rem; vertical-align: bottom; }
@media print {
  :root { --ink: #000000; --quiet: #444444; --line: #bbbbbb; --paper: #ffffff; }
  main { max-width: none; padding: 0; }
  table { font-size: 0.7rem; }
  figure, tr { break-inside: avoid; }
  h2 { break-after: avoid; }
}
""".strip()

"""Page: what an experiment found, for people: text, tables and pictures in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path


@dataclass
class Page:
    """Paragraphs from top to bottom.

    Attributes:
        title: of the page.
        parts: paragraphs, tables and pictures.
        pictures: files that were drawn.
    """

    title: str
    parts: list[str] = field(default_factory=list)
    pictures: list[Path] = field(default_factory=list)

    def say(self, text: str) -> None:
        """A paragraph."""
        self.parts.append(text)

    def head(self, text: str) -> None:
        """A heading below the title."""
        self.parts.append(f"## {text}")

    def table(self, heads: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
        """A table; numbers as they are written."""
        lines = [f"| {' | '.join(heads)} |", f"|{'---|' * len(heads)}"]
        self.parts.append("\n".join([*lines, *(f"| {' | '.join(map(str, row))} |" for row in rows)]))

    def picture(self, path: Path, caption: str) -> None:
        """A picture that lies beside the page."""
        self.pictures.append(path)
        self.parts.append(f"![{caption}]({path.name})")

    @property
    def markdown(self) -> str:
        """The whole."""
        return "\n\n".join([f"# {self.title}", *self.parts]) + "\n"


def percent(share: float) -> str:
    """A share as whole per cent."""
    return f"{100 * share:.0f}"

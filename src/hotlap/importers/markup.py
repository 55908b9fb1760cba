"""Markup: elements of an XML file of another program; a fault names file and path of the element."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element

from hotlap.core.errors import InputError
from hotlap.files.content import Content


@dataclass(frozen=True)
class Markup:
    """An element of an XML file, with the place where it stands.

    Attributes:
        file: what messages call the file.
        element: with its attributes and children.
        key: tags from the top of the file, dotted; named elements by their names.
    """

    file: str
    element: Element = field(repr=False)
    key: str = ""

    @property
    def tag(self) -> str:
        """What kind of element it is."""
        return self.element.tag

    @property
    def name(self) -> str:
        """Its attribute name, "" where it has none."""
        return self.element.get("name", "")

    def fault(self, reason: str) -> InputError:
        """The error that says what is wrong here."""
        return InputError(self.file, self.key, reason)

    def all(self, tag: str) -> Iterator[Markup]:
        """The children of a kind."""
        return (self._below(child) for child in self.element if child.tag == tag)

    def first(self, tag: str) -> Markup | None:
        """The first child of a kind, if there is one."""
        return next(self.all(tag), None)

    def one(self, tag: str) -> Markup:
        """The first child of a kind.

        Raises:
            InputError: there is none.
        """
        found = self.first(tag)
        if found is None:
            raise InputError(self.file, f"{self.key}.{tag}" if self.key else tag, "is missing")
        return found

    def within(self, tag: str) -> Iterator[Markup]:
        """All elements of a kind at any depth."""
        return (self._below(child) for child in self.element.iter(tag))

    @property
    def content(self) -> Content:
        """Its text; numbers with blanks between them are a list."""
        words = (self.element.text or "").split()
        return Content(self.file, words[0] if len(words) == 1 else list(words), self.key)

    def number(self, tag: str) -> float:
        """The number in a child.

        Raises:
            InputError: there is none.
        """
        return self.one(tag).content.number()

    @property
    def attributes(self) -> Content:
        """Its attributes, as a table."""
        return Content(self.file, dict(self.element.attrib), self.key)

    def _below(self, child: Element) -> Markup:
        step = f"{child.tag}[{child.get('name')}]" if child.get("name") else str(child.tag)
        return Markup(self.file, child, f"{self.key}.{step}" if self.key else step)

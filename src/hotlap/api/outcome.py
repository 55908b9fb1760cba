"""Outcome: what the results of all calls have in common: short forms to look at, and tables for others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from hotlap.core.shown import LONGEST, Framed, Listed, Shown, html_table

VALUE = 200  # characters of a value in a short form


class Outcome(Framed):
    """A result that a notebook shows as a table, and that others read as a table of their own."""

    def __post_init__(self) -> None:
        """Give lists of results short forms and data frames of their own."""
        for field in fields(self) if is_dataclass(self) else ():
            value = getattr(self, field.name)
            if isinstance(value, tuple) and value and all(isinstance(one, Shown) for one in value):
                object.__setattr__(self, field.name, Listed(value))

    def facts(self) -> Mapping[str, str]:
        """What is most worth knowing, by name; the first is the title, empty ones are not shown."""
        raise NotImplementedError

    def rows(self) -> list[dict[str, Any]]:
        """The table of this result, plain values by column."""
        raise NotImplementedError

    def records(self) -> list[dict[str, Any]]:
        """The same as `rows`."""
        return self.rows()

    def to_dict(self) -> dict[str, Any]:
        """The document that the command line prints with `--json`, as plain values."""
        raise NotImplementedError

    def __repr__(self) -> str:
        title, *others = [_short(value) for value in self.facts().values() if value]
        text = f"<{type(self).__name__} {title}{': ' if others else ''}{'; '.join(others)}>"
        return text if len(text) <= LONGEST else f"{text[: LONGEST - 5]} ...>"

    def _repr_html_(self) -> str:
        (_, title), *others = [(name, value) for name, value in self.facts().items() if value]
        return html_table(title, others)


def _short(text: str) -> str:
    return text if len(text) <= VALUE else f"{text[: VALUE - 4]} ..."

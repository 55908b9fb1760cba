"""Outcome: what the results of all calls have in common: short forms to look at, and tables for others."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hotlap.core.errors import InputError

if TYPE_CHECKING:
    import pandas as pd  # pyright: ignore[reportMissingImports]

LONGEST = 200  # characters of a value in a short form


class Outcome:
    """A result that a notebook shows as a table, and that others read as a table of their own."""

    def facts(self) -> Mapping[str, str]:
        """What is most worth knowing, by name; the first is the title, empty ones are not shown."""
        raise NotImplementedError

    def rows(self) -> list[dict[str, Any]]:
        """The table of this result, plain values by column."""
        raise NotImplementedError

    def to_dict(self) -> dict[str, Any]:
        """The document that the command line prints with `--json`, as plain values."""
        raise NotImplementedError

    def to_frame(self) -> pd.DataFrame:
        """The table of this result as a pandas data frame.

        Raises:
            InputError: pandas is not installed.
        """
        try:
            import pandas as pd  # noqa: PLC0415  # pyright: ignore[reportMissingImports]  not needed for anything else, and slow to load
        except ImportError:
            raise InputError("", "to_frame", "needs pandas: pip install pandas; rows() gives the same as plain values") from None
        return pd.DataFrame(self.rows())

    def __repr__(self) -> str:
        title, *others = [_short(value) for value in self.facts().values() if value]
        text = f"<{type(self).__name__} {title}{': ' if others else ''}{'; '.join(others)}>"
        return text if len(text) < 2 * LONGEST else f"{text[: 2 * LONGEST - 5]} ...>"

    def _repr_html_(self) -> str:
        (_, title), *others = [(name, value) for name, value in self.facts().items() if value]
        rows = "".join(f"<tr><th>{escape(name)}</th><td>{_linked(value)}</td></tr>" for name, value in others)
        return f"<table><caption>{escape(title)}</caption>{rows}</table>"


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 4]} ..."


def _linked(value: str) -> str:
    """A page is a link to it."""
    shown = escape(value)
    return f'<a href="{escape(Path(value).as_posix(), quote=True)}">{shown}</a>' if value.endswith(".html") else shown

"""Number table: columns of numbers that come row by row as text, kept in eight bytes each."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence

import numpy as np

from hotlap.core.records import Floats


class NumberTable:
    """Gathers rows.

    Args:
        places: of the columns that are kept, in a row, by their names.
        words: whether words count as NaN; else they are no numbers.
    """

    def __init__(self, places: Mapping[str, int], *, words: bool = False) -> None:
        self._places, self._words, self._numbers = dict(places), words, array("d")
        self._taken = list(self._places.values())

    def __len__(self) -> int:
        """How many rows."""
        return len(self._numbers) // max(len(self._taken), 1)

    def add(self, cells: Sequence[str]) -> None:
        """Take up a row; an empty cell is NaN.

        Raises:
            ValueError: a cell is no number.
            IndexError: the row is too short.
        """
        row = [cells[place] for place in self._taken]
        try:
            numbers = list(map(float, row))
        except ValueError:
            numbers = [_number(cell, self._words) for cell in row]
        self._numbers.extend(numbers)

    def wrong(self, cells: Sequence[str]) -> tuple[str, str]:
        """Name and text of the first cell of a row that is no number."""
        return next((name, cells[place]) for name, place in self._places.items() if cells[place].strip() and not is_number(cells[place]))

    def columns(self) -> dict[str, Floats]:
        """Columns by name, shape (rows,) each."""
        table = np.array(self._numbers).reshape(-1, max(len(self._taken), 1))
        return {name: np.ascontiguousarray(table[:, k]) for k, name in enumerate(self._places)}


def is_number(text: str) -> bool:
    """Whether a cell is one."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def _number(text: str, words: bool) -> float:
    if not text.strip() or (words and not is_number(text)):
        return np.nan
    return float(text)

"""Content: what stands in a file of another program, read key by key; a fault names file and key."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from hotlap.core.errors import InputError
from hotlap.files.error_messages import show

LARGEST = 1e9  # beyond this a number is a mistake


@dataclass(frozen=True)
class Content:
    """A value of a file, with the place where it stands.

    Attributes:
        file: what messages call the file.
        value: a table, a list, a number or a text.
        key: dotted, from the top of the file; "" for the whole of it.
    """

    file: str
    value: Any = field(repr=False)
    key: str = ""

    def __contains__(self, name: str) -> bool:
        return isinstance(self.value, Mapping) and name in self.value and self.value[name] is not None

    def __getitem__(self, name: str) -> Content:
        """A key of a table.

        Raises:
            InputError: it is missing, or this is no table.
        """
        table, key = self.table(), f"{self.key}.{name}" if self.key else name
        if table.get(name) is None:
            raise InputError(self.file, key, "is missing")
        return Content(self.file, table[name], key)

    def maybe(self, name: str) -> Content | None:
        """A key of a table, None where it is missing."""
        present = name in self
        return self[name] if present else None

    def fault(self, reason: str) -> InputError:
        """The error that says what is wrong here."""
        return InputError(self.file, self.key, reason)

    def has(self, *names: str) -> bool:
        """Whether this is a table with all these keys."""
        return all(name in self for name in names)

    def table(self) -> Mapping[str, Any]:
        """The table that stands here.

        Raises:
            InputError: it is none.
        """
        if not isinstance(self.value, Mapping):
            raise self.fault(f"must be a table, not {show(self.value)}")
        return self.value

    def items(self) -> Iterator[Content]:
        """The entries of a list, or those of a table.

        Raises:
            InputError: it is neither.
        """
        if isinstance(self.value, list):
            yield from (Content(self.file, value, f"{self.key}[{i}]") for i, value in enumerate(self.value))
        else:
            yield from (self[name] for name in self.table() if self.table()[name] is not None)

    def entries(self) -> list[Content]:
        """The entries of a list.

        Raises:
            InputError: it is none, or it is empty.
        """
        if not isinstance(self.value, list) or not self.value:
            raise self.fault(f"must be a list with at least one entry, not {show(self.value)}")
        return list(self.items())

    def text(self) -> str:
        """A text.

        Raises:
            InputError: it is none.
        """
        if not isinstance(self.value, str):
            raise self.fault(f"must be text, not {show(self.value)}")
        return self.value

    def number(self) -> float:
        """A finite number; YAML reads 1e-3, without a point, as text.

        Raises:
            InputError: it is none.
        """
        try:
            value = math.nan if isinstance(self.value, bool | list | Mapping) else float(self.value)
        except (TypeError, ValueError, OverflowError):
            value = math.nan
        if not abs(value) <= LARGEST:
            raise self.fault(f"must be a finite number, not {show(self.value)}")
        return value

    def positive(self) -> float:
        """A number above 0.

        Raises:
            InputError: it is none.
        """
        if self.number() <= 0:
            raise self.fault(f"must be greater than 0, not {show(self.value)}")
        return self.number()

    def vector(self, length: int = 3) -> list[float]:
        """A list of numbers.

        Raises:
            InputError: it is none, or it has another length.
        """
        if not isinstance(self.value, list) or len(self.value) != length:
            raise self.fault(f"must be a list of {length} numbers, not {show(self.value)}")
        return [entry.number() for entry in self.items()]

    def matrix(self, rows: int, columns: int) -> list[list[float]]:
        """A list of rows of numbers.

        Raises:
            InputError: it is none, or it has another shape.
        """
        found = self.entries()
        if len(found) != rows:
            raise self.fault(f"must have {rows} rows, not {len(found)}")
        return [row.vector(columns) for row in found]

    def diagonal(self) -> list[float]:
        """Three numbers, or the diagonal of a matrix of three rows.

        Raises:
            InputError: it is neither.
        """
        if isinstance(self.value, list) and self.value and isinstance(self.value[0], list):
            return [row[i] for i, row in enumerate(self.matrix(3, 3))]
        return self.vector()

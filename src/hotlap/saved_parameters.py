"""SavedParameters: tuned parameters as they are kept in `parameters.toml` and handed to others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from hotlap.errors import InputError
from hotlap.faults import check, show, unknown_key
from hotlap.schema import Described
from hotlap.segmentation import SegmentClass, Segments

Remark = str | int | float | bool

OWN = ("class", "start", "end")  # keys of a segment that are no parameters
LARGEST = 1e300  # beyond this a number is a slip of the pen


@dataclass(frozen=True)
class SavedParameters:
    """Parameters of one controller for every segment of one race.

    Attributes:
        race: name of the race that they were tuned for.
        names: K names.
        segments: what the rows of `values` belong to.
        values: shape (S, K), in the units of the space.
        provenance: what is worth knowing about their making: versions, seed, validated rate.
    """

    race: str
    names: tuple[str, ...]
    segments: Segments
    values: NDArray[np.float64]
    provenance: Mapping[str, Remark] = field(default_factory=dict)

    def to_table(self) -> dict[str, Any]:
        """The content of the file."""
        rows = [
            {"class": str(name), "start": float(start), "end": float(end)} | dict(zip(self.names, map(float, row), strict=True))
            for name, start, end, row in zip(self.segments.classes, self.segments.starts, self.segments.ends, self.values, strict=True)
        ]
        return {"race": self.race, "names": list(self.names), "provenance": dict(self.provenance), "segment": rows}

    @classmethod
    def from_table(cls, table: Mapping[str, Any], source: str) -> SavedParameters:
        """Read the content of a file.

        Args:
            table: as `to_table` made it, or as a person wrote it.
            source: the file, for messages.

        Raises:
            InputError: with the file, the key and the reason.
        """
        content = check(_Content, table, source)
        names = content.names
        if len({*OWN, *names}) < len(OWN) + len(names):
            raise InputError(source, "names", f"must differ from each other and from {', '.join(OWN)}")
        rows = [_row(row, names, f"segment[{i}]", source) for i, row in enumerate(content.segment)]
        segments = _segments([SegmentClass(row["class"]) for row in content.segment], rows, source)
        return cls(content.race, names, segments, np.array([row[2:] for row in rows]), content.provenance)


class _Content(Described):
    """The whole file.

    Attributes:
        race: name of the race that they were tuned for.
        names: names of the parameters.
        provenance: remarks on their making.
        segment: one table for each segment: class, start, end and a value for each name.
    """

    race: str
    names: tuple[str, ...] = Field(min_length=1)
    provenance: dict[str, Any] = Field(default_factory=dict)
    segment: tuple[dict[str, Any], ...] = Field(min_length=1)


def _row(table: Mapping[str, Any], names: tuple[str, ...], key: str, source: str) -> list[float]:
    """Start, end and values of one segment."""
    wanted = (*OWN, *names)
    for name in table:
        if name not in wanted:
            raise InputError(source, f"{key}.{name}", unknown_key(name, wanted))
    for name in wanted:
        if name not in table:
            raise InputError(source, f"{key}.{name}", "is missing")
    if table["class"] not in list(SegmentClass):
        raise InputError(source, f"{key}.class", f"must be {', '.join(SegmentClass)}, not {show(table['class'])}")
    for name in wanted[1:]:
        value = table[name]
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= LARGEST:
            raise InputError(source, f"{key}.{name}", f"must be a finite number, not {show(value)}")
    return [float(table[name]) for name in wanted[1:]]


def _segments(classes: list[SegmentClass], rows: list[list[float]], source: str) -> Segments:
    """The segments, which must follow each other without a gap from 0."""
    expected = 0.0
    for i, (start, end, *_) in enumerate(rows):
        if start != expected:
            raise InputError(source, f"segment[{i}].start", f"must be {expected!r}, where the one before ends, not {start!r}")
        if end <= start:
            raise InputError(source, f"segment[{i}].end", "must be later than its start")
        expected = end
    return Segments(np.array([row[0] for row in rows]), tuple(classes), expected)

"""Parameters file: tuned parameters as they are saved in `parameters.toml`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from hotlap.core.errors import InputError
from hotlap.core.shown import Shown
from hotlap.files.error_messages import check, show, unknown_key
from hotlap.race.schema import Described
from hotlap.reference.segmentation import Piece, SegmentClass, Segments

Remark = str | int | float | bool

OWN = ("class", "start", "end")  # keys of a segment that are no parameters
CHOSEN_SHARE = "thrust_share"  # in the provenance: of the thrust, in a plan that was chosen
LARGEST = 1e300  # beyond this a number is a slip of the pen


@dataclass(frozen=True, repr=False)
class SavedParameters(Shown):
    """Parameters of one controller for every segment of one race.

    Attributes:
        race: name of the race that they were tuned for.
        names: K names.
        segments: what the rows of `values` belong to.
        values: shape (S, K), in the units of the space.
        provenance: how they were found: versions, seed, success rate in the validation.
        flown_with: remarks on the controller that flew them: what no parameter says. Nothing that reads the file acts on them.
    """

    race: str
    names: tuple[str, ...]
    segments: Segments
    values: NDArray[np.float64]
    provenance: Mapping[str, Remark] = field(default_factory=dict)
    flown_with: Mapping[str, Remark] = field(default_factory=dict)

    def to_table(self) -> dict[str, Any]:
        """The content of the file."""
        pieces = [[piece for piece in self.segments.pieces if piece.segment == i] for i in range(len(self.segments))]
        rows = [_times(own) | dict(zip(self.names, map(float, row), strict=True)) for own, row in zip(pieces, self.values, strict=True)]
        head = {"race": self.race, "names": list(self.names), "provenance": dict(self.provenance)}
        return {**head, **({"flown_with": dict(self.flown_with)} if self.flown_with else {}), "segment": rows}

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
        values = [_row(row, names, f"segment[{i}]", source) for i, row in enumerate(content.segment)]
        pieces = [piece for i, row in enumerate(content.segment) for piece in _pieces(row, i, source)]
        return cls(content.race, names, _segments(pieces, source), np.array(values), content.provenance, content.flown_with)


class _Content(Described):
    """The whole file.

    Attributes:
        race: name of the race that they were tuned for.
        names: names of the parameters.
        provenance: remarks on their making.
        flown_with: remarks on the controller that flew them.
        segment: one table for each segment: class, start, end and a value for each name. A segment of several pieces has lists of
            starts and ends.
    """

    race: str
    names: tuple[str, ...] = Field(min_length=1)
    provenance: dict[str, Any] = Field(default_factory=dict)
    flown_with: dict[str, Any] = Field(default_factory=dict)
    segment: tuple[dict[str, Any], ...] = Field(min_length=1)


def _row(table: Mapping[str, Any], names: tuple[str, ...], key: str, source: str) -> list[float]:
    """Values of one segment."""
    wanted = (*OWN, *names)
    for name in table:
        if name not in wanted:
            raise InputError(source, f"{key}.{name}", unknown_key(name, wanted))
    for name in wanted:
        if name not in table:
            raise InputError(source, f"{key}.{name}", "is missing")
    if table["class"] not in list(SegmentClass):
        raise InputError(source, f"{key}.class", f"must be {', '.join(SegmentClass)}, not {show(table['class'])}")
    return [_number(table[name], f"{key}.{name}", source) for name in names]


def _number(value: Any, key: str, source: str) -> float:
    """A finite number."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= LARGEST:
        raise InputError(source, key, f"must be a finite number, not {show(value)}")
    return float(value)


def _times(pieces: Sequence[Piece]) -> dict[str, Any]:
    """Class, start and end of one segment; lists where it has several pieces."""
    starts, ends = [piece.start for piece in pieces], [piece.end for piece in pieces]
    one = len(pieces) == 1
    return {"class": str(pieces[0].kind), "start": starts[0] if one else starts, "end": ends[0] if one else ends}


def _pieces(table: Mapping[str, Any], segment: int, source: str) -> list[Piece]:
    """The inverse of `_times`."""
    key = f"segment[{segment}]"
    starts, ends = ([*value] if isinstance(value := table[name], list | tuple) else [value] for name in ("start", "end"))
    if not len(starts) == len(ends) > 0:
        raise InputError(source, f"{key}.end", f"must be as many as there are starts, {len(starts)}, and at least one; not {len(ends)}")
    numbers = (
        (_number(start, f"{key}.start", source), _number(end, f"{key}.end", source)) for start, end in zip(starts, ends, strict=True)
    )
    return [Piece(segment, SegmentClass(table["class"]), start, end) for start, end in numbers]


def _segments(pieces: Sequence[Piece], source: str) -> Segments:
    """The segments, whose pieces must follow each other without a gap from 0."""
    several = max(piece.segment for piece in pieces) + 1 < len(pieces)
    ordered, expected = sorted(pieces, key=lambda piece: piece.start) if several else pieces, 0.0
    for piece in ordered:
        if piece.start != expected:
            key = f"segment[{piece.segment}].start"
            raise InputError(source, key, f"must be {expected!r}, where the one before ends, not {piece.start!r}")
        if piece.end <= piece.start:
            raise InputError(source, f"segment[{piece.segment}].end", "must be later than its start")
        expected = piece.end
    starts, classes = np.array([piece.start for piece in ordered]), tuple(piece.kind for piece in ordered)
    return Segments(starts, classes, expected, tuple(piece.segment for piece in ordered) if several else ())

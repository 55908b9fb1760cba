"""Map: a reference drawn with text characters for a terminal, from above and from the side; paths consist of braille dots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from hotlap.race.track import Track
from hotlap.reference.reference import Reference
from hotlap.reference.segmentation import SegmentClass, Segments
from hotlap.report.canvas import ANSI, Canvas, dense, paint
from hotlap.report.labels import group, number
from hotlap.report.map_marks import GATE, START, draw_structures, legend
from hotlap.report.projection import View, box_of, views_of, widen
from hotlap.report.structures import Structures, structures_of

Floats = NDArray[np.float64]

LEAST_EXTENT = 1.0  # m
LEAST_COLUMNS = 34  # for a title
GUTTER = 4  # columns between views side by side
UNSIZED = 1e-3  # of the track's longest extent: radius of an opening without a size, which is drawn as small as any


@dataclass(frozen=True)
class _Arrangement:
    """How the views are arranged.

    Attributes:
        views: from above, and from the side.
        scale: dots per metre.
        columns: characters of each view.
        rows: characters of the view from above, and of that from the side.
        beside: whether the second view is to the right of the first, else below it.
    """

    views: tuple[View, View]
    scale: float
    columns: int
    rows: tuple[int, int]
    beside: bool

    def dots(self, points: Floats, view: View, rows: int) -> Floats:
        """World positions in dots from the upper left corner of a view, shape (n, 2)."""
        span = np.array([2 * self.columns, 4 * rows])
        places = self.places(view.project(points), view, rows)
        return np.clip(places.round(6), 0, span - 1)  # a flat track lies halfway between dots: rounding errors must not choose one

    def places(self, points: Floats, view: View, rows: int) -> Floats:
        """Projected positions, shape (n, 2) [m], in dots from the upper left corner, also outside of the view."""
        return view.place_from_middle(points, self.scale) * [1.0, -1.0] + (np.array([2 * self.columns, 4 * rows]) - 1) / 2


def draw_map(
    reference: Reference,
    gate_positions: Floats,
    segments: Segments,
    *,
    structures: Structures | None = None,
    width: int = 78,
    height: int = 22,
    colour: bool = False,
) -> str:
    """A reference from above and from the side, to the same scale, with its gates numbered and its segments listed.

    Args:
        reference: its planned rows are drawn.
        gate_positions: shape (M, 3) [m] (world).
        segments: of the reference; coloured if asked for.
        structures: what stands on the track; None: gates are points.
        width: most columns, at least 30.
        height: most rows of the views with their titles, at least 8.
        colour: by ANSI codes, for terminals that know them.
    """
    width, path = max(width, 30), reference.position[: reference.planned_rows]
    kinds = segments.at(reference.times[: len(path)])
    lines = _draw_views(path, kinds, gate_positions, structures, segments, width, height, colour=colour)
    lines += ["", *_list_segments(segments, width, colour=colour), *legend(structures, width)]
    return "\n".join(line.rstrip() for line in lines)


def draw_track(track: Track, *, width: int = 78, height: int = 22) -> str:
    """A track from above and from the side, to the same scale: straight lines from the start through the gates, numbered, to the end."""
    path = np.vstack([track.start, track.waypoints])
    one, width = Segments(np.zeros(1), (SegmentClass.FLAT,), 1.0), max(width, 30)
    structures = structures_of(track, UNSIZED * float(np.ptp(path, axis=0).max()))
    kinds = np.zeros(len(path), dtype=np.int64)
    lines = _draw_views(path, kinds, track.gate_positions, structures, one, width, height, colour=False)
    return "\n".join(line.rstrip() for line in [*lines, *legend(structures, width)])


def _draw_views(
    path: Floats,
    kinds: NDArray[np.int64],
    gate_positions: Floats,
    structures: Structures | None,
    segments: Segments,
    width: int,
    height: int,
    *,
    colour: bool,
) -> list[str]:
    """Both views, with their titles; segments of shape (rows,) draw the path."""
    low, high = box_of(np.vstack([path, gate_positions]))
    if structures is not None:
        low, high = structures.surround(low, high)
    numbers = range(1, len(gate_positions) + 1) if structures is None else [gate.number for gate in structures.gates]
    layout = _arrange(low, high, width, max(height, 8))
    views = []
    for view, rows in zip(layout.views, layout.rows, strict=True):
        canvas = Canvas.blank(layout.columns, rows)
        marks = np.full(len(gate_positions), GATE)
        if structures is not None and not structures.plain:
            marks = draw_structures(canvas, structures, view, partial(layout.places, view=view, rows=rows), 1 / layout.scale)
        canvas.draw(*dense(layout.dots(path, view, rows), kinds))
        _write_gates(canvas, layout.dots(path[:1], view, rows)[0], layout.dots(gate_positions, view, rows), marks, numbers)
        views.append([view.title(high - low)[: layout.columns], *canvas.lines(segments, colour=colour)])
    return _beside(views[0], views[1], layout.columns) if layout.beside else [*views[0], *views[1]]


def _arrange(low: Floats, high: Floats, width: int, height: int) -> _Arrangement:
    """The views of a box, each shape (3,) [m], below or beside each other, whichever makes them larger."""
    views = views_of(*widen(low, high, LEAST_EXTENT))
    (wide, deep), (_, high_up) = (view.extent for view in views)
    shares = ((4 * rows - 1, 4 * (height - 2 - rows) - 1) for rows in range(2, height - 3))  # dots for either view
    stacked = min((2 * width - 1) / wide, max(min(upper / deep, lower / high_up) for upper, lower in shares))
    aside = min((width - GUTTER - 1) / wide, (4 * (height - 1) - 1) / max(deep, high_up))
    aside = aside if width >= 2 * LEAST_COLUMNS + GUTTER else 0.0
    beside, scale = aside > stacked, float(max(aside, stacked))
    most = (width - GUTTER) // 2 if beside else width
    columns = min(max(int(np.ceil((wide * scale + 1) / 2 - 1e-6)), min(LEAST_COLUMNS, most)), most)
    above, side = (max(2, int(np.ceil((length * scale + 1) / 4 - 1e-6))) for length in (deep, high_up))
    return _Arrangement(views, scale, columns, (above, side), beside)


def _beside(left: list[str], right: list[str], columns: int) -> list[str]:
    """Two views side by side."""
    count = max(len(left), len(right))
    left, right = ([*lines, *[""] * (count - len(lines))] for lines in (left, right))
    widths = [columns - len(ANSI.sub("", line)) + GUTTER for line in left]
    return [a + " " * gap + b for a, gap, b in zip(left, widths, right, strict=True)]


def _write_gates(canvas: Canvas, start: Floats, gates: Floats, marks: NDArray[np.str_], numbers: Sequence[int]) -> None:
    """Mark the start and the gates, with the numbers of the gates where there is room; gates in one cell that differ get a plain mark."""
    cells = np.floor(gates / (2, 4))
    groups = group(cells, 0.5)
    for cell, members in groups:
        mark = str(marks[members[0]])
        canvas.write(int(cell[0]), int(cell[1]), mark if (marks[members] == mark).all() else GATE)
    canvas.write(int(start[0] // 2), int(start[1] // 4), START)
    for cell, members in groups:
        text, (column, row) = number((numbers[member] for member in members), most=2), cell.astype(int).tolist()
        left, right, middle = column - len(text), column + 1, column - len(text) // 2
        places = [(right, row), (middle, row - 1), (middle, row + 1), (left, row)]
        places += [(side, row + step) for step in (-1, 1) for side in (right, left)]
        cost, best = min((canvas.hidden(*place, text, (column, row)), k) for k, place in enumerate(places))
        if np.isfinite(cost):
            canvas.write(*places[best], text)


def _list_segments(segments: Segments, width: int, *, colour: bool) -> list[str]:
    """A list of the pieces of all segments: number, class, start and end; as many in a line as fit."""
    lines, length = [""], 0
    for piece in segments.pieces:
        text = f"{piece.segment + 1} {piece.kind.value} {piece.start:.1f}-{piece.end:.1f} s"
        if length and length + 3 + len(text) > width:
            lines, length = [*lines, ""], 0
        lines[-1] += ("   " if length else "") + paint(text, piece.kind if colour else None)
        length += len(text) + (3 if length else 0)
    return lines

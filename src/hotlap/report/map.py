"""Map: a reference drawn with text characters for a terminal, from above and from the side; paths consist of braille dots."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.race.track import Track
from hotlap.reference.reference import Reference
from hotlap.reference.segmentation import SegmentClass, Segments
from hotlap.report.labels import group, number
from hotlap.report.projection import View, box_of, views_of, widen

Floats = NDArray[np.float64]

DOTS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])  # of the Unicode block from U+2800, rows by columns
BRAILLE = 0x2800
CLASS_CODES = {  # ANSI foreground colours
    SegmentClass.FLAT: 36,
    SegmentClass.ASCENT: 32,
    SegmentClass.DESCENT: 33,
    SegmentClass.STEEP: 35,
}
LEAST_EXTENT = 1.0  # m
LEAST_COLUMNS = 34  # for a title
GUTTER = 4  # columns between views side by side
ANSI = re.compile("\x1b\\[[0-9]*m")
START, GATE = "S", "o"


@dataclass(frozen=True)
class _Canvas:
    """A grid of characters to draw on.

    Attributes:
        dots: shape (rows, columns), bits of the braille patterns.
        kinds: shape (rows, columns), index of the segment that was drawn last.
        texts: shape (rows, columns), characters in front of the dots; "" for none.
    """

    dots: NDArray[np.int64]
    kinds: NDArray[np.int64]
    texts: NDArray[np.str_]

    @staticmethod
    def blank(columns: int, rows: int) -> _Canvas:
        """An empty canvas."""
        return _Canvas(np.zeros((rows, columns), np.int64), np.zeros((rows, columns), np.int64), np.full((rows, columns), "", "<U1"))

    def draw(self, points: Floats, kinds: NDArray[np.int64]) -> None:
        """Dots at points, shape (n, 2) in dots from the upper left corner, drawn by segments of shape (n,)."""
        x, y = np.ceil(points - 0.5).astype(int).T  # halves go to the upper left, as the gates of `_write_gates` do
        np.bitwise_or.at(self.dots, (y // 4, x // 2), DOTS[y % 4, x % 2])
        self.kinds[y // 4, x // 2] = kinds

    def write(self, column: int, row: int, text: str) -> None:
        """Write a text over the dots."""
        self.texts[row, column : column + len(text)] = list(text)

    def hidden(self, column: int, row: int, text: str, own: tuple[int, int]) -> float:
        """How many cells of the path a text would cover; infinite where it does not fit or would touch another text.

        Args:
            column: of its first character.
            row: of the text.
            text: what it says.
            own: column and row of the mark that it belongs to, and may touch.
        """
        rows, columns = self.dots.shape
        if not (0 <= row < rows and column >= 0 and column + len(text) <= columns):
            return np.inf
        near = self.texts[row, max(column - 1, 0) : column + len(text) + 1]
        if (near != "").sum() > (row == own[1]):
            return np.inf
        return float((self.dots[row, column : column + len(text)] > 0).sum())

    def lines(self, segments: Segments, *, colour: bool) -> list[str]:
        """The rows as text, all of the same width."""
        lines, classes = [], segments.segment_classes
        for dots, kinds, texts in zip(self.dots, self.kinds, self.texts, strict=True):
            line = ""
            for dot, kind, text in zip(dots.tolist(), kinds.tolist(), texts.tolist(), strict=True):
                if text or not dot:
                    line += text or " "
                else:
                    line += _paint(chr(BRAILLE + dot), classes[kind] if colour else None)
            lines.append(line)
        return lines


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
        places = view.place_from_middle(view.project(points), self.scale) * [1.0, -1.0] + (span - 1) / 2
        return np.clip(places.round(6), 0, span - 1)  # a flat track lies halfway between dots: rounding errors must not choose one


def draw_map(
    reference: Reference, gate_positions: Floats, segments: Segments, *, width: int = 78, height: int = 22, colour: bool = False
) -> str:
    """A reference from above and from the side, to the same scale, with its gates numbered and its segments listed.

    Args:
        reference: its planned rows are drawn.
        gate_positions: shape (M, 3) [m] (world).
        segments: of the reference; coloured if asked for.
        width: most columns, at least 30.
        height: most rows of the views with their titles, at least 8.
        colour: by ANSI codes, for terminals that know them.
    """
    width, path = max(width, 30), reference.position[: reference.planned_rows]
    kinds = segments.at(reference.times[: len(path)])
    lines = _draw_views(path, kinds, gate_positions, segments, width, height, colour=colour)
    lines += ["", *_list_segments(segments, width, colour=colour)]
    return "\n".join(line.rstrip() for line in lines)


def draw_track(track: Track, *, width: int = 78, height: int = 22) -> str:
    """A track from above and from the side, to the same scale: straight lines from the start through the gates, numbered, to the end."""
    path = np.vstack([track.start, track.waypoints])
    one = Segments(np.zeros(1), (SegmentClass.FLAT,), 1.0)
    lines = _draw_views(path, np.zeros(len(path), dtype=np.int64), track.gate_positions, one, max(width, 30), height, colour=False)
    return "\n".join(line.rstrip() for line in lines)


def _draw_views(
    path: Floats, kinds: NDArray[np.int64], gate_positions: Floats, segments: Segments, width: int, height: int, *, colour: bool
) -> list[str]:
    """Both views, with their titles; segments of shape (rows,) draw the path."""
    low, high = box_of(np.vstack([path, gate_positions]))
    layout = _arrange(low, high, width, max(height, 8))
    views = []
    for view, rows in zip(layout.views, layout.rows, strict=True):
        canvas = _Canvas.blank(layout.columns, rows)
        canvas.draw(*_dense(layout.dots(path, view, rows), kinds))
        _write_gates(canvas, layout.dots(path[:1], view, rows)[0], layout.dots(gate_positions, view, rows))
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


def _dense(points: Floats, kinds: NDArray[np.int64]) -> tuple[Floats, NDArray[np.int64]]:
    """The path with points added until neighbours are at most one dot apart."""
    if len(points) < 2:
        return points, kinds
    steps = np.maximum(1, np.ceil(np.abs(np.diff(points, axis=0)).max(axis=1))).astype(int)
    places = np.append(np.repeat(np.arange(len(steps)), steps) + np.concatenate([np.arange(n) / n for n in steps]), len(steps))
    dense = np.stack([np.interp(places, np.arange(len(points)), column) for column in points.T], axis=1)
    return dense, kinds[places.astype(int)]


def _write_gates(canvas: _Canvas, start: Floats, gates: Floats) -> None:
    """Mark the start and the gates, with the numbers of the gates where there is room."""
    cells = np.floor(gates / (2, 4))
    groups = group(cells, 0.5)
    for cell, _ in groups:
        canvas.write(int(cell[0]), int(cell[1]), GATE)
    canvas.write(int(start[0] // 2), int(start[1] // 4), START)
    for cell, members in groups:
        text, (column, row) = number(members, most=2), cell.astype(int).tolist()
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
        lines[-1] += ("   " if length else "") + _paint(text, piece.kind if colour else None)
        length += len(text) + (3 if length else 0)
    return lines


def _paint(text: str, kind: SegmentClass | None) -> str:
    """A text in the colour of a class of segments; None: as it is."""
    return text if kind is None else f"\x1b[{CLASS_CODES[kind]}m{text}\x1b[0m"

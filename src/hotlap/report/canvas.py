"""Canvas: a grid of characters to draw on: lines consist of braille dots, texts lie in front of them."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.reference.segmentation import SegmentClass, Segments

Floats = NDArray[np.float64]

DOTS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])  # of the Unicode block from U+2800, rows by columns
BRAILLE = 0x2800
CLASS_CODES = {  # ANSI foreground colours
    SegmentClass.FLAT: 36,
    SegmentClass.ASCENT: 32,
    SegmentClass.DESCENT: 33,
    SegmentClass.STEEP: 35,
}
ANSI = re.compile("\x1b\\[[0-9]*m")
STANDING = -1  # kind of a dot that belongs to no segment


@dataclass(frozen=True)
class Canvas:
    """A grid of characters to draw on.

    Attributes:
        dots: shape (rows, columns), bits of the braille patterns.
        kinds: shape (rows, columns), index of the segment that was drawn last; `STANDING` for what stands on the track.
        texts: shape (rows, columns), characters in front of the dots; "" for none.
    """

    dots: NDArray[np.int64]
    kinds: NDArray[np.int64]
    texts: NDArray[np.str_]

    @property
    def span(self) -> Floats:
        """Dots across and down, shape (2,)."""
        rows, columns = self.dots.shape
        return np.array([2 * columns, 4 * rows])

    @staticmethod
    def blank(columns: int, rows: int) -> Canvas:
        """An empty canvas."""
        return Canvas(np.zeros((rows, columns), np.int64), np.zeros((rows, columns), np.int64), np.full((rows, columns), "", "<U1"))

    def draw(self, points: Floats, kinds: NDArray[np.int64]) -> None:
        """Dots at points, shape (n, 2) in dots from the upper left corner, drawn by segments of shape (n,)."""
        x, y = np.ceil(points - 0.5).astype(int).T  # halves go to the upper left, as the gates of the map do
        np.bitwise_or.at(self.dots, (y // 4, x // 2), DOTS[y % 4, x % 2])
        self.kinds[y // 4, x // 2] = kinds

    def outline(self, points: Floats, every: int = 1) -> None:
        """A line through points, shape (n, 2) in dots, as far as it lies on the canvas.

        Args:
            points: of the line.
            every: 1 for a solid line, more for single dots so far apart.
        """
        there = np.ceil(dense(points, np.zeros(len(points), dtype=np.int64))[0].round(6) - 0.5)
        there = there[((there >= 0) & (there < self.span)).all(axis=1)]
        there = there[np.append(True, (np.diff(there, axis=0) != 0).any(axis=1))[: len(there)]][::every]
        self.draw(there, np.full(len(there), STANDING))

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
                    line += paint(chr(BRAILLE + dot), classes[kind] if colour and kind != STANDING else None)
            lines.append(line)
        return lines


def dense(points: Floats, kinds: NDArray[np.int64]) -> tuple[Floats, NDArray[np.int64]]:
    """The path with points added until neighbours are at most one dot apart."""
    if len(points) < 2:
        return points, kinds
    steps = np.maximum(1, np.ceil(np.abs(np.diff(points, axis=0)).max(axis=1))).astype(int)
    places = np.append(np.repeat(np.arange(len(steps)), steps) + np.concatenate([np.arange(n) / n for n in steps]), len(steps))
    dense = np.stack([np.interp(places, np.arange(len(points)), column) for column in points.T], axis=1)
    return dense, kinds[places.astype(int)]


def paint(text: str, kind: SegmentClass | None) -> str:
    """A text in the colour of a class of segments; None: as it is."""
    return text if kind is None else f"\x1b[{CLASS_CODES[kind]}m{text}\x1b[0m"

"""Map marks: what stands on a track, drawn with text characters: openings with their directions, obstacles, box, floor and ceiling."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hotlap.report.canvas import Canvas
from hotlap.report.projection import View
from hotlap.report.silhouettes import Slab, arrow_in, borders, silhouette
from hotlap.report.structures import GateShape, Structures

Floats = NDArray[np.float64]
Places = Callable[[Floats], Floats]
"""(projected positions, shape (n, 2) [m]) -> their places in dots from the upper left corner."""

START, GATE, POINT, SOLID = "S", "o", "+", "■"
HEADS = "→↗↑↖←↙↓↘"  # from the right, counter-clockwise
BAR = 5.0  # dots from the middle of an opening to its rim, at least
SMALL = 3.0  # dots, of an obstacle that is drawn as a character
ROUND = np.stack([np.cos(np.linspace(0, 2 * np.pi, 33)), np.sin(np.linspace(0, 2 * np.pi, 33))], axis=1)


def draw_structures(canvas: Canvas, structures: Structures, view: View, places: Places, dot: float) -> NDArray[np.str_]:
    """Openings, obstacles and borders as dots; returns the mark of each gate, which shows its direction where it has one.

    Args:
        canvas: of the view.
        structures: what stands on the track.
        view: from above or from the side.
        places: gives the places of projected positions.
        dot: [m] that one is wide.
    """
    for line in borders(structures, view):
        canvas.outline(places(line), every=3)
    for obstacle in structures.obstacles:
        shape = silhouette(obstacle, view)
        outline = places(shape.outline if isinstance(shape, Slab) else shape.centre + shape.radius * ROUND)
        if (np.ptp(outline, axis=0) < SMALL).all():
            _write_mark(canvas, outline.mean(axis=0), SOLID)
        else:
            canvas.outline(outline)
    for gate in structures.distinct:
        grown = gate.larger(BAR * dot)
        for line in grown.lines:
            canvas.outline(places(view.project(line)))
        if gate.plane is None and not gate.bare:
            canvas.outline(places(view.project(gate.centre[None]) + grown.radius * ROUND))
    for point in structures.points:
        _write_mark(canvas, places(view.project(point.centre[None]))[0], _mark(point, view, POINT))
    return np.array([_mark(gate, view, GATE) for gate in structures.gates])


def _mark(gate: GateShape, view: View, otherwise: str) -> str:
    """An arrow head in the direction in which a gate is passed, as it is seen in a view."""
    arrow = arrow_in(gate, view, 1.0)
    if arrow is None:
        return otherwise
    right, up = (arrow[1] - arrow[0]) * view.signs
    return HEADS[round(np.arctan2(up, right) / (np.pi / 4)) % 8]


def _write_mark(canvas: Canvas, place: Floats, mark: str) -> None:
    """A character at a place in dots, if that lies on the canvas."""
    column, row = np.floor(place / (2, 4)).astype(int).tolist()
    if 0 <= row < canvas.dots.shape[0] and 0 <= column < canvas.dots.shape[1]:
        canvas.write(column, row, mark)


def legend(structures: Structures | None, width: int) -> list[str]:
    """What the marks of a map mean, in lines of at most so many columns; [] where all gates are points."""
    if structures is None or structures.plain:
        return []
    gates = structures.gates
    limits = [name for name in ("box", "floor", "ceiling") if getattr(structures, name) is not None]
    known = [
        (True, f"{START} start"),
        (any(gate.normal is None for gate in gates), f"{GATE} gate"),
        (any(gate.normal is not None for gate in gates), f"{HEADS[0]} gate with its direction"),
        (any(gate.plane is not None for gate in gates), "line across: opening"),
        (any(gate.plane is None and not gate.bare for gate in gates), "circle: ball"),
        (bool(structures.points), f"{POINT} point that does not count"),
        (bool(structures.obstacles), f"{SOLID} or outline: obstacle"),
        (bool(limits), f"dotted: {', '.join(limits)}"),
    ]
    lines = [""]
    for text in (text for there, text in known if there):
        joined = f"{lines[-1]}   {text}" if lines[-1] else text
        lines = [*lines[:-1], joined] if len(joined) <= width else [*lines, text]
    return [line[:width] for line in lines]

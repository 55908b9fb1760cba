"""Frames: the pictures of a film, flights drawn beside each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hotlap.core.counts import count
from hotlap.report.film.drone import draw_drone
from hotlap.report.film.flight_frames import FlightFrames
from hotlap.report.projection import Camera, aim, gate_lines, ground_grid, ground_level, picture_box, shadow, standing_lines
from hotlap.report.scene import Scene
from hotlap.report.style import SPEED_MAP, own_settings, place_axes

Floats = NDArray[np.float64]

NIGHT, LIGHT, DIM, FAINT = "#10151c", "#eef2f6", "#8b98a8", "#232d39"
FAILURE, DONE, GATE, PASSED = "#ff6159", "#7ddc8b", "#4a5868", "#eef2f6"
WIDTH, TOP, BOTTOM, EDGE = 4.5, 0.95, 0.5, 0.15  # inches of a panel, and around it
SHORTEST, TALLEST = 2.2, 4.2  # inches of a panel's height
DPI = 100
STANDING = "#3d4a59"  # obstacles and box
LEAST = 0.6  # arms of the drone, of an opening's reach
DRONE = 0.028  # of the width of what is seen: an arm, several times too large, to be seen at all


@dataclass(frozen=True)
class Titles:
    """The texts of a film.

    Attributes:
        title: of the film.
        pace: how fast the film runs, in words.
        labels: above each panel.
    """

    title: str
    pace: str
    labels: tuple[str, ...]


def draw_frames(scene: Scene, flights: Sequence[FlightFrames], titles: Titles, interval: float) -> Iterator[NDArray[np.uint8]]:
    """Every frame as pixels, shape (height, width, 3), height and width even.

    Args:
        scene: scenario and gates.
        flights: beside each other, one panel each.
        titles: the texts of the film.
        interval: [s] of the flight between frames.
    """
    with own_settings():
        film = _Film(scene, flights, titles)
        for k in range(max(map(len, flights))):
            yield film.frame(k, k * interval)


class _Film:
    """The figure of all frames: parts that do not move are drawn once, the others in each frame."""

    def __init__(self, scene: Scene, flights: Sequence[FlightFrames], titles: Titles) -> None:
        camera = aim(scene.path)
        low, high = picture_box(scene, camera)
        extent = high - low
        height = float(np.clip(WIDTH * extent[1] / extent[0], SHORTEST, TALLEST))
        low, high = _fill(low, high, WIDTH / height)
        size = np.array([len(flights) * (WIDTH + EDGE) + EDGE, TOP + height + BOTTOM])
        self._figure = Figure(figsize=tuple(np.round(size * DPI / 2) * 2 / DPI), dpi=DPI, facecolor=NIGHT)
        self._canvas = FigureCanvasAgg(self._figure)
        norm = Normalize(0.0, max(1.0, *(float(flight.speed[: flight.judged + 1].max(initial=0.0)) for flight in flights)))
        places = [EDGE + i * (WIDTH + EDGE) for i in range(len(flights))]
        axes = [_panel(self._figure, place, height, low, high) for place in places]
        self._panels = [
            _Panel(axis, scene, camera, flight, label, norm) for axis, flight, label in zip(axes, flights, titles.labels, strict=True)
        ]
        full_height = self._figure.get_size_inches()[1]
        self._figure.text(EDGE / size[0], 1 - 0.13 / full_height, titles.title, fontsize=13, weight="bold", color=LIGHT, va="top")
        self._clock = self._figure.text(EDGE / size[0], 0.2 / full_height, "", fontsize=9, color=DIM, va="center")
        self._pace = titles.pace
        _colour_bar(self._figure, float(size[0]), norm)
        self._movers: list[Artist] = [self._clock, *(artist for panel in self._panels for artist in panel.movers)]
        for artist in self._movers:
            artist.set_animated(True)
        self._canvas.draw()
        self._still = self._canvas.copy_from_bbox(self._figure.bbox)

    def frame(self, k: int, time: float) -> NDArray[np.uint8]:
        """Draw the k-th frame, at a time of the flight [s]."""
        for panel in self._panels:
            panel.move(k)
        self._clock.set_text(f"{time:5.2f} s{self._pace}")
        self._canvas.restore_region(self._still)
        renderer = self._canvas.get_renderer()
        for artist in self._movers:
            artist.draw(renderer)
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()


class _Panel:
    """The part of the figure with one flight."""

    def __init__(self, axes: Axes, scene: Scene, camera: Camera, flight: FlightFrames, label: str, norm: Normalize) -> None:
        self._camera, self._flight, self._total = camera, flight, len(scene.gates)
        self._ground, self._size = ground_level(scene), DRONE * abs(float(np.subtract(*axes.get_xlim())))
        self._path, self._gates = camera.project(flight.position), _project(camera, gate_lines(scene, LEAST * self._size))
        _draw_still(axes, scene, camera, self._gates)
        above: Any = {"xycoords": "axes fraction", "textcoords": "offset points", "fontsize": 10.5}
        axes.annotate(label, (0, 1), xytext=(0, 22), color=LIGHT, **above)
        self._count = axes.annotate("", (0, 1), xytext=(0, 5), annotation_clip=False, **above)
        colours: Any = {"cmap": SPEED_MAP, "norm": norm, "capstyle": "round"}
        self._trail = _add(axes, LineCollection([], linewidths=2.2, zorder=4, **colours))
        self._lost = _add(axes, LineCollection([], colors=FAILURE, linewidths=1.0, alpha=0.7, zorder=3))
        self._lit = _add(axes, LineCollection([], colors=PASSED, linewidths=1.3, zorder=3.5))
        self._drone = _add(axes, LineCollection([], linewidths=1.4, zorder=6))
        (self._plumb,) = axes.plot([], [], color=DIM, linewidth=0.6, marker=".", markevery=[1], markersize=3, zorder=3)
        (self._cross,) = axes.plot([], [], linestyle="none", marker="x", color=FAILURE, markersize=11, markeredgewidth=2.6, zorder=7)
        self.movers: list[Artist] = [self._plumb, self._lost, self._lit, self._trail, self._drone, self._cross, self._count]

    def move(self, k: int) -> None:
        """Move everything to the k-th frame."""
        flight, k = self._flight, min(k, len(self._flight) - 1)
        good, over = min(k, flight.judged) if flight.failed else k, k >= flight.judged
        self._trail.set_segments(_pairs(self._path[: good + 1]))
        self._trail.set_array(flight.speed[1 : good + 1])
        self._lost.set_segments(_pairs(self._path[good : k + 1]))
        self._lit.set_segments([line for lines in self._gates[: flight.passed[k]] for line in lines])
        position, failed = flight.position[k], flight.failed and over
        drone = draw_drone(position, flight.attitude[k], self._size, flight.rotors)
        self._drone.set_segments([self._camera.project(line) for line in drone])
        self._drone.set_color(FAILURE if failed else LIGHT)
        self._plumb.set_data(*self._camera.project(np.array([position, [*position[:2], self._ground]])).T)
        self._cross.set_data(*(self._path[[min(flight.judged, len(flight) - 1)]].T if failed else ([], [])))
        self._count.set_color(FAILURE if failed else DONE if over else DIM)
        self._count.set_fontweight("bold" if over else "normal")
        mark = "✕ " if failed else "✓ " if over else ""
        self._count.set_text(f"{mark}{flight.ending}" if over else f"{flight.passed[k]} of {count(self._total, 'gate')}")


def _fill(low: Floats, high: Floats, aspect: float) -> tuple[Floats, Floats]:
    """A box, each shape (2,) [m], made wider or higher about its middle, so that its width is `aspect` times its height."""
    middle, extent = (low + high) / 2, high - low
    half = max(extent[0], aspect * extent[1]) / 2 * np.array([1.0, 1 / aspect])
    return middle - half, middle + half


def _panel(figure: Figure, left: float, height: float, low: Floats, high: Floats) -> Axes:
    """Axes to scale, without a frame."""
    axes = place_axes(figure, left, BOTTOM, WIDTH, height)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_axis_off()
    return axes


def _project(camera: Camera, gates: Sequence[Sequence[Floats]]) -> list[list[Floats]]:
    """The lines of each gate in the picture."""
    return [[camera.project(line) for line in lines] for lines in gates]


def _draw_still(axes: Axes, scene: Scene, camera: Camera, gates: list[list[Floats]]) -> None:
    """The ground, the plan with its shadow, what stands on the track, and the gates."""
    axes.add_collection(LineCollection(list(camera.project(ground_grid(scene))), colors=FAINT, linewidths=0.6, zorder=0), autolim=False)
    axes.plot(*camera.project(shadow(scene)).T, color="#1b242f", linewidth=2.0, zorder=1)
    axes.plot(*camera.project(scene.path).T, color="#3b4856", linewidth=0.9, zorder=2)
    _add(axes, LineCollection([camera.project(line) for line in standing_lines(scene)], colors=STANDING, linewidths=0.7, zorder=1.5))
    frames = [camera.project(frame) for shape in scene.structures.distinct for frame in shape.frames]
    _add(axes, LineCollection(frames, colors=GATE, linewidths=2.2, alpha=0.6, zorder=2.4))
    _add(axes, LineCollection([line for lines in gates for line in lines], colors=GATE, linewidths=1.1, zorder=2.5))


def _add(axes: Axes, lines: LineCollection) -> LineCollection:
    """Add lines without a change of the limits."""
    axes.add_collection(lines, autolim=False)
    return lines


def _pairs(points: Floats) -> list[Floats]:
    """Lines from each point to the next."""
    return list(np.stack([points[:-1], points[1:]], axis=1))


def _colour_bar(figure: Figure, width: float, norm: Normalize) -> None:
    """Speeds and their colours, in the lower right corner."""
    axes = place_axes(figure, width - EDGE - 1.75, 0.15, 1.3, 0.09)
    bar = figure.colorbar(ScalarMappable(norm, SPEED_MAP), cax=axes, orientation="horizontal", ticks=[])
    bar.outline.set_visible(False)  # pyright: ignore[reportCallIssue]
    for place, words, side in ((-0.04, "0", "right"), (1.04, f"{norm.vmax:.0f} m/s", "left")):
        axes.text(place, 0.5, words, transform=axes.transAxes, fontsize=9, color=DIM, ha=side, va="center")

"""Style: the common look of all figures. Colours are for data only, lines are thin, labels are beside what they name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import lru_cache, wraps
from typing import Any, ParamSpec

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.textpath import TextPath

from hotlap.reference.segmentation import SegmentClass

P = ParamSpec("P")

INK, QUIET, FAINT = "#222222", "#6b6b6b", "#cfcfcf"
FAILURE = "#c8102e"  # the one red; always together with the shape "x"
BEST, FIRST, AGAIN = "#0072b2", "#8a8a8a", "#e69f00"
CLASS_COLOURS: Mapping[SegmentClass, str] = {  # Okabe and Ito
    SegmentClass.FLAT: "#56b4e9",
    SegmentClass.ASCENT: "#009e73",
    SegmentClass.DESCENT: "#e69f00",
    SegmentClass.STEEP: "#cc79a7",
}
SPEED_MAP = "viridis"
GHOST_DASHES = (0, (4, 1.5))
LINE = 1.3  # points
SMALL, NORMAL, LARGE = 7.0, 8.0, 11.0  # points
MARK_GAP, KEY_GAP = 0.06, 0.2  # inches between marks and meanings
FACE = "white"

_SETTINGS: Any = {
    "font.family": "sans-serif",
    "font.size": NORMAL,
    "text.color": INK,
    "axes.labelcolor": QUIET,
    "axes.edgecolor": FAINT,
    "axes.linewidth": 0.8,
    "axes.labelsize": NORMAL,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
    "xtick.major.size": 3.0,
    "ytick.major.size": 3.0,
    "xtick.minor.size": 0.0,
    "ytick.minor.size": 0.0,
    "grid.color": "#ededed",
    "grid.linewidth": 0.6,
    "lines.linewidth": LINE,
    "figure.facecolor": FACE,
    "savefig.facecolor": FACE,
    "savefig.dpi": "figure",
    "figure.dpi": 160.0,
    "svg.hashsalt": "hotlap",
    "text.usetex": False,
}


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Decorator: the function draws in this style, independent of the user's matplotlib settings, which stay as they are."""

    @wraps(draw)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with own_settings():
            return draw(*args, **kwargs)

    return wrapper


@contextmanager
def own_settings() -> Iterator[None]:
    """Context in which matplotlib has the settings of this style."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)
        yield


def place_axes(figure: Figure, left: float, bottom: float, width: float, height: float, **options: Any) -> Axes:
    """Axes at a place given in inches from the lower left corner."""
    full_width, full_height = figure.get_size_inches()
    return figure.add_axes((left / full_width, bottom / full_height, width / full_width, height / full_height), **options)


@lru_cache(maxsize=1000)
def text_width(text: str, size: float) -> float:
    """Width [inches] of a line of text of a given size [points]."""
    return float(TextPath((0, 0), text, size=size).get_extents().width) / 72 if text.strip() else 0.0


def headline(figure: Figure, left: float, title: str, detail: str = "", key: Sequence[tuple[str, str, str]] = ()) -> None:
    """A title in the upper left corner with two grey lines below: details, and a legend of the marks.

    Args:
        figure: to write on.
        left: [inches] where the text begins.
        title: first line.
        detail: second line.
        key: third line: marks as characters, their colours, and their meanings.
    """
    width, height = figure.get_size_inches()
    figure.text(left / width, 1 - 0.14 / height, title, fontsize=LARGE, va="top", weight="bold")
    if detail:
        figure.text(left / width, 1 - 0.36 / height, detail, fontsize=NORMAL, va="top", color=QUIET)
    for mark, colour, meaning in key:
        figure.text(left / width, 1 - 0.61 / height, mark, fontsize=NORMAL, va="center", color=colour)
        left += text_width(mark, NORMAL) + MARK_GAP
        figure.text(left / width, 1 - 0.61 / height, meaning, fontsize=NORMAL, va="center", color=QUIET)
        left += text_width(meaning, NORMAL) + KEY_GAP


def headline_width(title: str, detail: str, key: Sequence[tuple[str, str, str]]) -> float:
    """Width [inches] of a headline."""
    last = sum(text_width(mark, NORMAL) + MARK_GAP + text_width(meaning, NORMAL) + KEY_GAP for mark, _, meaning in key)
    return max(1.1 * text_width(title, LARGE), text_width(detail, NORMAL), last)

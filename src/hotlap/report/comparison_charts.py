"""Charts of a comparison for its page: curves and performance profile as SVG, in the colours of the reader's choice, light or dark."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.analysis.comparison import Run
from hotlap.analysis.comparison_table import profiles
from hotlap.report.comparison_curves import Curves
from hotlap.report.comparison_looks import DARK, DASHES, LIGHT, Look
from hotlap.report.markup import element, text

Floats = NDArray[np.float64]

LINE = 2.0  # pixels
BAND_UP_TO = 6  # tuners; bands of more would hide each other
FACTORS = np.geomspace(1, 100, 200)
TICKS = (1, 3, 10, 30, 100, 300, 1000, 3000, 10_000)
FACTOR_TICKS = (1, 2, 5, 10, 20, 50, 100)


@dataclass(frozen=True)
class Axes:
    """Where values lie in a chart, in pixels of its drawing; x is logarithmic from 1, y is in per cent.

    Attributes:
        width, height: of the area of the data.
        most: the right end of the x axis, above 1.
    """

    width: float
    height: float
    most: float

    LEFT, TOP, RIGHT, BOTTOM = 44.0, 12.0, 14.0, 40.0  # around the area

    def x(self, value: float) -> float:
        """From the left edge of the drawing."""
        return self.LEFT + self.width * math.log(value) / math.log(self.most)

    def y(self, share: float) -> float:
        """From its upper edge, for a share of 0 to 1."""
        return self.TOP + self.height * (1 - share)

    def step(self, at: Floats, shares: Floats, moved: Floats | None = None) -> str:
        """The path of a line that stays at each value until the next one, up to the first that is NaN.

        Args:
            at: shape (F,), x of each value.
            shares: shape (F,).
            moved: shape (F,), pixels by which it is moved up.
        """
        known = np.isfinite(shares)
        heights = self.y(1) + self.height * (1 - shares[known]) - (0.0 if moved is None else moved[known])
        path, last = list[str](), math.nan
        for place, height in zip(at[known].tolist(), heights.round(1).tolist(), strict=True):
            if height != last:
                path.append(f"H{self.x(place):.1f}V{height:g}" if path else f"M{self.x(place):.1f} {height:g}")
                last = height
        return "".join([*path, f"H{self.x(at[known][-1]):.1f}"])


def curve_chart(curves: Curves, looks: Mapping[str, Look]) -> str:
    """Completion of the best candidate over flights on one race, as a figure."""
    axes, at, shifts = Axes(262, 130, max(float(curves.flights[-1]), 2.0)), curves.flights.astype(float), curves.shifts
    ids = _ids(looks)
    lines = [
        _line(
            axes.step(at, curves.middle[i], shifts[i] * (LINE + 0.4)),
            ids[tuner],
            _said(at, curves.middle[i], curves.low[i], curves.high[i]),
        )
        for i, tuner in enumerate(curves.tuners)
    ]
    bands = [
        element("path", d=_area(axes, at, curves.low[i], curves.high[i]), class_=f"band {ids[tuner]}", data_tuner=ids[tuner])
        for i, tuner in enumerate(curves.tuners)
        if len(looks) <= BAND_UP_TO
    ]
    drawn = _chart(axes, TICKS, "flights, re-flights included", "completion [%]", [*bands, *lines])
    label = f"Completion of the best candidate over flights on {curves.race}"
    return element("figure", element("figcaption", text(curves.race)) + _svg(axes, drawn, label, "flight {x}"), class_="chart")


def profile_chart(runs: Sequence[Run], looks: Mapping[str, Look]) -> str:
    """Share of all races and seeds that were solved within a factor of the fastest tuner's search flights, as a figure."""
    axes, ids = Axes(342, 180, float(FACTORS[-1])), _ids(looks)
    found = profiles(runs, FACTORS)
    shares = np.array([found[tuner] for tuner in looks])
    shifts = Curves("", tuple(looks), np.arange(len(FACTORS)), shares, shares, shares).shifts * (LINE + 0.4)
    lines = [_line(axes.step(FACTORS, shares[i], shifts[i]), ids[tuner], _said(FACTORS, shares[i])) for i, tuner in enumerate(looks)]
    drawn = _chart(axes, FACTOR_TICKS, "search flights, as a multiple of the fewest", "solved [%]", lines)
    return element("figure", _svg(axes, drawn, "Performance profile", "within {x} times"), class_="chart wide-chart")


def legend(looks: Mapping[str, Look]) -> str:
    """The one key of all charts: a button for each tuner, which hides its lines."""
    ids = _ids(looks)
    size: dict[str, object] = {"viewBox": "0 0 34 10", "width": 34, "height": 10, "aria_hidden": "true"}
    samples = {name: element("svg", element("path", d="M0 5H34", class_=f"line {ids[name]}"), **size) for name in looks}
    buttons = "".join(
        element("button", samples[name] + text(name), type="button", data_tuner=ids[name], aria_pressed="true") for name in looks
    )
    return element("div", buttons, class_="legend", role="group", aria_label="tuners that are drawn")


def style_of(looks: Mapping[str, Look]) -> str:
    """Colours and dashes of the tuners as CSS, in light and in dark."""
    ids = _ids(looks)
    light, dark = ("".join(f"--c{i}: {colour}; " for i, colour in enumerate(colours)) for colours in (LIGHT, DARK))
    rules = [f":root {{ {light}}}", f"@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark}}} }}"]
    for name, look in looks.items():
        dashes = " ".join(f"{LINE * part:g}" for part in DASHES[look.dashes]) or "none"
        rules.append(f".{ids[name]} {{ --own: var(--c{look.colour}); stroke-dasharray: {dashes}; }}")
    return "\n".join(rules)


def _ids(looks: Mapping[str, Look]) -> dict[str, str]:
    """A class of CSS for each tuner."""
    return {name: f"t{i}" for i, name in enumerate(looks)}


def _area(axes: Axes, at: Floats, low: Floats, high: Floats) -> str:
    """The path around a band: along the upper quartile, and back along the lower one."""
    known = np.isfinite(low)
    back = [f"V{axes.y(share):.1f}H{axes.x(place):.1f}" for place, share in zip(at[known][::-1], low[known][::-1], strict=True)]
    forth = axes.step(at, high)
    return forth + _thinned(back) + "Z"


def _thinned(steps: Sequence[str]) -> str:
    """Steps back along a line without those that stay at the same height."""
    kept = list[str]()
    for step in steps:
        if kept and kept[-1].partition("H")[0] == step.partition("H")[0]:
            kept.pop()
        kept.append(step)
    return "".join(kept)


def _chart(axes: Axes, ticks: Sequence[int], along: str, up: str, data: Sequence[str]) -> Iterator[str]:
    """Grid, numbers and names of both axes, then the data."""
    bottom, right = axes.y(0) + 6, axes.LEFT + axes.width
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        yield element("path", d=f"M{axes.LEFT} {axes.y(share):g}H{right:g}", class_="grid")
        yield element("text", f"{100 * share:.0f}", x=axes.LEFT - 6, y=f"{axes.y(share) + 4:g}", text_anchor="end")
    for tick in ticks:
        if tick <= axes.most:
            yield element("path", d=f"M{axes.x(tick):.1f} {axes.TOP}V{bottom:g}", class_="grid")
            yield element("text", str(tick), x=f"{axes.x(tick):.1f}", y=f"{bottom + 12:g}", text_anchor="middle")
    middle = axes.TOP + axes.height / 2
    yield element("text", text(along), x=f"{axes.LEFT + axes.width / 2:g}", y=f"{bottom + 28:g}", text_anchor="middle", class_="name")
    yield element("text", text(up), x=0, y=0, transform=f"translate(11 {middle:g}) rotate(-90)", text_anchor="middle", class_="name")
    yield from data


def _line(path: str, tuner: str, said: Mapping[str, str]) -> str:
    """The line of a tuner, with what it says."""
    return element("path", d=path, class_=f"line {tuner}", data_tuner=tuner, **said)


def _said(at: Floats, *values: Floats) -> dict[str, str]:
    """What a line says where it is pointed at: x and the values in per cent wherever one of them changes, and where it ends.

    Args:
        at: shape (F,), x.
        values: shape (F,) each, 0 to 1: of the line, and the quartiles of its band; NaN beyond its end.
    """
    known = np.isfinite(values[0])
    shares = np.column_stack([100 * value[known] for value in values]).round().astype(int)
    changes = np.flatnonzero(np.any(np.diff(shares, axis=0, prepend=-1), axis=1))
    steps = [f"{at[known][i]:.4g} {' '.join(map(str, shares[i].tolist()))}" for i in changes.tolist()]
    return {"data_steps": ";".join(steps), "data_end": f"{at[known][-1]:.4g}"}


def _svg(axes: Axes, parts: Iterator[str], label: str, place: str) -> str:
    """A drawing that is as wide as its place; a script of the page says its values, at a `place` with {x}."""
    size = f"0 0 {axes.LEFT + axes.width + axes.RIGHT:g} {axes.TOP + axes.height + axes.BOTTOM:g}"
    scale = {"data_left": f"{axes.LEFT:g}", "data_width": f"{axes.width:g}", "data_most": f"{axes.most:g}", "data_place": place}
    return element("svg", "".join(parts), viewBox=size, role="img", aria_label=label, **scale)

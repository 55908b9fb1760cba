"""Heat map of a comparison: races down, tuners across, a table for each measure whose cells are the darker the better."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from hotlap.analysis.comparison_table import Row
from hotlap.report.markup import element, text


@dataclass(frozen=True)
class Measure:
    """What a heat map shows.

    Attributes:
        value: of a row; infinite or NaN where there is none.
        show: a value in words.
        caption: what it is.
        fewer: whether less is better; cells are then coloured by the least of their race over their own value.
    """

    value: Callable[[Row], float]
    show: Callable[[float], str]
    caption: str
    fewer: bool = False


def _percent(value: float) -> str:
    return f"{100 * value:.0f}"


MEASURES: Mapping[str, Measure] = {
    "validated": Measure(
        lambda row: row.validated_rate, _percent, "Share of fresh flights of the result that met the goal [%], mean over runs"
    ),
    "confirmed": Measure(lambda row: row.success_rate, _percent, "Share of runs that confirmed a controller [%]"),
    "flights": Measure(
        lambda row: row.flights_median,
        lambda value: f"{value:.0f}",
        "Median search flights to a confirmed controller, - where half of the runs found none; coloured by the fewest over its own",
        fewer=True,
    ),
}


def heat_maps(rows: Sequence[Row]) -> str:
    """A table for each of `MEASURES`; a script of the page shows one of them at a time.

    Args:
        rows: one for each race and tuner, in the order of the races.
    """
    cells = {(row.race, row.tuner): row for row in rows}
    races, names = (list(dict.fromkeys(getattr(row, key) for row in rows)) for key in ("race", "tuner"))
    return "".join(_map(name, measure, races, names, cells) for name, measure in MEASURES.items())


def _map(name: str, measure: Measure, races: Sequence[str], names: Sequence[str], cells: Mapping[tuple[str, str], Row]) -> str:
    """The table of one measure."""
    heads = element("tr", "".join(element("th", _breakable(head), scope="col") for head in ("race", *names)))
    body = "".join(
        element("tr", element("th", text(race), scope="row") + _cells(measure, [cells.get((race, name)) for name in names]))
        for race in races
    )
    table = element("table", element("thead", heads) + element("tbody", body), class_="sortable heat")
    return element(
        "figure", element("figcaption", text(f"{name}: {measure.caption}")) + element("div", table, class_="wide"), data_measure=name
    )


def _cells(measure: Measure, rows: Sequence[Row | None]) -> str:
    """The cells of one race."""
    values = [math.nan if row is None else measure.value(row) for row in rows]
    known = [value for value in values if math.isfinite(value)]
    return "".join(_cell(measure, value, min(known, default=math.nan)) for value in values)


def _cell(measure: Measure, value: float, least: float) -> str:
    if not math.isfinite(value):
        return element("td", "-")
    heat = least / value if measure.fewer and value else 1.0 if measure.fewer else value
    return element("td", text(measure.show(value)), style=f"--heat: {100 * heat**2:.0f}%")


def _breakable(name: str) -> str:
    """A name that may be broken before its preset and at its underscores."""
    return text(name).replace("_", "_<wbr>").replace(":", "<wbr>:")

"""Input charts: commands of the controller and thrusts of the rotors over time, with their limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hotlap.reference.scenario import Scenario
from hotlap.report.scene import Scene, Trace
from hotlap.report.style import BEST, FIRST, GHOST_DASHES, INK, QUIET, SMALL, headline, place_axes, styled
from hotlap.report.time_charts import draw_bands, draw_gate_times

Floats = NDArray[np.float64]

LEFT, RIGHT, TOP, BOTTOM, BETWEEN = 0.72, 0.95, 0.95, 0.5, 0.12  # inches
WIDTH, HEIGHT = 8.0, 1.05  # inches of a chart
HEADROOM = 0.3  # of the range of the first chart, for the names of segments
ROTORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#8c8200")  # Okabe and Ito; the last a darker yellow


@dataclass(frozen=True)
class Row:
    """The data of one chart.

    Attributes:
        label: of its axis, with its unit.
        limits: least and largest value that is allowed.
        flown: shape (n, lines) of the first flight.
        planned: shape (rows,) of the reference; None where it has none.
    """

    label: str
    limits: tuple[float, float]
    flown: Floats
    planned: Floats | None


@styled
def inputs(scene: Scene, scenario: Scenario) -> Figure:
    """Charts of thrust, body rates and rotor thrusts of the first flight of a scene, with the reference and the limits.

    Args:
        scene: with at least one flight.
        scenario: with the limits of the inputs.
    """
    flight, rows = scene.traces[0], _rows(scene, scenario)
    figure = Figure(figsize=(LEFT + WIDTH + RIGHT, BOTTOM + len(rows) * (HEIGHT + BETWEEN) - BETWEEN + TOP))
    for i, row in enumerate(rows):
        axes = place_axes(figure, LEFT, BOTTOM + (len(rows) - 1 - i) * (HEIGHT + BETWEEN), WIDTH, HEIGHT)
        axes.set_xlim(0, scene.reference.duration)
        _draw(axes, row, flight, scene)
        if i == 0:
            axes.set_ylim(top=row.limits[1] + HEADROOM * (row.limits[1] - row.limits[0]))
            draw_gate_times(axes, scene, WIDTH)
            draw_bands(axes, scene.segments, WIDTH)
        last = i == len(rows) - 1
        axes.tick_params(labelbottom=last)
        axes.set_xlabel("time [s]" if last else "")
    key = [("━", BEST, f"{flight.label}, {flight.ending}"), ("╍╍", FIRST, "reference"), ("█", "#e4e4e4", "beyond the limits")]
    headline(figure, LEFT, f"{scene.race}: inputs", "commands of the controller, and thrust of each rotor; numbers: gates", key)
    return figure


def _rows(scene: Scene, scenario: Scenario) -> list[Row]:
    """The charts from top to bottom: collective thrust, three body rates, rotor thrusts."""
    flight, reference, settings = scene.traces[0], scene.reference, scenario.race.controller
    planned = slice(0, reference.planned_rows)
    rows = [Row("thrust\n[m/s²]", scenario.thrust_limits, flight.commands[:, :1], reference.thrust[planned])]
    for j, name in enumerate(("roll", "pitch", "yaw")):
        limit = settings.rates[j]
        rows.append(Row(f"{name} rate\n[rad/s]", (-limit, limit), flight.commands[:, j + 1 : j + 2], reference.rates[planned, j]))
    if not np.isfinite(flight.rotor_thrusts).any():
        return rows  # a real flight, whose rotors nobody measured
    return [*rows, Row("rotors\n[N]", scenario.race.vehicle.rotor_thrust, flight.rotor_thrusts, None)]


def _draw(axes: Axes, row: Row, flight: Trace, scene: Scene) -> None:
    """One chart: a quantity of the flight and of the reference between its limits."""
    low, high = row.limits
    margin = 0.14 * (high - low)
    axes.set_ylim(low - margin, high + margin)
    for start, end in ((low - margin, low), (high, high + (high - low))):
        axes.axhspan(start, end, color="#e4e4e4", linewidth=0, zorder=0)
    if row.planned is not None:
        axes.plot(scene.reference.times[: len(row.planned)], row.planned, color=FIRST, linewidth=0.9, linestyle=GHOST_DASHES, zorder=2)
    several = row.flown.shape[1] > 1
    for j, values in enumerate(row.flown.T):
        axes.plot(flight.times, values, color=ROTORS[j] if several else BEST, linewidth=0.7 if several else 1.1, zorder=3)
    if several and len(flight.times):
        for j in range(row.flown.shape[1]):
            place = 0.95 - j / row.flown.shape[1]
            axes.text(1.01, place, f"rotor {j}", transform=axes.transAxes, fontsize=SMALL, color=ROTORS[j], va="top")
    axes.text(1.01, 0.5, "" if several else f"{_at_limit(row):.0f} % of the time\nat a limit", transform=axes.transAxes, fontsize=SMALL)
    axes.set_ylabel(row.label, fontsize=SMALL, color=INK if several else QUIET)


def _at_limit(row: Row) -> float:
    """Share of the time at a limit [%]."""
    low, high = row.limits
    slack = 0.005 * (high - low)
    values = row.flown[np.isfinite(row.flown).all(axis=1)]
    return 100 * float(((values <= low + slack) | (values >= high - slack)).any(axis=1).mean()) if len(values) else 0.0

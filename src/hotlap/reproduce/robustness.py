"""Robustness on Qualifier: tuned for one mass, speed or layout and flown at another (a figure of the paper), and beyond it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hotlap import tuners
from hotlap.analysis.learning import built_in_world
from hotlap.files import load_race
from hotlap.objective import Objective
from hotlap.preparation import prepare
from hotlap.race import Race
from hotlap.reproduce.context import Context
from hotlap.reproduce.page import Page, percent
from hotlap.reproduce.published import RACES
from hotlap.seeds import Stream, flight_seeds
from hotlap.tuning import Tuning, TuningSettings, course_for, tune_together

TUNER = "guided_walk:tied"  # one set for all segments, so that it can be flown on any layout
FLIGHTS = 50


@dataclass(frozen=True)
class Tuned:
    """Runs to be tuned on a race."""

    race: Race
    seeds: int
    randomise: float = 0.0
    budget: int = 300


@dataclass(frozen=True)
class Carried:
    """Parameters, K each, to be flown on a race."""

    race: Race
    parameters: tuple[tuple[float, ...], ...]


def tune(wanted: Tuned) -> Iterator[list[list[float]]]:
    """The best parameters of each run, confirmed or not, K each."""
    course = course_for(prepare(wanted.race), tuners.build(TUNER))
    shared: dict[str, Any] = {"budget": wanted.budget, "confirm": 10, "validation": 0, "reliability": 0.0, "randomise": wanted.randomise}
    runs = [Tuning(tuners.build(TUNER), course, TuningSettings(seed=seed, **shared)) for seed in range(wanted.seeds)]
    for _ in tune_together(Objective(course, built_in_world(), randomise=wanted.randomise), runs):
        pass
    yield [run.best.parameters[0].tolist() for run in runs if run.best is not None]


def carry(wanted: Carried) -> Iterator[float]:
    """Mean completion over all parameters."""
    course = prepare(wanted.race)
    each = np.repeat(np.array(wanted.parameters)[:, None], len(course.segments), axis=1)
    seeds = np.tile(flight_seeds(0, Stream.DEMONSTRATION, 0, FLIGHTS), len(each))
    yield float(Objective(course, built_in_world()).fly(np.repeat(each, FLIGHTS, axis=0), seeds).completion.mean())


def _heavier(race: Race, factor: float) -> Race:
    q = race.vehicle
    return _flown_by(race, mass=q.mass * factor, inertia=tuple(part * factor for part in q.inertia))


def _flown_by(race: Race, **changes: Any) -> Race:
    """The same race with another truth; controller and plan do not know."""
    return race.model_copy(update={"vehicle": race.vehicle.model_copy(update=changes), "model": race.believed, "planning": _planned(race)})


def _planned(race: Race) -> Any:
    """The plan's settings with its quadrotor written out."""
    return race.planning.model_copy(update={"quadrotor": race.planned})


def _faster(race: Race, v_max: float) -> Race:
    return race.model_copy(update={"planning": race.planning.model_copy(update={"v_max": v_max})})


def _noisier(race: Race, factor: float) -> Race:
    names = ("thrust", "rates", "thrust_bias", "position", "velocity", "attitude")
    return race.model_copy(update={"noise": race.noise.model_copy(update={name: factor * getattr(race.noise, name) for name in names})})


def _windy(race: Race, gusts: float) -> Race:
    return race.model_copy(update={"noise": race.noise.model_copy(update={"wind": gusts})})


def _later(race: Race, delay: float) -> Race:
    return _flown_by(race, delay=delay)


def _lazier(race: Race, factor: float) -> Race:
    return _flown_by(race, motor_time=tuple(factor * part for part in race.vehicle.motor_time))


def _weaker(race: Race, share: float) -> Race:
    low, high = race.vehicle.rotor_thrust
    return _flown_by(race, rotor_thrust=(min(low, share * high / 2), share * high))


AXES: Mapping[str, tuple[str, Callable[[Race, float], Race], tuple[float, ...]]] = {
    "mass": ("factor", _heavier, (0.6, 0.8, 1.0, 1.2, 1.5)),
    "speed": ("v_max [m/s]", _faster, (12.0, 14.0, 16.0, 18.0, 20.0, 22.0, 24.0)),
    "dead time": ("s", _later, (0.0, 0.02, 0.04, 0.045, 0.05, 0.06)),
    "noise": ("factor", _noisier, (0.0, 1.0, 2.0, 3.0, 4.0)),
    "wind": ("gusts [m/s^2]", _windy, (0.0, 0.5, 1.0, 2.0, 4.0)),
    "motor lag": ("factor", _lazier, (0.5, 1.0, 2.0, 3.0)),
    "largest thrust": ("factor", _weaker, (0.7, 0.8, 0.9, 1.0, 1.2)),
}
SPREADS = (0.0, 0.1)  # of --randomise


def robustness(context: Context) -> Page:
    """A matrix for each axis: rows tuned, columns flown; and a line for tuning in randomised worlds."""
    from hotlap.report.reproduction import draw_matrix  # noqa: PLC0415  matplotlib takes half a second to load

    base = load_race("circle-34" if context.quick else "qualifier-20")
    seeds = 1 if context.quick else 5
    grids: dict[str, dict[str, Race]] = {
        name: {f"{value:g}": change(base, value) for value in (values[1:3] if context.quick else values)}
        for name, (_, change, values) in AXES.items()
    }
    grids["layout"] = {name: load_race(name) for name in (RACES[:2] if context.quick else RACES)}
    if context.quick:
        grids = {name: grids[name] for name in ("mass", "layout")}
    jobs = {f"{axis} {label}, {seeds} seeds": Tuned(race, seeds) for axis, races in grids.items() for label, race in races.items()}
    jobs |= {f"randomised by {spread:g}, {seeds} seeds": Tuned(base, seeds, spread, 600) for spread in SPREADS}
    found = context.each("controllers to tune", jobs, tune)
    parameters = {key: tuple(map(tuple, values)) for key, values in found.items()}
    flights = {
        f"{axis}: {label} flown at {target}, {seeds} seeds": Carried(race, parameters[f"{axis} {label}, {seeds} seeds"])
        for axis, races in grids.items()
        for label in races
        for target, race in races.items()
    }
    flights |= {
        f"randomised by {spread:g}: {axis} {target}, {seeds} seeds": Carried(race, parameters[f"randomised by {spread:g}, {seeds} seeds"])
        for spread in SPREADS
        for axis, races in grids.items()
        for target, race in races.items()
    }
    shares = context.each("flights", flights, carry)
    page = Page("Robustness")
    page.say(
        f"Mean completion [%] on {base.name} of {seeds} controllers, {FLIGHTS} flights each, tuned under the condition of a row "
        "and flown under "
        "that of a column. Neither the plan nor the controller knows of it, but for speed and layout, which change the plan. "
        "Tuned from the "
        "default weights."
    )
    for axis, races in grids.items():
        labels = list(races)
        values = [[shares[f"{axis}: {row} flown at {column}, {seeds} seeds"] for column in labels] for row in labels]
        matrix = np.array(values)
        unit = AXES[axis][0] if axis in AXES else "race"
        page.head(axis)
        path = context.folder / f"{axis.replace(' ', '-')}.png"
        draw_matrix(
            path,
            f"{axis} ({unit})",
            f"mean completion [%], {base.name}" if axis != "layout" else "mean completion [%]",
            (labels, labels),
            matrix,
        )
        page.picture(path, f"completion: {axis}")
        same, other = np.diag(matrix).mean(), matrix[~np.eye(len(labels), dtype=bool)].mean()
        page.say(f"Tuned where it is flown {percent(float(same))} %, elsewhere {percent(float(other))} %.")
    page.head("Tuned in randomised worlds")
    page.say(f"Flown under the same conditions, tuned on {base.name} as it is, or with `--randomise 0.1`:")
    for axis, races in grids.items():
        rows = [
            [f"--randomise {spread:g}", *(percent(shares[f"randomised by {spread:g}: {axis} {target}, {seeds} seeds"]) for target in races)]
            for spread in SPREADS
        ]
        page.table((axis, *races), rows)
    return page

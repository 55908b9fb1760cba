"""Robustness on Qualifier: tuned for one mass, speed or layout and flown at another (a figure of the paper), and beyond it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap import tuners
from hotlap.analysis.learning import built_in_world
from hotlap.analysis.resumable import ResumableJobs
from hotlap.core.counts import count
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare
from hotlap.race.race import Race
from hotlap.report.article import Article, percent
from hotlap.reproduce.published import RACES
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune_together
from hotlap.tuning.objective import Objective

TUNER = "guided_walk:tied"  # one set for all segments, so that it can be flown on any layout
FLIGHTS = 50


@dataclass(frozen=True)
class TuningJob:
    """Runs to be tuned on a race."""

    race: Race
    seeds: int
    randomise: float = 0.0
    budget: int = 300


@dataclass(frozen=True)
class FlightJob:
    """Parameters, K each, to be flown on a race."""

    race: Race
    parameters: tuple[tuple[float, ...], ...]


def tune_controllers(wanted: TuningJob) -> Iterator[list[list[float]]]:
    """The best parameters of each run, confirmed or not, K each."""
    scenario = scenario_for(prepare(wanted.race), tuners.build(TUNER))
    shared: dict[str, Any] = {"budget": wanted.budget, "confirm": 10, "validation": 0, "reliability": 0.0, "randomise": wanted.randomise}
    runs = [Tuning(tuners.build(TUNER), scenario, TuningSettings(seed=seed, **shared)) for seed in range(wanted.seeds)]
    for _ in tune_together(Objective(scenario, built_in_world(), randomise=wanted.randomise), runs):
        pass
    yield [run.best.parameters[0].tolist() for run in runs if run.best is not None]


def fly_controllers(wanted: FlightJob) -> Iterator[float]:
    """Mean completion over all parameters."""
    scenario = prepare(wanted.race)
    each = np.repeat(np.array(wanted.parameters)[:, None], len(scenario.segments), axis=1)
    seeds = np.tile(flight_seeds(0, Stream.DEMONSTRATION, 0, FLIGHTS), len(each))
    yield float(Objective(scenario, built_in_world()).fly(np.repeat(each, FLIGHTS, axis=0), seeds).completion.mean())


def _heavier(race: Race, factor: float) -> Race:
    q = race.vehicle
    return _flown_by(race, mass=q.mass * factor, inertia=tuple(part * factor for part in q.inertia))


def _flown_by(race: Race, **changes: Any) -> Race:
    """The same race with another vehicle; controller and plan do not know."""
    return race.model_copy(
        update={"vehicle": race.vehicle.model_copy(update=changes), "model": race.control_model, "planning": _planned(race)}
    )


def _planned(race: Race) -> Any:
    """The plan's settings with its quadrotor written out."""
    return race.planning.model_copy(update={"quadrotor": race.planning_model})


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


def robustness(jobs: ResumableJobs, *, quick: bool) -> Article:
    """A matrix for each axis: rows tuned, columns flown; and a line for tuning with randomised vehicle parameters."""
    base, seeds = load_race("circle-34" if quick else "qualifier-20"), 1 if quick else 5
    grids = _conditions(base, quick=quick)
    wanted = {f"{axis} {label}": TuningJob(race, seeds) for axis, races in grids.items() for label, race in races.items()}
    wanted |= {_randomised(spread): TuningJob(base, seeds, spread, 600) for spread in SPREADS}
    tuned = {key: tuple(map(tuple, values)) for key, values in jobs.each("controllers to tune", wanted, tune_controllers).items()}
    flights = {
        f"{source} flown at {axis} {target}": FlightJob(race, tuned[source])
        for axis, races in grids.items()
        for source in [*(f"{axis} {label}" for label in races), *map(_randomised, SPREADS)]
        for target, race in races.items()
    }
    shares = jobs.each("flights", flights, fly_controllers)
    page = Article("Robustness")
    page.say(
        f"Mean completion [%] on {base.name} of {count(seeds, 'controller')}, {FLIGHTS} flights each, tuned under the condition of "
        "the row and flown under that of the column. The condition is in neither the plan nor the controller's model, except speed and "
        "layout, which change the plan. Tuned from the default weights."
    )
    for axis, races in grids.items():
        values = [[shares[f"{axis} {row} flown at {axis} {column}"] for column in races] for row in races]
        _show_matrix(jobs, page, axis, list(races), np.array(values))
    page.head("Tuned with randomised vehicle parameters")
    page.say(f"Flown under the same conditions, tuned on {base.name} as it is, or with `--randomise 0.1`:")
    for axis, races in grids.items():
        rows = [
            [f"--randomise {spread:g}", *(percent(shares[f"{_randomised(spread)} flown at {axis} {target}"]) for target in races)]
            for spread in SPREADS
        ]
        page.table((axis, *races), rows)
    return page


def _conditions(base: Race, *, quick: bool) -> dict[str, dict[str, Race]]:
    """Races by axis and label; two of two axes in the short form."""
    grids = {axis: {f"{value:g}": change(base, value) for value in values} for axis, (_, change, values) in AXES.items()}
    grids["layout"] = {name: load_race(name) for name in RACES}
    if not quick:
        return grids
    return {"mass": {label: grids["mass"][label] for label in ("0.8", "1")}, "layout": {name: grids["layout"][name] for name in RACES[:2]}}


def _randomised(spread: float) -> str:
    """Name of what is tuned with `--randomise`."""
    return f"randomised by {spread:g}"


def _show_matrix(jobs: ResumableJobs, page: Article, axis: str, labels: list[str], shares: NDArray[np.float64]) -> None:
    """One axis: the matrix, and its mean on the diagonal and beside it."""
    from hotlap.report.reproduction import draw_matrix  # noqa: PLC0415  matplotlib takes half a second to load

    unit = AXES[axis][0] if axis in AXES else "race"
    path = jobs.folder / f"{axis.replace(' ', '-')}.png"
    draw_matrix(path, f"{axis} ({unit})", "mean completion [%]", (labels, labels), shares)
    same, other = np.diag(shares).mean(), shares[~np.eye(len(labels), dtype=bool)].mean()
    page.head(axis)
    page.picture(path, f"completion: {axis}")
    page.say(f"Tuned where it is flown {percent(float(same))} %, elsewhere {percent(float(other))} %.")

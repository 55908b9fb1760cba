"""The landscape: non-convex, ragged, and harder the faster the reference (a figure of the paper)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np

from hotlap.analysis.landscape import Landscape, axes, draw_survey
from hotlap.analysis.learning import built_in_world
from hotlap.analysis.resumable import ResumableJobs
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.core.success_rate import wilson_interval
from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare
from hotlap.race.race import Race
from hotlap.report.article import Article, percent
from hotlap.tuning.objective import Objective

MAPPED: Mapping[str, tuple[float, float]] = {"circle-34": (12.0, 34.0), "qualifier-20": (12.0, 20.0)}  # m/s, slow and fast
SPEEDS: Mapping[str, tuple[float, ...]] = {
    "circle-34": (12.0, 16.0, 20.0, 26.0, 34.0, 45.0),
    "qualifier-20": (12.0, 14.0, 16.0, 18.0, 20.0, 22.0, 24.0),
    "airsim-circle-34": (12.0, 16.0, 20.0, 26.0, 34.0),
    "airsim-qualifier-20": (12.0, 14.0, 16.0, 18.0, 20.0),
}
PAIRS = (("Q_pos_xy", "horizon"), ("Q_pos_xy", "Q_velocity"))
POINTS, FLIGHTS, SAMPLES = 60, 8, 4000


@dataclass(frozen=True)
class Scatter:
    """Random parameters, one set for all segments, evenly in logarithms within the bounds."""

    race: Race
    samples: int


def scatter(wanted: Scatter) -> Iterator[dict[str, float]]:
    """Largest and mean speed [m/s] of the plan, share of flights that pass every gate, mean completion."""
    scenario = prepare(wanted.race)
    unit = np.random.default_rng(0).random((wanted.samples, 1, scenario.space.size))
    values = scenario.space.from_unit(unit).repeat(len(scenario.segments), axis=1)
    seeds = flight_seeds(0, Stream.DEMONSTRATION, 0, wanted.samples)
    completion, reference = Objective(scenario, built_in_world()).fly(values, seeds).completion, scenario.reference
    shares = {"complete": float((completion == 1).mean()), "completion": float(completion.mean())}
    yield {"top": reference.max_speed, "mean": reference.mean_speed, **shares}


def landscape(jobs: ResumableJobs, *, quick: bool) -> Article:
    """Maps over two parameters, slow and fast; and how rare good parameters are at each speed."""
    page = Article("The landscape of completion")
    points, flights = (12, 2) if quick else (POINTS, FLIGHTS)
    page.say(
        f"Mean completion over {flights} flights with the same noise at every point, {points} x {points} points between the bounds, "
        "equally spaced in logarithms; the other parameters are the authors' defaults, the same in all segments."
    )
    for name, (x, y) in product(list(MAPPED)[: 1 if quick else None], PAIRS[: 1 if quick else None]):
        _map(jobs, page, name, Landscape(load_race(name), x, y, points, flights))
    _scatter(jobs, page, quick=quick)
    return page


def at_speed(race: Race, v_max: float) -> Race:
    """A race planned for another speed."""
    return race.model_copy(update={"planning": race.planning.model_copy(update={"v_max": v_max})})


def _map(jobs: ResumableJobs, page: Article, name: str, asked: Landscape) -> None:
    """One pair of parameters, slow and fast."""
    from hotlap.report.reproduction import draw_maps  # noqa: PLC0415  matplotlib takes half a second to load

    maps = {
        f"{name} at {v_max:g} m/s, {asked.x} and {asked.y}, {asked.points} points, {asked.flights} flights": Landscape(
            **{**vars(asked), "race": at_speed(asked.race, v_max)}
        )
        for v_max in MAPPED[name]
    }
    grids = [np.array(grid) for grid in jobs.each("maps", maps, draw_survey).values()]
    whole = [percent(float((grid == 1).mean())) for grid in grids]
    titles = [f"{name}, v_max {v_max:g} m/s: {share} % of the map complete" for v_max, share in zip(MAPPED[name], whole, strict=True)]
    scenario = prepare(asked.race)
    default = dict(zip(scenario.space.names, scenario.space.default.tolist(), strict=True))
    path = jobs.folder / f"{name}-{asked.x}-{asked.y}.png"
    draw_maps(path, axes(scenario, asked), (asked.x, asked.y), grids, titles, (default[asked.x], default[asked.y]))
    page.picture(path, f"completion over {asked.x} and {asked.y}")


def _scatter(jobs: ResumableJobs, page: Article, *, quick: bool) -> None:
    """The faster, the more sensitive: a table and a curve."""
    from hotlap.report.reproduction import draw_shares  # noqa: PLC0415  matplotlib takes half a second to load

    speeds, samples = ({"circle-34": (12.0, 34.0)}, 200) if quick else (SPEEDS, SAMPLES)
    pieces = {
        f"{name} at {v_max:g} m/s, {samples} samples": Scatter(at_speed(load_race(name), v_max), samples)
        for name, own in speeds.items()
        for v_max in own
    }
    found = jobs.each("speeds", pieces, scatter)
    rows = {(name, v_max): found[f"{name} at {v_max:g} m/s, {samples} samples"] for name, own in speeds.items() for v_max in own}
    page.head("The faster, the more sensitive")
    page.say(
        f"Share of {samples} random parameters, one set for all segments, uniform in logarithms within the bounds, that pass every gate, "
        "with Wilson's 95 % interval:"
    )
    page.table(
        ("race", "v_max [m/s]", "top speed of the plan [m/s]", "mean speed [m/s]", "complete %", "mean completion %"),
        [
            (name, f"{v_max:g}", f"{row['top']:.1f}", f"{row['mean']:.1f}", _share(row["complete"], samples), percent(row["completion"]))
            for (name, v_max), row in rows.items()
        ],
    )
    path = jobs.folder / "shares.png"
    draw_shares(path, {name: [rows[name, v_max] for v_max in own] for name, own in speeds.items()})
    page.picture(path, "share of random parameters that complete, over the mean speed of the plan")


def _share(share: float, samples: int) -> str:
    """In per cent, with its interval."""
    low, high = wilson_interval(round(share * samples), samples)
    return f"{100 * share:.1f} [{100 * low:.1f}, {100 * high:.1f}]"

"""Where searches end that begin at random: many modes, or one valley: a figure of the paper, and a claim."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap import tuners
from hotlap.analysis.learning import built_in_world
from hotlap.files import load_race
from hotlap.goal import Goal, Quantity
from hotlap.objective import Objective
from hotlap.preparation import prepare
from hotlap.reproduce.context import Context
from hotlap.reproduce.page import Page, percent
from hotlap.seeds import Stream, flight_seeds
from hotlap.tuning import Tuning, TuningSettings, course_for, tune_together

Floats = NDArray[np.float64]

TUNERS = ("metropolis_hastings:paper", "metropolis_hastings:tied", "guided_walk")
PLACES, FLIGHTS = 9, 16  # along a line between two optima, and at each place
CHAIN = "metropolis_hastings:tied"
CONVERGED = 1.1  # of Gelman and Rubin's ratio


@dataclass(frozen=True)
class Start:
    """A run from parameters drawn evenly in logarithms within the bounds, the same in all segments."""

    race: str
    tuner: str
    seed: int
    budget: int
    keep: bool = False


@dataclass(frozen=True)
class Line:
    """A straight line in logarithms between two sets of parameters, shape (S, K)."""

    race: str
    one: tuple[tuple[float, ...], ...]
    other: tuple[tuple[float, ...], ...]


def search(wanted: Start) -> Iterator[dict[str, Any]]:
    """Search flights to a confirmed controller, what it is, and the samples on the way; with `keep`, the whole chain, whatever it meets."""
    course = course_for(prepare(load_race(wanted.race)), tuners.build(wanted.tuner))
    space = course.space
    start = space.from_unit(np.random.default_rng([wanted.seed, 0x73746172]).random(space.size))
    goal = Goal(Quantity.NONE, 0.0) if wanted.keep else Goal()
    settings = TuningSettings(goal=goal, budget=wanted.budget, seed=wanted.seed, confirm=10, validation=0, reliability=0.0, batch=1)
    run = Tuning(tuners.build(wanted.tuner), course, settings, np.tile(start, (len(course.segments), 1)))
    now, trace = start, []
    for _, batch in tune_together(Objective(course, built_in_world()), [run]):
        flown = batch.ledger.of(Stream.SEARCH)
        for accepted, parameters in zip(flown.accepted, flown.parameters, strict=True):
            now = np.exp(np.log(parameters).mean(axis=0)) if accepted else now
            trace.append([float(f"{value:.4g}") for value in now])
    confirmed = run.best is not None and run.best.confirmed
    found = run.best.parameters.tolist() if run.best is not None and confirmed else None
    yield {"flights": run.search_flights if confirmed else None, "found": found, "trace": trace[:: max(1, len(trace) // 1000)]}


def walk(wanted: Line) -> Iterator[list[float]]:
    """Mean completion at places along the line."""
    course = prepare(load_race(wanted.race))
    share = np.linspace(0, 1, PLACES)[:, None, None]
    values = np.exp((1 - share) * np.log(wanted.one) + share * np.log(wanted.other))
    each = np.repeat(values, FLIGHTS, axis=0)
    seeds = np.tile(flight_seeds(0, Stream.DEMONSTRATION, 0, FLIGHTS), PLACES)
    completion = Objective(course, built_in_world()).fly(each, seeds).completion
    yield completion.reshape(PLACES, FLIGHTS).mean(axis=1).tolist()


def initialisations(context: Context) -> Page:
    """Twenty random starts, the lines between what they found, and long chains."""
    from hotlap.report.reproduction import draw_marginals, draw_traces  # noqa: PLC0415  matplotlib takes half a second to load

    races = ("circle-34",) if context.quick else ("qualifier-20", "airsim-flip-16")
    count, budget, long = (2, 60, 100) if context.quick else (20, 1000, 5000)
    starts = {
        f"{race} by {tuner} from {seed}, {budget} flights": Start(race, tuner, seed, budget)
        for race in races
        for tuner in TUNERS
        for seed in range(count)
    }
    chains = {
        f"{race}, chain {seed}, {long} flights": Start(race, CHAIN, seed, long, keep=True)
        for race in races
        for seed in range(2 if context.quick else 4)
    }
    found = context.each("searches", {**starts, **chains}, search)
    page = Page("Random starts")
    page.say(
        f"{count} searches begin at parameters drawn evenly in logarithms within the bounds, the same in all segments; {budget} flights, "
        "ten re-flights."
    )
    rows = []
    for race in races:
        for tuner in TUNERS:
            own = [found[key]["flights"] for key, one in starts.items() if (one.race, one.tuner) == (race, tuner)]
            flights = [np.inf if one is None else one for one in own]
            middle = np.median(flights)
            rows.append(
                [
                    race,
                    tuner,
                    percent(float(np.isfinite(flights).mean())),
                    f"{middle:.0f}" if np.isfinite(middle) else "-",
                    f"{min(flights):.0f}",
                    f"{max(flights):.0f}",
                ]
            )
    page.table(("race", "tuner", "reach 100 % [%]", "median flights", "least", "most"), rows)
    for race in races:
        _describe(context, page, race, starts, chains, found, draw_traces, draw_marginals)
    return page


def _describe(context: Context, page: Page, race: str, starts: Any, chains: Any, found: Any, draw_traces: Any, draw_marginals: Any) -> None:
    """One race: traces, lines between optima, and the chains' distribution."""
    space = prepare(load_race(race)).space
    page.head(race)
    traces = [np.array(found[key]["trace"]) for key, one in starts.items() if (one.race, one.tuner) == (race, TUNERS[1])]
    path = context.folder / f"{race}-traces.png"
    draw_traces(
        path,
        f"{race}: {TUNERS[1]} from random starts",
        "accepted parameters over flights; a dot where the run ended",
        space.names,
        traces,
        space.low,
        space.high,
    )
    page.picture(path, "parameters over flights")
    optima = [tuple(map(tuple, found[key]["found"])) for key, one in starts.items() if one.race == race and found[key]["found"]]
    if len(optima) > 1:
        pairs = list(combinations(range(len(optima)), 2))[:: max(1, len(optima) * (len(optima) - 1) // 2 // 60)]
        mark = hashlib.sha256(repr(optima).encode()).hexdigest()[:8]
        lines = {f"{race}, optima {mark}: {i} to {j}": Line(race, optima[i], optima[j]) for i, j in pairs}
        shares = np.array(list(context.each("lines", lines, walk).values()))
        inside = shares[:, 1:-1].min(axis=1)
        factors = ", ".join(f"{factor:.1f} in {name}" for name, factor in zip(space.names, _spread(optima), strict=True))
        page.say(
            f"{len(optima)} optima; along {len(lines)} straight lines between two of them, in logarithms, completion stays above 90 % on "
            f"{percent(float((inside > 0.9).mean()))} %, and falls below 50 % on {percent(float((inside < 0.5).mean()))} %; the "
            "mean lowest "
            f"is {percent(float(inside.mean()))} %. The optima spread by a factor of {factors} "
            "(from the 10th to the 90th percentile)."
        )
    samples = [np.array(found[key]["trace"])[len(found[key]["trace"]) // 5 :] for key, one in chains.items() if one.race == race]
    path = context.folder / f"{race}-marginals.png"
    ratios = gelman_rubin(np.log(np.array(samples)))
    draw_marginals(
        path,
        f"{race}: what {CHAIN} samples",
        f"{len(samples)} chains from random starts, the first fifth left out",
        space.names,
        samples,
        space.low,
        space.high,
    )
    page.picture(path, "marginals of long chains")
    agreed = "agree" if (ratios < CONVERGED).all() else "do not agree"
    shown = ", ".join(f"{name} {ratio:.2f}" for name, ratio in zip(space.names, ratios, strict=True))
    page.say(f"Gelman and Rubin's ratio over the chains: {shown}; below {CONVERGED} they agree. They {agreed}.")


def _spread(optima: list[tuple[tuple[float, ...], ...]]) -> Floats:
    """Factor from the 10th to the 90th percentile of means over segments, shape (K,)."""
    low, high = np.percentile(np.exp(np.log(np.array(optima)).mean(axis=1)), (10, 90), axis=0)
    return high / low


def gelman_rubin(chains: Floats) -> Floats:
    """Potential scale reduction of chains, shape (chains, samples, K) to (K,) (Gelman, Rubin, Stat. Science 7, 1992)."""
    count = chains.shape[1]
    within, between = chains.var(axis=1, ddof=1).mean(axis=0), chains.mean(axis=1).var(axis=0, ddof=1)
    return np.sqrt((count - 1) / count + between / np.maximum(within, 1e-12))

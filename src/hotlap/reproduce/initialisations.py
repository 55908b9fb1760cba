"""Where searches end that begin at random: many modes, or one valley: a figure of the paper, and a claim."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap import tuners
from hotlap.analysis.learning import built_in_world
from hotlap.analysis.resumable import ResumableJobs
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.core.success_rate import wilson_interval
from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare
from hotlap.race.race import Race
from hotlap.reference.scenario import Scenario
from hotlap.report.article import Article, percent
from hotlap.tuning.goal import Goal, Quantity
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune_together
from hotlap.tuning.objective import Objective

Floats = NDArray[np.float64]

CHAIN = "metropolis_hastings:tied"
TUNERS = ("metropolis_hastings:paper", CHAIN, "guided_walk")
PLACES, FLIGHTS = 9, 16  # along a line between two optima, and at each place
MOST_LINES = 60  # about
CONVERGED = 1.1  # of Gelman and Rubin's ratio


@dataclass(frozen=True)
class Starts:
    """Runs from parameters drawn uniformly in logarithms, the same in all segments; with `keep` they go on after one is confirmed."""

    race: Race
    tuner: str
    seeds: int
    budget: int
    keep: bool = False

    @property
    def label(self) -> str:
        """For people."""
        return f"{self.race.name}: {self.seeds} {'chains' if self.keep else 'searches'} by {self.tuner}, {self.budget} flights"


@dataclass(frozen=True)
class Line:
    """A straight line in logarithms between two sets of parameters, shape (S, K)."""

    race: Race
    one: tuple[tuple[float, ...], ...]
    other: tuple[tuple[float, ...], ...]


def search(wanted: Starts) -> Iterator[list[dict[str, Any]]]:
    """Of each run: search flights to a confirmed controller, what it is, and the samples on the way; all runs fly in one batch."""
    scenario = scenario_for(prepare(wanted.race), tuners.build(wanted.tuner))
    runs = [_begin(wanted, scenario, seed) for seed in range(wanted.seeds)]
    traces: list[list[NDArray[np.float64]]] = [[] for _ in runs]
    for i, batch in tune_together(Objective(scenario, built_in_world()), runs):
        flown = batch.ledger.of(Stream.SEARCH)
        for accepted, parameters in zip(flown.accepted, flown.parameters, strict=True):
            moved = accepted or not traces[i]
            traces[i].append(np.exp(np.log(parameters).mean(axis=0)) if moved else traces[i][-1])
    yield [_end(run, trace) for run, trace in zip(runs, traces, strict=True)]


def _begin(wanted: Starts, scenario: Scenario, seed: int) -> Tuning:
    """A run at its random start."""
    space = scenario.space
    start = space.from_unit(np.random.default_rng([seed, 0x73746172]).random(space.size))
    goal = Goal(Quantity.NONE, 0.0) if wanted.keep else Goal()
    settings = TuningSettings(goal=goal, budget=wanted.budget, seed=seed, confirm=10, validation=0, reliability=0.0, batch=1)
    return Tuning(tuners.build(wanted.tuner), scenario, settings, np.tile(start, (len(scenario.segments), 1)))


def _end(run: Tuning, trace: Sequence[NDArray[np.float64]]) -> dict[str, Any]:
    """What came of a run; of a long trace about a thousand samples are kept."""
    confirmed = run.best is not None and run.best.confirmed
    kept = [[float(f"{value:.4g}") for value in values] for values in trace[:: max(1, len(trace) // 1000)]]
    found = run.best.parameters.tolist() if run.best is not None and confirmed else None
    return {"flights": run.search_flights if confirmed else None, "found": found, "trace": kept}


def walk(wanted: Line) -> Iterator[list[float]]:
    """Mean completion at places along the line."""
    scenario = prepare(wanted.race)
    share = np.linspace(0, 1, PLACES)[:, None, None]
    values = np.exp((1 - share) * np.log(wanted.one) + share * np.log(wanted.other))
    each = np.repeat(values, FLIGHTS, axis=0)
    seeds = np.tile(flight_seeds(0, Stream.DEMONSTRATION, 0, FLIGHTS), PLACES)
    completion = Objective(scenario, built_in_world()).fly(each, seeds).completion
    yield completion.reshape(PLACES, FLIGHTS).mean(axis=1).tolist()


def initialisations(jobs: ResumableJobs, *, quick: bool) -> Article:
    """Twenty random starts, the lines between what they found, and long chains."""
    races = ("circle-34",) if quick else ("qualifier-20", "airsim-flip-16")
    count, budget, long = (2, 30, 50) if quick else (20, 1000, 5000)
    wanted = [Starts(load_race(race), tuner, count, budget) for race in races for tuner in TUNERS]
    wanted += [Starts(load_race(race), CHAIN, 2 if quick else 4, long, keep=True) for race in races]
    results = jobs.each("searches", {one.label: one for one in wanted}, search)
    found = [(one, results[one.label]) for one in wanted]
    page = Article("Random starts")
    page.say(
        f"{count} searches begin at parameters drawn uniformly in logarithms within the bounds, the same in all segments; {budget} "
        "flights, ten re-flights."
    )
    heads = ("race", "tuner", "reach 100 % [%]", "median flights", "least", "most")
    page.table(heads, [_how_many(found, race, tuner) for race in races for tuner in TUNERS])
    for race in races:
        own = [(start, results) for start, results in found if start.race.name == race]
        page.head(race)
        searches, chains = (
            [_trace(one) for start, some in own if (start.tuner, start.keep) == (CHAIN, keep) for one in some] for keep in (False, True)
        )
        _show_traces(jobs, page, race, searches)
        optima = [tuple(map(tuple, one["found"])) for _, results in own for one in results if one["found"]]
        if len(optima) > 1:
            _say_lines(jobs, page, race, optima)
        _show_chains(jobs, page, race, chains)
    return page


def _how_many(found: Sequence[tuple[Starts, Sequence[Mapping[str, Any]]]], race: str, tuner: str) -> list[str]:
    """A row: how many searches got there, and in how many flights."""
    some = next(results for start, results in found if (start.race.name, start.tuner, start.keep) == (race, tuner, False))
    own = [one["flights"] for one in some]
    flights = np.array([np.inf if one is None else one for one in own])
    count = int(np.isfinite(flights).sum())
    low, high = wilson_interval(count, len(flights))
    reached = f"{percent(count / len(flights))} [{percent(low)}, {percent(high)}]"
    return [
        race,
        tuner,
        reached,
        *(f"{value:.0f}" if np.isfinite(value) else "-" for value in (np.median(flights), min(flights), max(flights))),
    ]


def _trace(result: Mapping[str, Any]) -> Floats:
    """Parameters on the way, shape (samples, K)."""
    return np.array(result["trace"])


def _show_traces(jobs: ResumableJobs, page: Article, race: str, traces: list[Floats]) -> None:
    """Parameters over flights."""
    from hotlap.report.reproduction import draw_traces  # noqa: PLC0415  matplotlib takes half a second to load

    path, space = jobs.folder / f"{race}-traces.png", prepare(load_race(race)).space
    detail = "accepted parameters over flights; a dot where the run ended"
    draw_traces(path, f"{race}: {CHAIN} from random starts", detail, space.names, traces, space.low, space.high)
    page.picture(path, "parameters over flights")


def _say_lines(jobs: ResumableJobs, page: Article, race: str, optima: list[tuple[tuple[float, ...], ...]]) -> None:
    """How completion fares between two optima."""
    pairs = list(combinations(range(len(optima)), 2))
    pairs = pairs[:: max(1, len(pairs) // MOST_LINES)]
    mark = hashlib.sha256(repr(optima).encode()).hexdigest()[:8]
    lines = {f"{race}, optima {mark}: {i} to {j}": Line(load_race(race), optima[i], optima[j]) for i, j in pairs}
    lowest = np.array(list(jobs.each("lines", lines, walk).values()))[:, 1:-1].min(axis=1)
    names = prepare(load_race(race)).space.names
    factors = ", ".join(f"{factor:.1f} in {name}" for name, factor in zip(names, _spread(optima), strict=True))
    page.say(
        f"{len(optima)} optima; along {len(lines)} straight lines between two of them, in logarithms, completion stays above 90 % on "
        f"{percent(float((lowest > 0.9).mean()))} %, and falls below 50 % on {percent(float((lowest < 0.5).mean()))} %; the mean lowest is "
        f"{percent(float(lowest.mean()))} %. The optima spread by a factor of {factors} (from the 10th to the 90th percentile)."
    )


def _show_chains(jobs: ResumableJobs, page: Article, race: str, chains: list[Floats]) -> None:
    """What long chains sample, and whether they agree."""
    from hotlap.report.reproduction import draw_marginals  # noqa: PLC0415  matplotlib takes half a second to load

    path, space = jobs.folder / f"{race}-marginals.png", prepare(load_race(race)).space
    samples = [chain[len(chain) // 5 :] for chain in chains]
    detail = f"{len(samples)} chains from random starts, the first fifth left out"
    draw_marginals(path, f"{race}: what {CHAIN} samples", detail, space.names, samples, space.low, space.high)
    page.picture(path, "marginals of long chains")
    ratios = gelman_rubin(np.log(np.array(samples)))
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

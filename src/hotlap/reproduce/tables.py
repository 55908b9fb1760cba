"""The paper's tables, flown again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from hotlap.analysis.comparison import Cell, Run
from hotlap.analysis.comparison_table import summarise
from hotlap.analysis.fastest import RELIABLE, fastest
from hotlap.analysis.learning import built_in_world
from hotlap.analysis.plan_trials import PlanSettings, judge_plan, try_plan
from hotlap.analysis.resumable import ResumableJobs
from hotlap.analysis.statistics import bootstrap_interval, means
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.files.descriptions import load_race
from hotlap.first_guess.guess import first_guess
from hotlap.planning.preparation import prepare
from hotlap.race.race import Race
from hotlap.reference.segmentation import SegmentationRule
from hotlap.report.article import Article, percent
from hotlap.reproduce.published import RACES, TABLE_I, TABLE_II, TABLE_III
from hotlap.tuning.loop import TuningSettings

METHODS: Mapping[str, tuple[str, int]] = {  # of Table I: tuner, budget
    "random search": ("random_search:paper", 200),
    "BO, Matern": ("bayesian:matern", 200),
    "BO, locally periodic": ("bayesian:locally_periodic", 200),
    "BO, rational quadratic": ("bayesian:rational_quadratic", 200),
    "BO, squared exponential": ("bayesian:squared_exponential", 200),
    "BO, periodic": ("bayesian:periodic", 200),
    "PSO": ("particle_swarm:paper", 1000),
    "CMA-ES": ("cma_es:raw", 1000),
    "gradient boosting": ("gradient_boosting:surrogate", 200),
    "AutoTune": ("metropolis_hastings:paper", 200),
    "hotlap": ("gate_gp:published", 200),
}
BEYOND = " `airsim-final-22` asks for more thrust than its vehicle has; Table III has `airsim-final-21` in its place."
SLOW = ("bayesian", "gradient_boosting")  # whose own time exceeds that of the flights
GUESSES = ("default", "learned", "paper")
UNTIED = ("metropolis_hastings:paper", "metropolis_hastings:untied_log", "guided_walk")
TIED = ("metropolis_hastings:tied", "guided_walk:tied")
GAME_OF_DRONES = ("qualifier-20", "final-22")
QUICK = 20  # flights of a run in the short forms
FLOWN = 100  # flights of each controller in Table II
SHOWN = 700_000  # first of them: others than those that plans are chosen by


def compensated(race: Race) -> Race:
    """The same race with a controller that knows its dead time."""
    known = race.control_model.model_copy(update={"delay": race.vehicle.delay})
    return race.model_copy(update={"name": f"{race.name}, latency known", "model": known})


def table1(jobs: ResumableJobs, *, quick: bool) -> Article:
    """Completion of every method on every track."""
    seeds = tuple(range(2 if quick else 20))
    races = [load_race(name) for name in (RACES[:2] if quick else RACES)]
    suites = {
        "default suite": races,
        "airsim suite": [load_race(f"airsim-{race.name}") for race in races],
        "latency known": [compensated(race) for race in races],
    }
    methods = {name: both for name, both in METHODS.items() if not (quick and both[0].startswith(SLOW))}
    cells = {
        (suite, race.name, method): Cell(race, tuner, _settings(budget, quick=quick), seeds)
        for suite, own in suites.items()
        for race in own
        for method, (tuner, budget) in methods.items()
    }
    runs = jobs.compare(list(cells.values()))
    page = Article("Table I: completion")
    page.say(
        "Two tables for each suite. The first: mean completion [%] of the best candidate at the end of a run, with a 95 % interval by "
        "resampling (none where all runs are alike), the paper's in round brackets. The second: the share of runs that confirmed a "
        "controller [%] with Wilson's interval / median search flights until then, a dash where fewer than half of the runs did. "
        f"{len(seeds)} seeds, {_budgets(methods, quick=quick)}, from the authors' default weights; the paper begins at its learned guess."
        f"{'' if quick else BEYOND}"
    )
    for suite, own in suites.items():
        page.head(suite)
        page.table(("completion [%]", *(race.name for race in own)), _table1_rows(own, methods, runs, published=suite != "latency known"))
        page.table(("confirmed [%] / flights", *(race.name for race in own)), _solved_rows(own, methods, runs))
    return page


def _settings(budget: int, *, quick: bool) -> TuningSettings:
    """Of a run; no table shows its validation, so the short form has none."""
    return TuningSettings(budget=QUICK if quick else budget, reliability=0.0, validation=0 if quick else 50)


def _budgets(methods: Mapping[str, tuple[str, int]], *, quick: bool) -> str:
    """How many flights a run may take; the paper's, but in the short form."""
    if quick:
        return f"{QUICK} flights"
    least = min(budget for _, budget in methods.values())
    more = [f"{name} {budget}" for name, (_, budget) in methods.items() if budget > least]
    return f"{least} flights ({', '.join(more)}), as in the paper"


def _table1_rows(races: Sequence[Race], methods: Mapping[str, Any], runs: Sequence[Run], *, published: bool) -> Iterator[list[str]]:
    """Completion beside the paper's."""
    for method, (tuner, _) in methods.items():
        cells = [method]
        for race, value in zip(races, TABLE_I.get(method, ()) or [None] * len(races), strict=False):
            own = np.array([run.completion for run in runs if run.race == race.name and run.tuner.startswith(tuner)])
            shown = f"{percent(float(own.mean()))}{between(bootstrap_interval(own, means))}"
            cells.append(f"{shown} ({value})" if published and value is not None else shown)
        yield cells


def _solved_rows(races: Sequence[Race], methods: Mapping[str, Any], runs: Sequence[Run]) -> Iterator[list[str]]:
    """Runs that confirmed a controller, and median search flights."""
    for method, (tuner, _) in methods.items():
        rows = [
            summarise(race.name, tuner, [run for run in runs if run.race == race.name and run.tuner.startswith(tuner)]) for race in races
        ]
        yield [method, *(f"{percent(row.success_rate)}{between(row.success_interval)} / {median(row.flights_median)}" for row in rows)]


def between(interval: tuple[float, float]) -> str:
    """An interval of a share, with a space before it; nothing where it has no width."""
    low, high = map(percent, interval)
    return "" if low == high else f" [{low}, {high}]"


def median(flights: float) -> str:
    """A median of flights, "-" where fewer than half got there."""
    return f"{flights:.0f}" if np.isfinite(flights) else "-"


def table2(jobs: ResumableJobs, *, quick: bool) -> Article:
    """Lap times on the tracks of Game of Drones, as planned and with the fastest reliable plan."""
    names = ("circle-34",) if quick else (*GAME_OF_DRONES, "airsim-qualifier-20", "airsim-final-21")
    settings = TuningSettings(budget=40 if quick else 300, confirm=10, reliability=RELIABLE, validation=200)
    found: dict[str, tuple[PlanSettings, dict[str, Any]] | None] = {}
    for name in names:
        race = load_race(name)
        do, judge = partial(_each, jobs, name, "plans", try_plan), partial(_each, jobs, name, "winners", judge_plan)
        found[name] = fastest(race, "guided_walk", settings, do, judge, most_rounds=1 if quick else 40)
    page = Article("Table II: Game of Drones")
    page.say(
        "Lap [s], largest and mean speed [m/s]. The teams' and AutoTune's figures are the paper's, flown by the simulator's quadrotor; "
        f"hotlap's are means over {FLOWN} flights with noise, of those that pass every gate, whose share is given. "
        "*Planned as in Table I*: the paper's v_max (airsim's final 21 m/s, as 22 is beyond the vehicle), flown with the learned first "
        "guess, untuned. "
        "*Fastest*: v_max, tolerance and thrust of the plan are searched for the shortest lap that passes every gate in "
        f"{percent(RELIABLE)} % of 200 flights, twice; the figures are of other flights than those that it was chosen by."
    )
    rows = [[team, *_numbers(qualifier), "", *_numbers(final), ""] for team, (qualifier, final) in TABLE_II.items()]
    if not quick:
        for suite, pair in (("default suite", names[:2]), ("airsim", names[2:])):
            plain = [_speeds(load_race(name), None, None) for name in pair]
            fast = [_speeds(load_race(name), *(found[name] or (None, {}))) for name in pair]
            rows += [[f"hotlap, {suite}, planned as in Table I", *plain[0], *plain[1]], [f"hotlap, {suite}, fastest", *fast[0], *fast[1]]]
    page.table(("", "qualifier: lap", "largest", "mean", "passed", "final: lap", "largest", "mean", "passed"), rows)
    page.head("The fastest plans")
    page.table(
        ("race", "plan", "lap [s]", "validated %"),
        [[name, pair[0].key, f"{pair[1]['lap']:.2f}", percent(pair[1]["rate"])] for name, pair in found.items() if pair],
    )
    return page


def _each(jobs: ResumableJobs, name: str, unit: str, work: Any, trials: Mapping[str, Any]) -> dict[str, Any]:
    """Trials of a race."""
    results = jobs.each(unit, {f"{name}: {key}": trial for key, trial in trials.items()}, work)
    return {key: results[f"{name}: {key}"] for key in trials}


def _numbers(values: Sequence[float]) -> list[str]:
    return [f"{value:.2f}" for value in values]


def _speeds(race: Race, plan_settings: PlanSettings | None, result: Mapping[str, Any] | None) -> list[str]:
    """Mean lap, largest and mean speed of flights that pass every gate, and their share: as a search left them, or (None) as guessed."""
    if result is not None and plan_settings is None:
        return ["-"] * 4  # no reliable plan was found
    scenario = prepare(race if plan_settings is None else plan_settings.applied(race))
    values = first_guess(scenario) if result is None else np.array(result["parameters"])
    seeds = flight_seeds(0, Stream.DEMONSTRATION, SHOWN, FLOWN)
    flights = built_in_world().fly(scenario, np.repeat(values[None], FLOWN, axis=0), seeds, log=range(FLOWN))
    whole = [i for i in range(FLOWN) if flights.gates_passed[i] == len(scenario.race.track.counted)]
    if not whole:
        return ["-", "-", "-", "0 %"]
    speeds = [np.linalg.norm(flights.logs[i].states[flights.logs[i].times <= flights.lap_time[i], 7:10], axis=1) for i in whole]
    laps = np.mean([flights.lap_time[i] for i in whole])
    top, mean = np.mean([speed.max() for speed in speeds]), np.mean([speed.mean() for speed in speeds])
    return [f"{laps:.2f}", f"{top:.2f}", f"{mean:.2f}", f"{percent(len(whole) / FLOWN)} %"]


def table3(jobs: ResumableJobs, *, quick: bool) -> Article:
    """With and without first guess, segments, and one step for all of them; with one segment, tied steps are the same thing."""
    seeds = tuple(range(2 if quick else 20))
    settings = _settings(300, quick=quick)
    names = ("circle-34",) if quick else (*RACES, *(f"airsim-{name}" for name in RACES[:-1]), "airsim-final-21")
    variants = [
        (guess, rule, tuner)
        for guess in (GUESSES[:2] if quick else GUESSES)
        for rule, tuners in ((SegmentationRule.PAPER, UNTIED + TIED), (SegmentationRule.NONE, UNTIED))
        for tuner in tuners
    ]
    cells = {
        (name, variant): Cell(load_race(name), variant[2], settings, seeds, segments=variant[1], first_guess=variant[0])
        for name in names
        for variant in variants
    }
    flown = iter(jobs.compare(list(cells.values())))
    runs = {key: [next(flown) for _ in seeds] for key in cells}
    groups = (
        {"circle-34": ["circle-34"]}
        if quick
        else {
            "default suite": list(RACES),
            "qualifier-20": ["qualifier-20"],
            "airsim": list(names[len(RACES) :]),
            "airsim-flip-16": ["airsim-flip-16"],
        }
    )
    whole = "each of the seven races of a suite (airsim with final-21 in place of final-22, which is beyond the vehicle)"
    where = names[0] if quick else whole
    page = Article("Table III: ablation")
    page.say(
        f"Share of runs that confirmed a controller [%] and median search flights, within {settings.budget} flights, with 95 % intervals; "
        f"{len(seeds)} seeds on {where}, for the intervals as if all were drawn independently. The paper, on Qualifier: "
        f"{'; '.join(f'{name} {value} %, {flights} flights' for name, (value, flights) in TABLE_III.items())}."
    )
    page.table(
        ("first guess", "segments", "tuner", *groups),
        [
            [*variant, *(_with_intervals([run for name in group for run in runs[name, variant]]) for group in groups.values())]
            for variant in variants
        ],
    )
    return page


def _with_intervals(runs: Sequence[Run]) -> str:
    row = summarise("", "", runs)
    first, last = (median(end) for end in row.flights_interval)
    return f"{percent(row.success_rate)}{between(row.success_interval)} / {median(row.flights_median)} [{first}, {last}]"

"""Effect of segments on tuning: python benchmarks/segments.py thresholds|rules|segment_switch|transfer [--jobs N] [--out DIR]

All runs begin at the default weights. Resumable: results are kept in DIR; the tables go to standard output.

    thresholds      of the paper's rule: height, look-ahead and least duration; the segments, and flights to 100 %
    rules           each segmentation rule on all races of Table I in both suites
    segment_switch  the parameters of the next segment from when on: by time, by node, by distance
    transfer        parameters tuned on one race flown on the others, copied for each class of segments
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from hotlap import tuners
from hotlap.analysis.resumable import digest_code
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare
from hotlap.race.race import SegmentSwitch
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentationRule, segment
from hotlap.system.journal import Journal
from hotlap.system.process_pool import spread
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune_together
from hotlap.tuning.objective import Objective
from hotlap.worlds.built_in import BuiltIn

TABLE_I = ("circle-20", "circle-34", "drop-20", "flip-16", "spiral-53", "qualifier-20", "final-22")
SOLVABLE = (*TABLE_I, *(f"airsim-{name}" for name in TABLE_I[:-1]), "airsim-final-21")
SEGMENTED = ("guided_walk:segments", "metropolis_hastings:untied_log")
RISES, LOOKS, LEASTS = (0.25, 0.5, 1.0, 2.0, 4.0), (0.5, 1.0, 2.0), (0.5, 1.0, 2.0, 4.0)
LONG = ("qualifier-20", "final-22", "soccer-medium-20")
BUDGET, FLIGHTS = 300, 50


@dataclass(frozen=True)
class Case:
    """Runs of a tuner on one race.

    Attributes:
        race: name of a built-in race.
        tuner: algorithm with preset.
        seeds: number of runs.
        rule: segmentation rule.
        thresholds: of the rule, by name.
        segment_switch: when the parameters of the next segment are used.
        confirm: number of re-flights.
        budget: flights of each run at most.
    """

    race: str
    tuner: str
    seeds: int
    rule: str = SegmentationRule.PAPER
    thresholds: tuple[tuple[str, float], ...] = ()
    segment_switch: str = SegmentSwitch.TIME
    confirm: int = 4
    budget: int = BUDGET

    @property
    def scenario(self) -> Scenario:
        """The race with the segments of the rule."""
        race = load_race(self.race)
        controller = race.controller.model_copy(update={"segment_switch": SegmentSwitch(self.segment_switch)})
        scenario = prepare(race.model_copy(update={"controller": controller}))
        return replace(scenario, segments=segment(scenario.reference, SegmentationRule(self.rule), **dict(self.thresholds)))


def fly(case: Case) -> Iterator[dict[str, Any]]:
    """Search flights of each run, None where no controller was confirmed; tuned parameters, and their validation rates."""
    scenario = scenario_for(case.scenario, tuners.build(case.tuner))
    settings = [
        TuningSettings(budget=case.budget, seed=seed, confirm=case.confirm, reliability=0.0, validation=FLIGHTS)
        for seed in range(case.seeds)
    ]
    runs = [Tuning(tuners.build(case.tuner), scenario, one) for one in settings]
    for _ in tune_together(Objective(scenario, BuiltIn(threads=1)), runs):
        pass
    good = [run for run in runs if run.best is not None and run.best.confirmed]
    yield {
        "segments": len(scenario.segments),
        "search": [run.search_flights if run in good else None for run in runs],
        "held": [run.validation.rate if run.validation else None for run in good],
        "found": [run.best.parameters.tolist() for run in good],
    }


def run_cases(kept: Journal, cases: Sequence[Case], jobs: int) -> dict[Case, dict[str, Any]]:
    """Results of all cases; those that are missing are flown."""
    unique = list(dict.fromkeys(cases))
    missing = [case for case in unique if repr(case) not in kept.done]
    for count, (case, result) in enumerate(spread(fly, missing, jobs), 1):
        kept.add(repr(case), result)
        print(f"{count} of {len(missing)}: {case.race} by {case.tuner}", file=sys.stderr, flush=True)
    return {case: kept.done[repr(case)] for case in unique}


def shown(results: Sequence[Mapping[str, Any]]) -> str:
    """Runs that confirmed a controller [%] / median search flights."""
    counts = [np.inf if count is None else count for result in results for count in result["search"]]
    middle = np.median(counts)
    return f"{100 * np.mean(np.isfinite(counts)):.0f} / {f'{middle:.0f}' if np.isfinite(middle) else '-'}"


def thresholds(kept: Journal, jobs: int) -> Iterator[str]:
    """Two tables for each race: results by number of segments, and by thresholds of the paper's rule."""
    for race in LONG:
        scenario, ways = prepare(race), {}
        for rise, ahead, least in product(RISES, LOOKS, LEASTS):
            chosen = (("rise", rise), ("ahead", ahead), ("least", least))
            cut = segment(scenario.reference, SegmentationRule.PAPER, **dict(chosen))
            ways.setdefault((tuple(cut.starts.tolist()), cut.classes), []).append(chosen)
        cases = [Case(race, tuner, 4, thresholds=same[0]) for same in ways.values() for tuner in SEGMENTED]
        results = run_cases(kept, cases, jobs)
        yield f"\n{race}\n\n| segments | cuts | {' | '.join(SEGMENTED)} |\n|{'---|' * (2 + len(SEGMENTED))}"
        counts = sorted({len(starts) for starts, _ in ways})
        for count in counts:
            own = [same[0] for (starts, _), same in ways.items() if len(starts) == count]
            cells = [shown([results[Case(race, tuner, 4, thresholds=one)] for one in own]) for tuner in SEGMENTED]
            yield f"| {count} | {len(own)} | {' | '.join(cells)} |"
        yield f"\n| height [m] | look-ahead [s] | {' | '.join(f'least {least:g} s' for least in LEASTS)} |\n|{'---|' * (2 + len(LEASTS))}"
        for rise, ahead in product(RISES, LOOKS):
            cells = []
            for least in LEASTS:
                chosen = (("rise", rise), ("ahead", ahead), ("least", least))
                (starts, _), same = next(item for item in ways.items() if chosen in item[1])
                cells.append(f"{len(starts)}: {shown([results[Case(race, SEGMENTED[0], 4, thresholds=same[0])]])}")
            yield f"| {rise:g} | {ahead:g} | {' | '.join(cells)} |"


def rules(kept: Journal, jobs: int) -> Iterator[str]:
    """A table for each tuner: results by race and segmentation rule."""
    named = ("guided_walk:default", *SEGMENTED)
    cases = {(tuner, race, rule): Case(race, tuner, 6, rule) for tuner in named for race in SOLVABLE for rule in SegmentationRule}
    results = run_cases(kept, list(cases.values()), jobs)
    for tuner in named:
        yield f"\n{tuner}\n\n| race | {' | '.join(SegmentationRule)} |\n|{'---|' * (1 + len(SegmentationRule))}"
        for race in SOLVABLE:
            found = [results[cases[tuner, race, rule]] for rule in SegmentationRule]
            cells = [f"{one['segments']}: {shown([one])}" for one in found]
            yield f"| {race} | {' | '.join(cells)} |"
        yield f"| all | {' | '.join(shown([results[cases[tuner, race, rule]] for race in SOLVABLE]) for rule in SegmentationRule)} |"


def segment_switch(kept: Journal, jobs: int) -> Iterator[str]:
    """A table for each tuner: results by race with several segments, and segment switch."""
    several = [race for race in SOLVABLE if not race.rpartition("airsim-")[2].startswith("circle")]
    for tuner in SEGMENTED:
        cases = {(race, way): Case(race, tuner, 8, segment_switch=way) for race in several for way in SegmentSwitch}
        results = run_cases(kept, list(cases.values()), jobs)
        yield f"\n{tuner}\n\n| race | {' | '.join(SegmentSwitch)} |\n|{'---|' * (1 + len(SegmentSwitch))}"
        for race in several:
            yield f"| {race} | {' | '.join(shown([results[cases[race, way]]]) for way in SegmentSwitch)} |"
        yield f"| all | {' | '.join(shown([results[cases[race, way]] for race in several]) for way in SegmentSwitch)} |"


@dataclass(frozen=True)
class Flown:
    """Parameters for each class of segments, tuned on the source and flown on the target race."""

    source: Case
    target: str
    values: tuple[tuple[str, tuple[float, ...]], ...]


def carry(case: Flown) -> Iterator[float]:
    """Share of complete flights; a class that the source does not have gets the median of its classes."""
    scenario = replace(case.source, race=case.target).scenario
    known = {kind: np.array(values) for kind, values in case.values}
    middle = np.exp(np.median(np.log(list(known.values())), axis=0))
    parameters = np.array([known.get(kind, middle) for kind in scenario.segments.segment_classes])
    objective = Objective(scenario, BuiltIn(threads=1))
    scores = objective.fly(np.repeat(parameters[None], 2 * FLIGHTS, axis=0), flight_seeds(0, Stream.DEMONSTRATION, 0, 2 * FLIGHTS))
    yield float((scores.completion == 1).mean())


def by_class(case: Case, found: Sequence[Any]) -> tuple[tuple[str, tuple[float, ...]], ...]:
    """Parameters of each class: medians in logarithms over runs and over the segments of the class."""
    kinds = case.scenario.segments.segment_classes
    rows: dict[str, list[Any]] = {}
    for values in found:
        for kind, row in zip(kinds, values, strict=True):
            rows.setdefault(str(kind), []).append(row)
    return tuple((kind, tuple(np.exp(np.median(np.log(own), axis=0)).tolist())) for kind, own in rows.items())


def transfer(kept: Journal, jobs: int) -> Iterator[str]:
    """A matrix for each rule and suite: complete flights [%], tuned on the race of the row and flown on that of the column."""
    for suite, tuner in product((TABLE_I, tuple(race for race in SOLVABLE if race.startswith("airsim"))), ("guided_walk:segments",)):
        for rule in (SegmentationRule.PAPER, SegmentationRule.NONE):
            sources = [Case(race, tuner, 4, rule, confirm=10, budget=300) for race in suite]
            results = run_cases(kept, sources, jobs)
            flights = {
                (source.race, target): Flown(source, target, by_class(source, results[source]["found"]))
                for source in sources
                if results[source]["found"]
                for target in suite
            }
            missing = [case for case in flights.values() if repr(case) not in kept.done]
            for case, share in spread(carry, missing, jobs):
                kept.add(repr(case), share)
            yield f"\n{rule}, {tuner}\n\n| tuned on | {' | '.join(suite)} | on others |\n|{'---|' * (2 + len(suite))}"
            others = []
            for race in suite:
                if (race, race) not in flights:
                    yield f"| {race} |{' |' * (1 + len(suite))}"
                    continue
                shares = [kept.done[repr(flights[race, target])] for target in suite]
                other = [share for share, target in zip(shares, suite, strict=True) if target != race]
                others += other
                yield f"| {race} | {' | '.join(f'{100 * share:.0f}' for share in shares)} | {100 * np.mean(other):.0f} |"
            yield f"| mean on others |{' |' * len(suite)} {100 * np.mean(others):.0f} |"


def main() -> int:
    """Run one part and print its tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parts = {"thresholds": thresholds, "rules": rules, "segment_switch": segment_switch, "transfer": transfer}
    parser.add_argument("part", choices=parts)
    parser.add_argument("--out", type=Path, default=Path("build/segments"))
    parser.add_argument("--jobs", type=int, default=0)
    options = parser.parse_args()
    with Journal.opened(options.out / options.part, digest_code(Path(__file__))) as kept:
        for line in parts[options.part](kept, options.jobs):
            print(line)
    return 0


if __name__ == "__main__":
    sys.exit(main())

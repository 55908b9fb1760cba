"""How controllers hold under conditions that nobody told them of: python benchmarks/conditions.py [RACE ...]

Each race is tuned once as the controller was before (no observer, no drag along the horizon) by the default tuner, and once with both. Then
the first parameters are flown by both controllers, and the second by the controller that they were tuned with, 200 flights under each
condition, with noise that no search has used. The margin is the thrust that is left under a condition over what the plan needs, a tenth of
the rotors' thrust kept for turning; see `hotlap.feasibility.margins`. Runs are kept in `--out`; the same command continues.

`--from benchmarks/results/conditions.jsonl.gz` flies nothing: it computes the margins of the runs of a file anew and prints the table of
docs/offset_free.md, in seconds where the races were planned before.
"""

from __future__ import annotations

import argparse
import gzip
import json
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hotlap import tuners
from hotlap.analysis.resumable import digest_code
from hotlap.analysis.robustness import fly_conditions
from hotlap.core.errors import PlanningError
from hotlap.core.parameters import Parameters
from hotlap.feasibility.demands import needed_vectors
from hotlap.feasibility.margins import Margin, margin
from hotlap.files.descriptions import load_race, names
from hotlap.files.kinds import Kind
from hotlap.first_guess.guess import first_guess
from hotlap.planning.preparation import prepare
from hotlap.race.conditions import UNCHANGED
from hotlap.race.hold import parse_hold
from hotlap.reference.scenario import Scenario
from hotlap.system.journal import Journal
from hotlap.system.process_pool import spread
from hotlap.system.processors import available
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune_together
from hotlap.tuning.objective import Objective
from hotlap.worlds.built_in import BuiltIn

CONDITIONS = (
    UNCHANGED,
    *parse_hold("mass=+10%, mass=+20%, mass=+30%, thrust=-15%, thrust=-25%, delay=+20ms, wind=2, wind=4, noise=x2"),
)
ENOUGH = 1.07  # margin from which on all must hold
SURE = (1, 2, 4, 7)  # of the conditions: those that must hold where the margin is large enough
FLIGHTS, FIRST_SEED = 200, 3 * 10**12  # flights under each condition; seeds that no search uses
SHOWN = (0, 1, 2, 4, 5, 6, 7, 8, 9)  # of the conditions, in the table of the documentation
VERDICTS = ("below 1", "below 1 for a while alone", "1 or more, reserve below 1.05", "reserve of 1.05 or more")
HOLDS = 0.98  # share of the flights, as good as all
SUITES = ("", "real-", "real-airsim-", "airsim-")
WITHOUT = (6, 9)  # of them, those that leave the margin what it is
KEY = re.compile(r"Case\(race='([^']+)', seed=(\d+)\)")
BEFORE, AFTER, RETUNED = "before", "offset-free", "offset-free, tuned with it"


@dataclass(frozen=True)
class Case:
    """One race.

    Attributes:
        race: its name, or a file.
        seed: of the tunings.
    """

    race: str
    seed: int


def fly(case: Case) -> Iterator[dict[str, Any]]:
    """Tune, and fly under all conditions."""
    world = BuiltIn(threads=1)
    try:
        scenario = prepare(load_race(case.race))
    except PlanningError as error:
        yield {"no_plan": str(error)}
        return
    plain, free = _with(scenario, offset_free=False), _with(scenario, offset_free=True)
    first, second = _tune(plain, world, case.seed), _tune(free, world, case.seed)
    flown = {BEFORE: (plain, first), AFTER: (free, first), RETUNED: (free, second)}
    rule = _with(scenario, offset_free=None).offset_free
    yield {
        "duration": scenario.reference.duration,
        "margins": [one.reserve for one in margins_of(scenario)],
        "on": rule,
        "rows": {name: _fly(*how, world) for name, how in flown.items()},
    }


def margins_of(scenario: Scenario) -> list[Margin]:
    """What is left of the thrust under each condition."""
    race, reference = scenario.race, scenario.reference
    vectors = needed_vectors(race.vehicle, reference)
    return [margin(race, reference, condition, offset_free=True, vectors=vectors) for condition in CONDITIONS]


def margins_anew(case: Case) -> Iterator[dict[str, Any]]:
    """The margins of one race as they are computed now, and what they say."""
    found = margins_of(prepare(load_race(case.race)))
    yield {"margins": [one.reserve for one in found], "verdicts": [verdict_of(one) for one in found]}


def verdict_of(found: Margin) -> str:
    """What a margin says about flights, one of `VERDICTS`."""
    if found.thrust < 1:
        return VERDICTS[1] if found.passing else VERDICTS[0]
    return VERDICTS[3] if found.enough else VERDICTS[2]


def read(path: Path, jobs: int) -> dict[Case, dict[str, Any]]:
    """Runs of a file, with margins computed anew."""
    with gzip.open(path, "rt", encoding="utf-8") as lines:
        records = [json.loads(line) for line in lines]
    found = {KEY.fullmatch(one["key"]): one["value"] for one in records}
    results = {Case(key[1], int(key[2])): value for key, value in found.items() if key and "rows" in value}
    anew = dict(spread(margins_anew, list(results), jobs))
    return {case: {**value, **anew[case]} for case, value in results.items()}


def documented(results: Mapping[Case, Mapping[str, Any]]) -> Iterator[str]:
    """Lines of the table of docs/offset_free.md, suite by suite: each cell is before / tuned with it."""
    yield "| race | as tuned | mass +10 % | mass +20 % | thrust -15 % | thrust -25 % | +20 ms | wind 2 | wind 4 | noise x2 | mean error m |"
    yield "|---" * 11 + "|"
    for case in sorted(results, key=lambda one: (SUITES.index(suite_of(one.race)), one.race)):
        found = results[case]
        rates = [found["rows"][name]["rates"] for name in (BEFORE, RETUNED)]
        cells = ["/".join(f"{100 * rate[i]:.0f}" for rate in rates) for i in SHOWN]
        told = [f"{cell} ({found['margins'][i]:.2f})" if i not in WITHOUT else cell for i, cell in zip(SHOWN, cells, strict=True)]
        errors = "/".join(f"{found['rows'][name]['errors'][0]:.2f}" for name in (BEFORE, RETUNED))
        yield f"| {case.race}{'' if found['on'] else ' (off)'} | {' | '.join(told)} | {errors} |"


def judged(results: Mapping[Case, Mapping[str, Any]]) -> Iterator[str]:
    """Lines of the table of docs/failures.md: what margins say, and what flights do, of all that leaves the dead time as it is."""
    yield "| margin | cases | flights that pass every gate |"
    yield "|---|---|---|"
    cells = [
        (found["verdicts"][i], found["rows"][RETUNED]["rates"][i])
        for found in results.values()
        for i in range(len(CONDITIONS))
        if i not in WITHOUT and found["rows"][RETUNED]["rates"][0] >= HOLDS
    ]
    for verdict in VERDICTS:
        rates = np.array([rate for told, rate in cells if told == verdict])
        shares = f"all in {(rates >= HOLDS).sum()}, none in {(rates == 0).sum()}, {rates.mean():.0%} in the mean" if len(rates) else "-"
        yield f"| {verdict} | {len(rates)} | {shares} |"


def suite_of(race: str) -> str:
    """The beginning of its name that the races of a suite share."""
    return max((suite for suite in SUITES if race.startswith(suite)), key=len)


def _with(scenario: Scenario, *, offset_free: bool | None) -> Scenario:
    """The same scenario with the observer and drag along the horizon, or without; None: as for a race of one's own."""
    settings = scenario.race.controller.model_copy(update={"offset_free": offset_free, "reference_drag": offset_free is not False})
    return replace(scenario, race=scenario.race.model_copy(update={"controller": settings}))


def _tune(scenario: Scenario, world: BuiltIn, seed: int) -> Parameters:
    """Parameters of the default tuner, from the learned first guess."""
    tuner = tuners.build(tuners.DEFAULT)
    judged = scenario_for(scenario, tuner)
    run = Tuning(tuner, judged, TuningSettings(seed=seed, confirm=10), first_guess(judged))
    for _ in tune_together(Objective(judged, world), [run]):
        pass
    assert run.best is not None
    return run.best.parameters


def _fly(scenario: Scenario, parameters: Parameters, world: BuiltIn) -> dict[str, list[float]]:
    """Share of complete flights and mean error [m] under each condition."""
    seeds = FIRST_SEED + np.arange(FLIGHTS, dtype=np.int64)
    found = fly_conditions(scenario, world, parameters, seeds, CONDITIONS)
    return {
        "rates": [float(found[condition].complete.mean()) for condition in CONDITIONS],
        "errors": [float(found[condition].mean_error.mean()) for condition in CONDITIONS],
    }


def table(results: Mapping[Case, Mapping[str, Any]]) -> Iterator[str]:
    """Lines of the table: each cell is before / offset-free / tuned with it, in percent; bold where the margin promises it."""
    yield "| race | plan s | " + " | ".join(condition.name for condition in CONDITIONS) + " | mean error m |"
    yield "|---" * (len(CONDITIONS) + 3) + "|"
    for case, found in results.items():
        if "no_plan" in found:
            yield f"| {Path(case.race).stem} | {found['no_plan']} |"
            continue
        rows, cells = found["rows"], []
        for i, room in enumerate(found["margins"]):
            shares = "/".join(f"{100 * row['rates'][i]:.0f}" for row in rows.values())
            cells.append(f"{shares} ({room:.2f})")
        errors = "/".join(f"{row['errors'][0]:.2f}" for row in rows.values())
        name = f"{Path(case.race).stem}{'' if found['on'] else ' (off)'}"
        yield f"| {name} | {found['duration']:.2f} | {' | '.join(cells)} | {errors} |"


def summary(results: Mapping[Case, Mapping[str, Any]]) -> Iterator[str]:
    """What the promise is worth: of the cells with enough margin, how many hold; and what flights without a condition lose."""
    sure = [
        (case.race, CONDITIONS[i].name, found["margins"][i], found["rows"][RETUNED]["rates"][i])
        for case, found in results.items()
        if "rows" in found
        for i in SURE
        if found["margins"][i] >= ENOUGH
    ]
    good = sum(rate >= HOLDS for *_, rate in sure)
    yield f"with a margin of {ENOUGH} or more: {good} of {len(sure)} hold in at least 98 % of {FLIGHTS} flights; the others:"
    yield from (f"  {race}, {name}: {100 * rate:.1f} % (margin {room:.2f})" for race, name, room, rate in sure if rate < HOLDS)
    yield "flights under these conditions that are lost in part, with a smaller margin:"
    for case, found in results.items():
        for i in SURE if found.get("on") else ():
            rate, room = found["rows"][RETUNED]["rates"][i], found["margins"][i]
            if rate < HOLDS and room < ENOUGH:
                yield f"  {case.race}, {CONDITIONS[i].name}: {100 * rate:.1f} % (margin {room:.2f})"
    yield "flights without a condition that lose more than a point:"
    for case, found in results.items():
        if "rows" in found:
            before, after = found["rows"][BEFORE]["rates"][0], found["rows"][RETUNED]["rates"][0]
            if after < before - 0.01:
                yield f"  {case.race}: {100 * before:.1f} to {100 * after:.1f} %{'' if found['on'] else ' (off there by default)'}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly what is missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("races", nargs="*", metavar="RACE", default=names(Kind.RACE))
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--jobs", type=int, default=available())
    parser.add_argument(
        "--from", type=Path, dest="source", metavar="FILE", help="print the table of these runs, with margins computed anew"
    )
    parser.add_argument("--out", type=Path, default=Path("build/conditions"))
    options = parser.parse_args(arguments)
    if options.source is not None:
        results = read(options.source, options.jobs)
        print("\n".join([*documented(results), "", *judged(results), "", *summary(results)]))
        return
    cases = [Case(race, options.seed) for race in options.races]
    with Journal.opened(options.out, digest_code(Path(__file__))) as kept:
        missing = [case for case in cases if repr(case) not in kept.done]
        for count, (case, found) in enumerate(spread(fly, missing, options.jobs), 1):
            kept.add(repr(case), found)
            print(f"{count} of {len(missing)}: {case.race}", file=sys.stderr, flush=True)
        results = {case: kept.done[repr(case)] for case in cases}
    print("\n".join([*table(results), "", *summary(results)]))


if __name__ == "__main__":
    main()

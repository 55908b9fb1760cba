"""The tables of docs/tuners.md from the runs of a comparison: python benchmarks/comparison_tables.py build/comparison/main"""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from hotlap.analysis.comparison import Run, RunJournal
from hotlap.analysis.comparison_table import Row, overall, summarise
from hotlap.tuners.renamed import current_name

RACES = ("circle-20", "circle-34", "drop-20", "flip-16", "spiral-53", "qualifier-20", "final-22")  # of Table I
TABLE_I: Mapping[str, tuple[int, ...]] = {  # the paper's completion [%] on them
    "random_search:paper": (100, 65, 40, 80, 0, 50, 10),
    "bayesian:matern": (100, 80, 100, 80, 10, 75, 40),
    "bayesian:locally_periodic": (100, 65, 50, 80, 0, 60, 40),
    "bayesian:rational_quadratic": (100, 60, 50, 80, 0, 60, 30),
    "bayesian:squared_exponential": (100, 60, 50, 80, 10, 60, 30),
    "bayesian:periodic": (100, 30, 40, 80, 0, 30, 25),
    "particle_swarm:paper": (100, 100, 100, 100, 10, 75, 40),
    "cma_es:raw": (100, 100, 100, 100, 10, 100, 100),
    "gradient_boosting:surrogate": (100, 65, 50, 80, 10, 65, 40),
    "metropolis_hastings:paper": (100, 100, 100, 100, 100, 100, 100),
}


def name_of_today(name: str) -> str:
    """The name that a tuner of recorded runs has today: what was `gatewise` then is the published form of `gate_gp`."""
    return "gate_gp:published" if name == "gatewise:default" else current_name(name)


def solved(row: Row) -> str:
    """Runs that confirmed a controller [%] / median search flights, such as 95 / 12."""
    middle = f"{row.flights_median:.0f}" if math.isfinite(row.flights_median) else "-"
    return f"{100 * row.success_rate:.0f} / {middle}"


def matrix(runs: Sequence[Run], races: Sequence[str]) -> str:
    """Table of results: one row for each tuner, the best first, one column for each race."""
    chosen = [run for run in runs if run.race in races]
    lines = [f"| tuner | {' | '.join(races)} | all | validated % | ms/flight |", f"|---{'|---' * (len(races) + 3)}|"]
    for total in overall(chosen):
        mine = [run for run in chosen if run.tuner == total.tuner]
        cells = [[run for run in mine if run.race == race] for race in races]
        shown = [solved(summarise(race, total.tuner, cell)) if cell else "" for race, cell in zip(races, cells, strict=True)]
        lines.append(
            f"| {total.tuner} | {' | '.join(shown)} | {solved(total)} | {100 * total.validated_rate:.0f} | {1e3 * total.tuner_time:.2g} |"
        )
    return "\n".join(lines)


def beside_the_paper(runs: Sequence[Run], races: Sequence[str]) -> str:
    """Table of the mean completion [%] of the best candidate at the end of a run, beside the paper's, for each race."""
    lines = [f"| tuner | {' | '.join(races)} |", f"|---{'|---' * len(races)}|"]
    for tuner, published in TABLE_I.items():
        cells = []
        for race, value in zip(races, published, strict=True):
            mine = [run.completion for run in runs if run.race == race and run.tuner == tuner]
            cells.append(f"{100 * np.mean(mine):.0f} ({value})" if mine else f"({value})")
        lines.append(f"| {tuner} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _place(race: str) -> int:
    """Position of a race in Table I; other races come after it, in the order in which they were flown."""
    plain = race.removeprefix("airsim-")
    return RACES.index(plain) if plain in RACES else len(RACES)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    read = RunJournal(parser.parse_args().folder).done
    done = {key: replace(run, tuner=name_of_today(run.tuner)) for key, run in read.items()}  # recorded under the names of then
    latest = {(run.race, run.tuner): key for (key, _), run in done.items()}  # what was flown with other settings is out of date
    runs = [run for (key, _), run in done.items() if latest[run.race, run.tuner] == key]
    names = sorted(dict.fromkeys(run.race for run in runs), key=_place)
    suites = [[name for name in names if not name.startswith("airsim")], [name for name in names if name.startswith("airsim")]]
    for races in filter(None, suites):
        print(matrix(runs, races), end="\n\n")
        if tuple(name.removeprefix("airsim-") for name in races) == RACES:
            print(beside_the_paper(runs, races), end="\n\n")


if __name__ == "__main__":
    main()

"""AutoTune against human experts on Qualifier: completion over the first 25 flights (a figure of the paper)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap import tuners
from hotlap.analysis.learning import built_in_world
from hotlap.analysis.resumable import ResumableJobs
from hotlap.files.descriptions import load_race
from hotlap.first_guess.guess import first_guess
from hotlap.first_guess.training_set import shipped
from hotlap.planning.preparation import prepare
from hotlap.race.race import Race
from hotlap.report.article import Article
from hotlap.reproduce.published import AUTOTUNE_CURVE, EXPERTS_BAND, EXPERTS_CURVE
from hotlap.tuning.goal import Goal, Quantity
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune_together
from hotlap.tuning.objective import Objective

Floats = NDArray[np.float64]

FLIGHTS = len(AUTOTUNE_CURVE)
RUNS = {
    "the paper's sampler, default weights": ("metropolis_hastings:paper", "default"),
    "hotlap, default weights": ("gate_gp:published", "default"),
    "the paper's sampler, the paper's first guess": ("metropolis_hastings:paper", "paper"),
    "hotlap, learned first guess": ("gate_gp:published", "learned"),
}


@dataclass(frozen=True)
class Watched:
    """Runs of a tuner that go on for so many flights, whatever they find; `training` is what the guess is learnt from."""

    race: Race
    tuner: str
    guess: str
    seeds: int
    training: str


def watch(wanted: Watched) -> Iterator[list[list[float]]]:
    """Completion of each flight, run by run."""
    scenario = scenario_for(prepare(wanted.race), tuners.build(wanted.tuner))
    settings = TuningSettings(goal=Goal(Quantity.NONE, 0.0), budget=FLIGHTS, batch=1, validation=0)
    guess = first_guess(scenario, wanted.guess)
    runs = [
        Tuning(tuners.build(wanted.tuner), scenario, TuningSettings(**{**vars(settings), "seed": seed}), guess)
        for seed in range(wanted.seeds)
    ]
    flown: list[list[float]] = [[] for _ in runs]
    for i, batch in tune_together(Objective(scenario, built_in_world()), runs):
        flown[i] += batch.ledger.completion.tolist()
    yield flown


def experts(jobs: ResumableJobs, *, quick: bool) -> Article:
    """Completion of the best controller so far, over ours and the published curves."""
    from hotlap.report.reproduction import draw_curves  # noqa: PLC0415  matplotlib takes half a second to load

    race, seeds = (load_race("circle-34"), 3) if quick else (load_race("qualifier-20"), 20)
    known = shipped().fingerprint
    wanted = {f"{race.name}: {name}, {seeds} seeds": Watched(race, tuner, guess, seeds, known) for name, (tuner, guess) in RUNS.items()}
    found = jobs.each("curves", wanted, watch)
    curves = {name: _band(np.maximum.accumulate(np.array(found[key]), axis=1)) for key, name in zip(wanted, RUNS, strict=True)}
    published, people, band = (np.array(values, dtype=np.float64) for values in (AUTOTUNE_CURVE, EXPERTS_CURVE, EXPERTS_BAND))
    curves["AutoTune (published)"] = (published, published, published)
    curves["four experts (published)"] = (people, people - band, np.minimum(people + band, 100))
    page = Article("AutoTune against human experts")
    page.say(
        f"Completion [%] on {race.name} of the best flight so far, mean of {seeds} runs with one standard deviation; the published curves "
        "show the flights themselves, AutoTune's of one run, the experts' of four people. The simulators differ."
    )
    path = jobs.folder / "experts.png"
    draw_curves(path, f"tuning {race.name}", "best completion so far; published: of each flight", curves, "completion [%]")
    page.picture(path, "completion over flights")
    at = (1, 5, 10, 15, 20, 25)
    page.table(
        ("", *(f"after {flight}" for flight in at)),
        [[name, *(f"{middle[flight - 1]:.0f}" for flight in at)] for name, (middle, _, _) in curves.items()],
    )
    return page


def _band(shares: Floats) -> tuple[Floats, Floats, Floats]:
    """Mean and one standard deviation to both sides, in per cent; shares of shape (runs, flights)."""
    mean, deviation = 100 * shares.mean(axis=0), 100 * shares.std(axis=0)
    return mean, np.maximum(mean - deviation, 0), np.minimum(mean + deviation, 100)

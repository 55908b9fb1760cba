"""Flown: parameters flown many times with fresh noise, and how the flights ended."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hotlap import worlds
from hotlap.analysis.diagnosis import Diagnosis, diagnose, diagnose_logs, telling
from hotlap.analysis.remedies import Failures, failures_of, what_to_try
from hotlap.analysis.robustness import HELD, Robustness, check_robustness
from hotlap.api.asked import Asked
from hotlap.api.held import all_held, dump_robustness, read_hold
from hotlap.api.inputs import as_path, check_range, check_source, check_target
from hotlap.api.outcome import Outcome
from hotlap.api.scenarios import check_guess, fitting, load, make_ready, make_scenario, planned_as, read_guess, read_parameters
from hotlap.api.slow_flights import flying
from hotlap.api.spreading import simulators_on
from hotlap.api.wording import percent, share
from hotlap.core.counts import count
from hotlap.core.parameters import Parameters
from hotlap.core.records import Cause, End, Flights, Log, Scores, columns_of
from hotlap.core.seeds import LARGEST_RUN_SEED, Stream, flight_seeds
from hotlap.core.success_rate import Validation
from hotlap.files.descriptions import load_parameters
from hotlap.race.endings import in_words
from hotlap.reference.scenario import Scenario
from hotlap.system.engine import Engine
from hotlap.system.regular_files import is_there
from hotlap.system.text_files import replace
from hotlap.tuning.goal import Goal
from hotlap.tuning.objective import Objective
from hotlap.worlds.world import World

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_FLIGHTS = 100_000


COLUMNS = columns_of(4)


@dataclass(frozen=True, repr=False)
class FlightsResult(Outcome):
    """Flights of the same parameters, each with noise of its own.

    Attributes:
        scenario: what was flown.
        world: where.
        parameters: that were flown, shape (S, K).
        flights: what each flight did; the first is recorded in full.
        scores: what each flight was worth.
        log: the file of the first flight; None where none was asked for.
        robustness: how many passed every gate under the conditions that were asked for, as tuned first; empty where nobody asked.
        causes: why flights fail, the likeliest first; empty where enough of them pass every gate.
    """

    scenario: Scenario
    world: str
    parameters: Parameters
    flights: Flights
    scores: Scores
    log: Path | None = None
    robustness: tuple[Robustness, ...] = ()
    causes: tuple[Diagnosis, ...] = ()

    @property
    def complete(self) -> Validation:
        """How many flights passed every gate, with the interval of that share."""
        return Validation(len(self.scores), int(self.scores.complete.sum()))

    @property
    def holds(self) -> bool | None:
        """Whether the parameters hold under every condition that was asked for; None where nobody asked."""
        return all_held(self.robustness)

    @property
    def failures(self) -> Failures:
        """Why flights fail, by the conditions under which they do."""
        return failures_of(self.robustness, self.causes)

    @property
    def advice(self) -> tuple[str, ...]:
        """What to try where flights fail, each thing once."""
        return what_to_try(self.failures)

    def facts(self) -> dict[str, str]:
        """How many passed every gate, lap times, errors, and where the others ended."""
        scores = self.scores
        laps = scores.lap_time[scores.complete]
        return {
            "race": f"{self.scenario.race.name}: {count(len(scores), 'flight')}",
            "all gates in": share(self.complete),
            "completion": f"{percent(float(scores.completion.mean()))} of the gates, on average",
            "lap time": f"{laps.mean():.2f} s on average, {laps.min():.2f} to {laps.max():.2f} s" if len(laps) else "-",
            "mean error": f"{scores.mean_error.mean():.2f} m from the reference",
            "largest error": f"{scores.max_error.max():.2f} m",
        }

    def ends(self) -> Iterator[str]:
        """Where flights ended that did not finish, gate by gate, in words."""
        flights, ends = self.flights, Counter(self._endings())
        rows = zip(flights.end.tolist(), flights.gates_passed.tolist(), self._endings(), strict=True)
        for text in dict.fromkeys(text for end, _, text in sorted(rows) if End(end) is not End.FINISHED):
            yield f"{ends[text]} {text}"

    def commonest_end(self) -> str:
        """How most of the flights that did not finish ended: "12 of 50 flights missed gate 3"; "" where all did."""
        unfinished = np.array(self._endings())[self.flights.end != End.FINISHED].tolist()
        if not unfinished:
            return ""
        (words, number), *_ = Counter(unfinished).most_common(1)
        return f"{number} of {count(len(self.flights), 'flight')} {words}"

    def _endings(self) -> list[str]:
        """How each flight ended, in words."""
        flights, race = self.flights, self.scenario.race
        columns = (flights.end.tolist(), flights.gates_passed.tolist(), flights.cause.tolist(), flights.cause_index.tolist())
        return [in_words(race, End(end), passed, Cause(cause), index) for end, passed, cause, index in zip(*columns, strict=True)]

    def rows(self) -> list[dict[str, Any]]:
        """A row for each flight, in the keys of `hotlap fly --json`; None where there is nothing to say."""
        scores = self.scores
        columns = {
            "seed": self.flights.seeds.tolist(),
            "completion": scores.completion.tolist(),
            "lap_time": scores.lap_time.tolist(),
            "cost": scores.cost.tolist(),
            "end": [End(end).name.lower() for end in self.flights.end.tolist()],
            "ending": self._endings(),
            "cause": [Cause(cause).name.lower() if cause else None for cause in self.flights.cause.tolist()],
            "failed_segment": [None if segment < 0 else segment for segment in scores.failed_segment.tolist()],
            "mean_error": scores.mean_error.tolist(),
            "max_error": scores.max_error.tolist(),
        }
        return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]

    def to_dict(self) -> dict[str, Any]:
        """The keys of `hotlap fly --json`."""
        about = {"race": self.scenario.race.name, "world": self.world, "notes": list(self.scenario.notes)}
        about |= {"causes": [cause.dump() for cause in self.causes], "advice": list(self.advice)}
        return {**about, "robustness": [dump_robustness(one) for one in self.robustness], "holds": self.holds, "flights": self.rows()}

    def plot(self) -> Figure:
        """The first flight over the reference, from above and from the side, and where the others failed."""
        from hotlap.report.scene import repeat, stage, trace  # noqa: PLC0415  matplotlib, only where there is something to draw
        from hotlap.report.track_view import track  # noqa: PLC0415

        label = "flown"
        first, all_of_them = trace(self.scenario, self.flights, 0, label), repeat(self.scenario.race, self.flights, slice(None), label)
        return track(stage(self.scenario, (first,), (all_of_them,)))


def carry_out(asked: Asked) -> FlightsResult:
    """Check what was asked for, the quick things first; plan, and fly."""
    with simulators_on(asked) as engine:
        return _carry_out(asked, engine)


def _carry_out(asked: Asked, engine: Engine | None) -> FlightsResult:
    """The same, with simulators on the workers of an engine; None: here."""
    check_range("flights", asked.flights, 1, MOST_FLIGHTS)
    check_range("seed", asked.seed, 0, LARGEST_RUN_SEED)
    log = as_path(asked.log)
    check_source(as_path(asked.reference))
    check_target(log)
    world, race = worlds.build(asked.on, asked.instances, engine), load(asked.race, asked.controller)
    if isinstance(asked.parameters, str | Path) and is_there(Path(asked.parameters)) and Path(asked.parameters).is_file():
        load_parameters(asked.parameters)
    check_guess(str(asked.first_guess))
    race = planned_as(race, asked.first_guess if asked.parameters is None else asked.parameters) if asked.reference is None else race
    conditions = read_hold(asked.hold, race, world)
    scenario = make_scenario(race, asked)
    parameters = _parameters(asked, scenario)
    make_ready(world, scenario, asked.progress)
    seeds = flight_seeds(asked.seed, Stream.DEMONSTRATION, 0, asked.flights)
    words = f"flying {race.name} {asked.flights} times"
    with flying(world, asked.flights, asked.progress, words):
        repeated = np.repeat(parameters[None], asked.flights, axis=0)
        flights, scores = Objective(scenario, world).fly_recorded(repeated, seeds, log=(0,))
        known = (asked.seed, asked.flights, scores, conditions, ())
        robustness = check_robustness(scenario, world, Goal(), parameters, *known, explained=True) if conditions else ()
        causes = () if scores.complete.mean() >= HELD else _why(scenario, world, parameters, flights, scores)
    if log is not None:
        write_log(log, flights.logs[0])
    return FlightsResult(scenario, world.name, parameters, flights, scores, log, robustness, causes)


def _why(scenario: Scenario, world: World, parameters: Parameters, flights: Flights, scores: Scores) -> tuple[Diagnosis, ...]:
    """Why flights fail: by further flights where those cost nothing, else by the log of the first."""
    if world.takes_vehicle_parameters:
        seeds, before = telling(flights.seeds, ~scores.complete), float(scores.complete.mean())
        return diagnose(scenario, world, parameters, seeds, before=before)
    return diagnose_logs(scenario, flights, ~scores.complete & (flights.cause != Cause.LOST))


def _parameters(asked: Asked, scenario: Scenario) -> Parameters:
    """What is flown, shape (S, K)."""
    given = asked.parameters
    if given is None:
        return read_guess(str(asked.first_guess), scenario, asked.progress)
    if isinstance(given, str | Path):
        return read_parameters(Path(given), scenario, asked.progress)
    return fitting(given, scenario)


def write_log(path: Path, log: Log) -> None:
    """One flight as CSV: time, state, rotor thrusts, command and the controller's estimates of each step; NaN where a world logs none."""
    lines = [",".join(columns_of(log.rotor_thrusts.shape[1])), *(",".join(map(repr, row)) for row in log.table.tolist())]
    replace(path, "\n".join(lines) + "\n")

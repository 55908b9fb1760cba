"""Tuned: the main job: tune, confirm, validate, save, and write a page about it."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hotlap import tuners, worlds
from hotlap.api.asked import Asked, command_line
from hotlap.api.beginning import begin, begun_with, describe_beginning
from hotlap.api.first_flights import say_doom
from hotlap.api.flying import fly
from hotlap.api.held import all_held, dump_robustness, read_hold
from hotlap.api.inputs import as_path, check_source
from hotlap.api.outcome import Outcome
from hotlap.api.scenarios import check_guess, load, make_ready, make_scenario
from hotlap.api.wording import percent, seconds, share
from hotlap.core.counts import count
from hotlap.core.errors import HotlapError, InputError, StudyError
from hotlap.core.parameters import Parameters
from hotlap.core.seeds import Stream
from hotlap.core.success_rate import Validation
from hotlap.core.version import __version__
from hotlap.feasibility.demands import advice
from hotlap.feasibility.race import loose_judge
from hotlap.files.descriptions import PARAMETERS_FILE, save_parameters
from hotlap.files.parameters_file import Remark, SavedParameters
from hotlap.first_guess.names import LEARNED
from hotlap.reference.scenario import Scenario
from hotlap.study.configuration import Configuration
from hotlap.study.result import Result
from hotlap.study.snapshot import read_snapshot
from hotlap.study.study import Study, new_folder
from hotlap.tuning.goal import Goal, Quantity, parse_goal
from hotlap.tuning.goal_forms import LAP_TIME
from hotlap.tuning.loop import TuningSettings, scenario_for
from hotlap.tuning.objective import Objective
from hotlap.worlds.built_in import BuiltIn
from hotlap.worlds.world import World

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hotlap.analysis.robustness import Robustness

FASTEST = "race.toml"  # written by the search for the fastest plan
NUMBERS = ("budget", "seed", "confirm", "validation", "reliability", "batch", "randomise", "samples")


@dataclass(frozen=True, repr=False)
class TuningResult(Outcome):
    """How a tuning ended, and where everything lies.

    Attributes:
        scenario: race, reference and segments that were flown.
        result: flights, best parameters and their validation.
        world: where the flights took place.
        first_guess: what the search began with, as it was asked for; else the better of two guesses.
        folder: of the study: every flight, the parameters, the page.
        parameters: the file of the parameters.
        report: the page; None where it could not be written.
        robustness: how the parameters fare under other conditions; empty where that was not flown.
        again: the command line that flies the parameters; "" where the race has no name.
        wall_time: [s] that one waited for it, planning, compiling and the report included.
        advice: where the goal was not confirmed with a reference that was read: what of it no weights can make up for.
    """

    scenario: Scenario
    result: Result
    world: str
    first_guess: str
    folder: Path
    parameters: Path
    report: Path | None
    robustness: tuple[Robustness, ...]
    again: str
    wall_time: float
    advice: tuple[str, ...] = ()

    @property
    def confirmed(self) -> bool:
        """Whether the best parameters reached the goal in all re-flights, and held in the validation."""
        return self.result.best.confirmed

    @property
    def validation(self) -> Validation | None:
        """How often the best parameters met the goal with fresh noise; None where that was not flown."""
        return self.result.validation

    @property
    def holds(self) -> bool | None:
        """Whether the best parameters hold under every condition that was asked for; None where nobody asked."""
        return all_held(self.robustness)

    @property
    def values(self) -> Parameters:
        """The best parameters, shape (S, K), in the order of `scenario.space.names`."""
        return self.result.best.parameters

    @property
    def verdict(self) -> str:
        """How it ended, in a few words."""
        result = self.result
        if result.goal == Quantity.NONE:
            return f"budget of {count(result.flights, 'flight')} spent, no goal was set"
        if self.confirmed:
            return f"{result.goal} confirmed"
        return f"{result.goal} NOT confirmed in {count(result.flights, 'flight')}; the best so far is kept"

    def facts(self) -> dict[str, str]:
        """Verdict, flights, lap time, validation and paths."""
        result = self.result
        return {
            "race": f"{result.race}: {self.verdict}",
            "search flights": f"{result.search_flights} search flights, {result.flights} with re-flights",
            "lap time": f"lap {seconds(result.best.lap_time)}",
            "completion": f"{percent(result.best.completion)} of the gates",
            "holds in": "" if self.validation is None else share(self.validation),
            "study": str(self.folder),
            "report": str(self.report or ""),
        }

    def rows(self) -> list[dict[str, Any]]:
        """A row for each flight of the study: search and confirmation in the order flown, then the validations."""
        with Study.read(self.folder) as study:
            ledger = study.flights()
        columns = {
            "number": ledger.numbers.tolist(),
            "stream": [Stream(stream).name.lower() for stream in ledger.streams.tolist()],
            "seed": ledger.seeds.tolist(),
            "completion": ledger.completion.tolist(),
            "cost": ledger.cost.tolist(),
            "lap_time": ledger.lap_time.tolist(),
            "mean_error": ledger.mean_error.tolist(),
            "max_error": ledger.max_error.tolist(),
            "accepted": ledger.accepted.tolist(),
        }
        return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]

    def to_dict(self) -> dict[str, Any]:
        """The keys of `hotlap tune --json`."""
        paths = {"study": str(self.folder), "parameters": str(self.parameters), "report": None if self.report is None else str(self.report)}
        robustness = [dump_robustness(one) for one in self.robustness]
        about = {"world": self.world, "first_guess": self.first_guess, "robustness": robustness, "holds": self.holds}
        said = {"notes": list(self.scenario.notes), "advice": list(self.advice)}
        return {**self.result.dump(), "wall_time": self.wall_time, **about, **said, **paths}

    def plot(self) -> Figure:
        """Completion and cost over the flights of the search."""
        from hotlap.report.pictures import draw_convergence  # noqa: PLC0415  matplotlib, only where there is something to draw

        with Study.read(self.folder) as study:
            return draw_convergence(read_snapshot(study))


def carry_out(asked: Asked) -> TuningResult:
    """Tune from wherever the study stands, and keep what came of it."""
    begun = time.perf_counter()
    world, configuration = _configure(asked)
    folder = as_path(asked.out) or new_folder(configuration.scenario.race.name)
    with (
        asked.remarked("go on", out=folder),
        Study.open(folder, configuration, asked.command(out=None), asked.hold) as study,
    ):
        before = study.wall_time
        result = _tune(study, world, asked)
        file = folder / PARAMETERS_FILE
        save_parameters(file, _saved(study, result))
        robustness, report = _report(study, world, asked)
        guess = begun_with(study.configuration, study.flights())
    waited, again = before + time.perf_counter() - begun, _again(asked, folder)
    scenario, told = configuration.scenario, asked.reference is not None and not result.best.confirmed and result.goal != Quantity.NONE
    hints = advice(scenario.race, scenario.reference) if told else ()
    return TuningResult(scenario, result, world.name, guess, folder, file, report, robustness, again, waited, hints)


def _configure(asked: Asked) -> tuple[World, Configuration]:
    """Check everything that was asked for, the quick things first, and plan."""
    settings = TuningSettings(goal=_goal(asked.goal), **{name: getattr(asked, name) for name in NUMBERS})
    tuner, world = tuners.build(asked.tuner), worlds.build(asked.on)
    if asked.randomise and not world.takes_vehicle_parameters:
        raise InputError("", "randomise", f"{world.name} flies the vehicle that it has")
    check_source(as_path(asked.reference))
    check_guess(str(asked.first_guess or LEARNED))
    _check_folder(as_path(asked.out))
    race = load(asked.race, asked.controller)
    read_hold(asked.hold, race, world)
    with asked.remarked("begin again"):
        scenario = scenario_for(make_scenario(race, asked), tuner)
    loose = loose_judge(scenario.race) if asked.reference is None else ""
    if loose:
        asked.progress.note(f"note: {loose}")
    name, first, rival = begin(asked, scenario)
    kept = {"first_guess_name": name, "rival": rival}
    return world, Configuration(scenario, world.name, settings.goal.metric, tuner.name, settings, first, **kept)


def _goal(text: str) -> Goal:
    """What is to be reached; the fastest plan is looked for by another program."""
    if text.strip() == LAP_TIME:
        raise InputError("", "goal", f"{LAP_TIME} is of the command line: hotlap tune RACE --goal {LAP_TIME}")
    return parse_goal(text)


def _check_folder(folder: Path | None) -> None:
    """Refuse what can be no folder of this study."""
    if folder is not None and folder.exists() and not folder.is_dir():
        raise StudyError(str(folder), "", "is a file, not the folder of a study")
    if folder is not None and (folder / FASTEST).exists():
        raise StudyError(str(folder), "", "holds a search for the fastest plan; give another folder")


def _tune(study: Study, world: World, asked: Asked) -> Result:
    """Tune and validate, from wherever the study stands."""
    configuration = study.configuration
    make_ready(world, configuration.scenario, asked.progress)
    before = study.result
    if before is not None:
        asked.progress.note(f"{study.folder}: going on after {count(before.flights, 'flight')}")
    elif isinstance(world, BuiltIn):  # where flights cost nothing
        guesses = (guess for guess in (configuration.first_guess, configuration.rival) if guess is not None)
        doom = say_doom(configuration.scenario, world, *guesses)
        if doom:
            asked.progress.note(f"note: {doom}")
    objective = Objective(configuration.scenario, world, configuration.metric, configuration.settings.randomise)
    with asked.progress.flights(configuration.settings.budget, before.flights if before else 0) as watch:
        result = study.run(objective, watch)
    told = describe_beginning(configuration, study.flights())
    if told:
        asked.progress.note(f"note: {told}")
    return result


def _saved(study: Study, result: Result) -> SavedParameters:
    """The best parameters, with how they came about; the same study always gives the same file."""
    scenario = study.configuration.scenario
    provenance: dict[str, Remark | None] = {
        "hotlap": __version__,
        "study": study.configuration.fingerprint,
        "world": study.configuration.world,
        "tuner": result.tuner,
        "goal": result.goal,
        "seed": result.seed,
        "flights": result.flights,
        "search_flights": result.search_flights,
        "confirmed": result.best.confirmed,
        "completion": result.best.completion,
        "lap_time": result.best.lap_time if math.isfinite(result.best.lap_time) else None,
    }
    if result.validation is not None:
        low, high = result.validation.interval
        provenance |= {"validation_flights": result.validation.flights, "validated_rate": result.validation.rate}
        provenance |= {"validated_low": low, "validated_high": high}
    known = {key: value for key, value in provenance.items() if value is not None}
    return SavedParameters(scenario.race.name, scenario.space.names, scenario.segments, result.best.parameters, known)


def _report(study: Study, world: World, asked: Asked) -> tuple[tuple[Robustness, ...], Path | None]:
    """How the best parameters fare under other conditions, and the page; what is tuned is saved already.

    Without a validation only conditions that were asked for are flown; none where the world flies the vehicle that it has.
    """
    from hotlap.report.page.replay import replay_finished  # noqa: PLC0415  it loads the flight core
    from hotlap.report.page.writing import write_replay  # noqa: PLC0415

    robustness: tuple[Robustness, ...] = ()
    snapshot, validated = read_snapshot(study), study.configuration.settings.validation > 0
    try:
        with asked.progress.working("writing the report"):
            replay = replay_finished(study.configuration, world, snapshot.best, robustness=validated, hold=snapshot.hold)
            robustness = replay.robustness
            return robustness, write_replay(snapshot, replay)
    except (HotlapError, OSError) as error:
        asked.progress.note(f"note: no report: {error}")
        return robustness, None


def _again(asked: Asked, folder: Path) -> str:
    """The command that flies tuned parameters as they were tuned."""
    same = {name: getattr(asked, name) for name in ("race", "reference", "segments", "controller", "on")}
    return command_line(fly, {**same, "parameters": folder})

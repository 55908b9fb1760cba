"""Tuned: the main job: tune, confirm, validate, save, and write a page about it."""

from __future__ import annotations

import inspect
import math
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hotlap import tuners, worlds
from hotlap.analysis.remedies import Failures, failures_of, what_to_try
from hotlap.api.asked import Asked, command_line
from hotlap.api.beginning import begin, begun_with, describe_beginning
from hotlap.api.chosen import advise_calmer, choose_plan, leaves_open, minutes_beside, plan_of
from hotlap.api.exporting import export
from hotlap.api.first_flights import say_doom
from hotlap.api.flying import fly
from hotlap.api.held import all_held, dump_robustness, read_hold
from hotlap.api.inputs import as_path, check_source
from hotlap.api.outcome import Outcome
from hotlap.api.scenarios import check_guess, load, make_ready, make_scenario, planned_as
from hotlap.api.slow_flights import followed
from hotlap.api.spreading import simulators_on
from hotlap.api.tuning import tune
from hotlap.api.wording import percent, seconds, share
from hotlap.core.counts import count
from hotlap.core.errors import HotlapError, InputError, StudyError
from hotlap.core.parameters import Parameters
from hotlap.core.seeds import FLIGHTS_A_STREAM
from hotlap.core.shown import Listed
from hotlap.core.success_rate import Validation
from hotlap.core.version import __version__
from hotlap.feasibility.demands import advice
from hotlap.feasibility.race import loose_judge
from hotlap.files.descriptions import PARAMETERS_FILE, save_parameters
from hotlap.files.parameters_file import CHOSEN_SHARE, Remark, SavedParameters
from hotlap.first_guess.names import LEARNED
from hotlap.race.race import Race
from hotlap.reference.scenario import Scenario
from hotlap.study.configuration import Configuration
from hotlap.study.database import is_begun
from hotlap.study.kept_guess import KeptGuess, find_kept_guess
from hotlap.study.result import Result
from hotlap.study.snapshot import read_snapshot
from hotlap.study.study import Study, new_folder
from hotlap.study.tried_plan import TriedPlan, describe_choice
from hotlap.system.engine import Engine
from hotlap.system.journal import Journal
from hotlap.system.regular_files import check_folder
from hotlap.tuners import Tuner
from hotlap.tuning.goal import Quantity, parse_goal
from hotlap.tuning.loop import TuningSettings, scenario_for
from hotlap.tuning.objective import Objective
from hotlap.worlds.built_in import BuiltIn
from hotlap.worlds.stepped import Stepped
from hotlap.worlds.world import World, is_slow

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hotlap.analysis.diagnosis import Diagnosis
    from hotlap.analysis.robustness import Robustness
    from hotlap.api.exported import ExportedFiles

HOME = "home"  # folder of what was tuned in the built-in world, within that of a study
FASTEST = ("race.toml", Journal.file)  # written by the search for the fastest plan, which may not have ended
NUMBERS = ("budget", "seed", "confirm", "validation", "reliability", "batch", "randomise", "samples", "selection", "minutes")
IN_SIMULATORS = {"validation": 20, "selection": 100}  # where a flight takes seconds
POPULATION = 32  # candidates that are flown at once where time is counted


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
        further: where the goal was not confirmed, what of a reference no weights can make up for, and whether a calmer plan holds.
        plans: that were tried before one was chosen; empty where the race fixes it.
        kept_guess: what the search began with, where that is its result; None where it has changed something.
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
    further: tuple[str, ...] = ()
    plans: tuple[TriedPlan, ...] = ()
    kept_guess: KeptGuess | None = None

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
    def causes(self) -> tuple[Diagnosis, ...]:
        """Why flights with the best parameters fail, the likeliest cause first; empty where they do not, or nothing was flown again."""
        return Listed(self.robustness[0].causes if self.robustness else ())

    @property
    def failures(self) -> Failures:
        """Why flights fail, by the conditions under which they do."""
        return failures_of(self.robustness)

    @property
    def advice(self) -> tuple[str, ...]:
        """What to try where flights fail, each thing once."""
        return what_to_try(self.failures, self.further)

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
        kept = "the most reliable of what was found" if result.selection_flights else "the best so far"
        return f"{result.goal} NOT confirmed in {count(result.flights, 'flight')}; {kept} is kept"

    def facts(self) -> dict[str, str]:
        """Verdict, flights, lap time, validation and paths."""
        result, kept = self.result, self.kept_guess
        return {
            "race": f"{result.race}: {self.verdict}",
            "result": "" if kept is None else kept.held,
            "mean error": "" if kept is None else kept.errors,
            "plan": describe_choice(self.plans),
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
            records = study.flights().records()
        return [{key: value for key, value in row.items() if key != "parameters"} for row in records]

    def to_dict(self) -> dict[str, Any]:
        """The keys of `hotlap tune --json`."""
        paths = {"study": str(self.folder), "parameters": str(self.parameters), "report": None if self.report is None else str(self.report)}
        robustness = [dump_robustness(one) for one in self.robustness]
        about = {"world": self.world, "first_guess": self.first_guess, "robustness": robustness, "holds": self.holds}
        about["causes"] = [cause.dump() for cause in self.causes]
        about["kept_guess"] = None if self.kept_guess is None else self.kept_guess.dump()
        said = {"notes": list(self.scenario.notes), "advice": list(self.advice), "plans": [plan.dump() for plan in self.plans]}
        return {**self.result.dump(), "wall_time": self.wall_time, **about, **said, **paths}

    def export(self, format: str, out: str | Path | None = None) -> ExportedFiles:  # noqa: A002  as `hotlap.export` calls it
        """The parameters, or the flights, in the files of another program, as `hotlap.export` writes them.

        Args:
            format: of which program.
            out: file to write; None: one in the folder of the study.

        Raises:
            InputError: there is no such format, or it cannot hold these parameters.
        """
        return export(self.folder, format, out=out)

    def plot(self) -> Figure:
        """Completion and cost over the flights of the search."""
        from hotlap.report.pictures import draw_convergence  # noqa: PLC0415  matplotlib, only where there is something to draw

        with Study.read(self.folder) as study:
            return draw_convergence(read_snapshot(study))


def carry_out(asked: Asked, *, at_home: bool = False) -> TuningResult:
    """Tune from wherever the study stands, and keep what came of it.

    Args:
        asked: the arguments.
        at_home: in the built-in world, for another tuning to begin at: no page, and no advice.
    """
    with simulators_on(asked) as engine:
        return _carry_out(asked, engine, at_home=at_home)


def _carry_out(asked: Asked, engine: Engine | None, *, at_home: bool) -> TuningResult:
    """The same, with simulators on the workers of an engine; None: here."""
    begun = time.perf_counter()
    job = _check(asked, engine)
    folder, plans, chosen = as_path(asked.out), (), False
    if isinstance(job.world, Stepped) and asked.first_guess is None:
        folder = folder or new_folder(job.race.name)
        with asked.remarked("go on", out=folder):
            job = _begun_at_home(job, folder)
    if folder is not None and is_begun(folder):
        configuration, plans = _go_on(job, folder)
    elif leaves_open(job.race, job.settings, job.asked):
        folder, chosen = folder or new_folder(job.race.name), True
        with asked.remarked("go on", out=folder):
            configuration, plans = choose_plan(job.race, job.world, job.settings, job.configuration, folder, job.asked)
    else:
        with asked.remarked("begin again"):
            configuration = job.configuration(job.race, job.settings)
    folder = folder or new_folder(job.race.name)
    with (
        asked.remarked("go on", out=folder),
        Study.open(folder, configuration, hold=asked.hold) as study,
    ):
        study.keep_command(asked.command(out=None, hold=study.hold, cluster=None))
        before = 0.0 if chosen else study.wall_time
        result = _tune(study, job.world, asked, begun=chosen)
        file = folder / PARAMETERS_FILE
        save_parameters(file, _saved(study, result))
        hints = () if at_home else _hints(job, result, configuration, folder, fixed=not (chosen or plans))
        study.keep_advice(hints)
        robustness, report, errors = ((), None, {}) if at_home else _report(study, job.world, asked)
        guess = begun_with(study.configuration, study.flights())
        kept = find_kept_guess(study.configuration, result, errors)
    waited, again = before + time.perf_counter() - begun, _again(asked, folder)
    return TuningResult(
        configuration.scenario, result, job.world.name, guess, folder, file, report, robustness, again, waited, hints, plans, kept
    )


def _hints(job: _Job, result: Result, configuration: Configuration, folder: Path, *, fixed: bool) -> tuple[str, ...]:
    """What to try where the goal was not confirmed: what a reference asks for, and calmer plans where the race fixes one."""
    if result.best.confirmed or result.goal == Quantity.NONE:
        return ()
    scenario, asked = configuration.scenario, job.asked
    if asked.reference is not None:
        return advice(scenario.race, scenario.reference)
    calmer = (job.race, job.world, job.settings, job.configuration, folder, asked, result.wall_time)
    return advise_calmer(*calmer) if fixed else ()


def _go_on(job: _Job, folder: Path) -> tuple[Configuration, tuple[TriedPlan, ...]]:
    """How the race of a study that is there is tuned: where it fixes no plan, with that of the study and what is left of the budget."""
    (share, plans, beside), race, settings = plan_of(folder), job.race, job.settings
    if race.planning.free and share is not None and job.asked.reference is None:
        race = race.with_share(share)
        others = sum(plan.flights for plan in plans if plan.share != share)
        settings = replace(settings, budget=max(settings.budget - others, 1), minutes=minutes_beside(settings, beside))
    if isinstance(job.world, Stepped) and settings.batch == TuningSettings().batch:
        with Study.read(folder) as study:
            job = replace(job, batch=study.configuration.settings.batch)
    with job.asked.remarked("begin again"):
        return job.configuration(race, settings), plans


def _begun_at_home(job: _Job, folder: Path) -> _Job:
    """The same job for a simulator, which begins at what was tuned in the built-in world, in a folder beside its flights."""
    asked, place = job.asked, folder / HOME
    if not (place / PARAMETERS_FILE).exists():
        _open_early(job)
        tuned = carry_out(_asked_at_home(asked, place), at_home=True)
        asked.progress.note(f"note: tuned in the built-in world first, in {seconds(tuned.wall_time, 0)}: {tuned.verdict}; begins there")
    told = Asked(tune, {**{name: getattr(asked, name) for name in inspect.signature(tune).parameters}, "first_guess": place})
    return replace(job, asked=told, race=planned_as(job.race, place))


def _open_early(job: _Job) -> None:
    """Open a simulator before anything takes its time, so that one that cannot be opened is known at once."""
    assert isinstance(job.world, Stepped)  # noqa: S101  our own mistake
    quiet = Asked(tune, {**vars(job.asked), "progress": False})
    scenario = make_scenario(job.race, quiet)
    with job.asked.progress.working(job.world.opening):
        job.world.capacity(scenario)


def _asked_at_home(asked: Asked, folder: Path) -> Asked:
    """What is asked of the built-in world: what decides about the controller, in as many flights as are usual there."""
    same = ("race", "tuner", "goal", "seed", "reference", "segments", "controller", "confirm", "reliability", "progress")
    usual = {name: parameter.default for name, parameter in inspect.signature(tune).parameters.items()}
    return _AtHome(tune, {**usual, **{name: getattr(asked, name) for name in same}, "out": folder})


class _AtHome(Asked):
    """Asked by another tuning, which says how to go on."""

    @contextmanager
    def remarked(self, does: str, **changed: Any) -> Iterator[None]:  # noqa: ARG002
        """Nothing."""
        yield


@dataclass(frozen=True)
class _Job:
    """What is to be tuned, checked but for its plan.

    Attributes:
        asked: the arguments.
        race: as it was read.
        world: where it is flown.
        tuner: not yet started.
        settings: of the tuning.
        batch: candidates that a simulator flies at once; 0: as many as it has lanes.
    """

    asked: Asked
    race: Race
    world: World
    tuner: Tuner
    settings: TuningSettings
    batch: int = 0

    def configuration(self, race: Race, settings: TuningSettings) -> Configuration:
        """Plan a race, or read its reference, and see where the search begins."""
        scenario = scenario_for(make_scenario(race, self.asked), self.tuner)
        if isinstance(self.world, Stepped) and settings.batch == TuningSettings().batch:
            settings = replace(settings, batch=self.batch or self.world.capacity(scenario))
        name, first, rival = begin(self.asked, scenario)
        told = (scenario, self.world.name, settings.goal.metric, self.tuner.name, settings, first)
        return Configuration(*told, first_guess_name=name, rival=rival)


def _check(asked: Asked, engine: Engine | None) -> _Job:
    """Check everything that was asked for, the quick things first."""
    tuner, world = tuners.build(asked.tuner), worlds.build(asked.on, asked.instances, engine)
    settings = _settings(asked, world)
    if asked.randomise and not world.takes_vehicle_parameters:
        raise InputError("", "randomise", f"{world.name} flies the vehicle that it has")
    check_source(as_path(asked.reference))
    check_guess(str(asked.first_guess or LEARNED))
    _check_folder(as_path(asked.out))
    race = planned_as(load(asked.race, asked.controller), asked.first_guess)
    read_hold(asked.hold, race, world)
    loose = loose_judge(race) if asked.reference is None else ""
    if loose:
        asked.progress.note(f"note: {loose}")
    return _Job(asked, race, world, tuner, settings)


def _settings(asked: Asked, world: World) -> TuningSettings:
    """The numbers that were asked for; where time is counted, flights are not, unless that is asked for, too.

    Where a flight takes seconds, fewer flights validate and choose the result, unless other numbers are asked for.
    """
    settings = TuningSettings(goal=parse_goal(asked.goal), **{name: getattr(asked, name) for name in NUMBERS})
    usual = inspect.signature(tune).parameters
    fewer = {name: few for name, few in IN_SIMULATORS.items() if is_slow(world) and getattr(settings, name) == usual[name].default}
    if fewer:
        settings = replace(settings, **fewer)
        words = {"validation": "validated", "selection": "chosen where none is confirmed"}
        told = ", ".join(f"{words[name]} by {few} flights ({name}=...)" for name, few in fewer.items())
        asked.progress.note(f"note: flights of {world.name} take their time, so the result is {told}")
    if not settings.minutes:
        return settings
    plain = TuningSettings()
    budget = FLIGHTS_A_STREAM if settings.budget == plain.budget else settings.budget
    return replace(settings, budget=budget, batch=POPULATION if settings.batch == plain.batch else settings.batch)


def _check_folder(folder: Path | None) -> None:
    """Refuse what can be no folder of this study."""
    if folder is None:
        return
    check_folder(folder, "the folder of a study")
    if any((folder / name).exists() for name in FASTEST):
        raise StudyError(str(folder), "", "holds a search for the fastest plan, or other work than a study; give another folder")


def _tune(study: Study, world: World, asked: Asked, *, begun: bool) -> Result:
    """Tune and validate, from wherever the study stands; begun: it was just now, when the plan was chosen."""
    configuration = study.configuration
    make_ready(world, configuration.scenario, asked.progress)
    before = study.result
    if begun:
        asked.progress.note(f"note: {describe_choice(study.plans)}")
    elif before is not None:
        asked.progress.note(f"{study.folder}: going on after {count(before.flights, 'flight')}")
    elif isinstance(world, BuiltIn):  # where flights cost nothing
        guesses = (guess for guess in (configuration.first_guess, configuration.rival) if guess is not None)
        doom = say_doom(configuration.scenario, world, *guesses)
        if doom:
            asked.progress.note(f"note: {doom}")
    objective = Objective(configuration.scenario, world, configuration.metric, configuration.settings.randomise)
    budget, flown, seconds = configuration.settings.budget, before.flights if before else 0, 60 * configuration.settings.minutes
    with asked.progress.flights(budget, flown, seconds, before.wall_time if before else 0.0) as watch, followed(world, watch):
        result = study.run(objective, watch)
    if told := describe_beginning(configuration, study.flights()) if begun or before is None else "":
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
    if study.plans:
        provenance[CHOSEN_SHARE] = scenario.race.planning.thrust_share
    known = {key: value for key, value in provenance.items() if value is not None}
    return SavedParameters(scenario.race.name, scenario.space.names, scenario.segments, result.best.parameters, known)


def _report(study: Study, world: World, asked: Asked) -> tuple[tuple[Robustness, ...], Path | None, Mapping[str, float]]:
    """How the best parameters fare under other conditions, the page, and mean errors [m] by what was flown; what is tuned is saved already.

    Without a validation only conditions that were asked for are flown; none where the world flies the vehicle that it has.
    """
    from hotlap.report.page.replay import replay_finished  # noqa: PLC0415  it loads the flight core
    from hotlap.report.page.writing import write_replay  # noqa: PLC0415

    robustness: tuple[Robustness, ...] = ()
    errors: Mapping[str, float] = {}
    snapshot, validated = read_snapshot(study), study.configuration.settings.validation > 0
    try:
        with asked.progress.working("writing the report"):
            replay = replay_finished(study.configuration, world, snapshot.best, robustness=validated, hold=snapshot.hold)
            robustness, errors = replay.robustness, replay.errors
            return robustness, write_replay(snapshot, replay), errors
    except (HotlapError, OSError) as error:
        asked.progress.note(f"note: no report: {error}")
        return robustness, None, errors


def _again(asked: Asked, folder: Path) -> str:
    """The command that flies tuned parameters as they were tuned."""
    same = {name: getattr(asked, name) for name in ("race", "reference", "segments", "controller", "on")}
    return command_line(fly, {**same, "parameters": folder})

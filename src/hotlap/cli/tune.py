"""`hotlap tune RACE`: the main job: tune, confirm, validate, save, draw, report."""

from __future__ import annotations

import math
import shlex
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hotlap import tuners, worlds
from hotlap.cli.flying import check_guess, load, make_ready, make_scenario, read_guess
from hotlap.cli.inputs import check_source
from hotlap.cli.output import note, present, working
from hotlap.cli.progress import follow
from hotlap.cli.stopping import remark
from hotlap.cli.summary import dump_holds, summarise
from hotlap.core.errors import HotlapError, InputError, StudyError
from hotlap.core.version import __version__
from hotlap.files.descriptions import PARAMETERS_FILE, save_parameters
from hotlap.files.parameters_file import Remark, SavedParameters
from hotlap.study.configuration import Configuration
from hotlap.study.result import Result
from hotlap.study.study import Study, new_folder
from hotlap.tuning.goal import Goal, Quantity, parse_goal
from hotlap.tuning.loop import TuningSettings, scenario_for
from hotlap.tuning.objective import Objective
from hotlap.worlds.world import World

FASTEST = "race.toml"  # written by the search for the fastest plan
LAP_TIME = "lap_time"  # a goal that is not reached by parameters alone

if TYPE_CHECKING:
    from hotlap.analysis.robustness import Robustness


def run(options: Namespace) -> int:
    """Tune, and say how it ended: 1 where the goal was not confirmed within the budget."""
    if options.goal.strip() == LAP_TIME:
        from hotlap.cli import fastest  # noqa: PLC0415  the search for plans is work of its own

        return fastest.run(options)
    world, configuration = _configure(options)
    folder = new_folder(configuration.scenario.race.name) if options.out is None else options.out
    with (
        remark(f"nothing is lost; go on with: {_continuing(options, folder)}"),
        Study.open(folder, configuration, repeating(options.arguments)) as study,
    ):
        result = _carry_out(study, world)
        file = folder / PARAMETERS_FILE
        save_parameters(file, _saved(study, result))
        pictures = _draw(study, world)
        holds = _holds(study, world, result)
        report = _report(study, world, holds)
    paths = {"study": str(folder), "parameters": str(file), "report": report, "pictures": [str(path) for path in pictures]}
    present(
        as_json=options.json,
        document={**result.dump(), "world": world.name, "first_guess": options.first_guess, "hold": dump_holds(holds), **paths},
        lines=summarise(result, holds, paths, options),
    )
    return 0 if result.best.confirmed or configuration.settings.goal.quantity is Quantity.NONE else 1


def _configure(options: Namespace) -> tuple[World, Configuration]:
    """Check everything that was asked for, the quick things first, and plan."""
    names = ("budget", "seed", "confirm", "validation", "reliability", "batch", "randomise", "samples")
    numbers = {name: getattr(options, name) for name in names}
    settings = TuningSettings(goal=_goal(options.goal), **numbers)
    tuner, world = tuners.build(options.tuner), worlds.build(options.on)
    if options.randomise and not world.takes_vehicle_parameters:
        raise InputError("--randomise", "", f"{world.name} flies the vehicle that it has")
    check_source(options.reference)
    check_guess(options.first_guess)
    if options.out is not None and options.out.exists() and not options.out.is_dir():
        raise StudyError(str(options.out), "", "is a file, not the folder of a study")
    if options.out is not None and (options.out / FASTEST).exists():
        raise StudyError(str(options.out), "", "holds a search for the fastest plan; give --out a folder of its own")
    with remark(f"nothing is lost; begin again with: {shlex.join(['hotlap', 'tune', *options.arguments])}"):
        scenario = scenario_for(make_scenario(load(options), options), tuner)
    first = read_guess(options.first_guess, scenario)
    return world, Configuration(
        scenario, world.name, settings.goal.metric, tuner.name, settings, first, first_guess_name=options.first_guess
    )


def _goal(text: str) -> Goal:
    """What is to be reached; who mistypes it learns of the one goal that is no `Goal`, too."""
    try:
        return parse_goal(text)
    except InputError as error:
        raise InputError(error.source, error.key, f"{error.reason}; {LAP_TIME} looks for the fastest plan") from None


def _carry_out(study: Study, world: World) -> Result:
    """Tune and validate, from wherever the study stands."""
    configuration = study.configuration
    make_ready(world, configuration.scenario)
    before = study.result
    if before is not None:
        note(f"{study.folder}: going on after {before.flights} flights")
    objective = Objective(configuration.scenario, world, configuration.metric, configuration.settings.randomise)
    with follow(configuration.settings.budget, before.flights if before else 0) as watch:
        return study.run(objective, watch)


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


def _draw(study: Study, world: World) -> tuple[Path, ...]:
    """Pictures of a study; what is tuned is saved already, and worth no less without them."""
    from hotlap.report.pictures import draw  # noqa: PLC0415  matplotlib takes half a second to load

    try:
        return draw(study.folder, study, world)
    except (HotlapError, OSError) as error:
        note(f"note: no pictures: {error}")
        return ()


def _report(study: Study, world: World, holds: tuple[Robustness, ...]) -> str | None:
    """The page of a study, of which the same is true."""
    from hotlap.report.page.writing import write_report  # noqa: PLC0415  it loads the flight core

    try:
        with working("writing the report"):
            return str(write_report(study, world, holds))
    except (HotlapError, OSError) as error:
        note(f"note: no report: {error}")
        return None


def _holds(study: Study, world: World, result: Result) -> tuple[Robustness, ...]:
    """How the best parameters fare with a vehicle that differs a little; nothing where the world flies what it has."""
    configuration = study.configuration
    if not world.takes_vehicle_parameters or not configuration.settings.validation:
        return ()
    from hotlap.analysis.robustness import check_robustness  # noqa: PLC0415  it loads the flight core

    with working("flying vehicles that differ a little"):
        return check_robustness(configuration.scenario, world, configuration.settings.goal, result.best.parameters, result.seed)


def repeating(arguments: Sequence[str]) -> str:
    """The command that does the same in another folder."""
    kept, skip = [], False
    for word in arguments:
        if not skip and word not in {"--out", "--json"} and not word.startswith("--out="):
            kept.append(word)
        skip = word == "--out"
    return shlex.join(["hotlap", "tune", *kept])


def _continuing(options: Namespace, folder: Path) -> str:
    """The command that goes on with a study."""
    words: list[Any] = ["hotlap", "tune", *options.arguments]
    return shlex.join(words if options.out is not None else [*words, "--out", str(folder)])

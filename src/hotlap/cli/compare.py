"""`hotlap compare RACE...`: tuners on equal terms: same first guess, budget, seeds and noise."""

from __future__ import annotations

import shlex
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path

from hotlap import tuners, worlds
from hotlap.analysis.comparison import Cell, Run, RunJournal, budget_of
from hotlap.analysis.comparison_table import cells_of, markdown, overall, rows_of
from hotlap.analysis.resumable import ResumableJobs
from hotlap.cli.flying import make_ready
from hotlap.cli.output import note, present, table, working
from hotlap.cli.progress import Flown, follow_pieces
from hotlap.cli.stopping import remark
from hotlap.core.errors import HotlapError, InputError, StudyError
from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare
from hotlap.race.controllers import ControllerKind
from hotlap.race.race import Race
from hotlap.reference.segmentation import SegmentationRule
from hotlap.system.text_files import replace
from hotlap.tuning.goal import parse_goal
from hotlap.tuning.loop import TuningSettings

TABLE, PAGE = "table.md", "comparison.html"
MOST_SEEDS = 100_000


def run(options: Namespace) -> int:
    """Fly what is missing, and say how the tuners did."""
    cells = _cells(options)
    folder: Path = options.out
    if folder.exists() and not folder.is_dir():
        raise StudyError(str(folder), "", "is a file, not the folder of a comparison")
    with remark(f"nothing is lost; go on with: {shlex.join(['hotlap', 'compare', *options.arguments])}"):
        runs = ResumableJobs(folder, options.jobs, follow_pieces, note).compare(cells, Flown())
        pictures = _write(folder, runs)
        page = _write_page(folder, runs, pictures, options)
    rows, summary = rows_of(runs), overall(runs)
    document = {
        "races": list(dict.fromkeys(cell.race.name for cell in cells)),
        "tuners": list(dict.fromkeys(cell.tuner for cell in cells)),
        "budget": {cell.tuner: cell.settings.budget for cell in cells},
        "seeds": options.seeds,
        "rows": [row.dump() for row in rows],
        "overall": [row.dump() for row in summary],
        "folder": str(folder),
        "page": page,
        "pictures": [str(path) for path in pictures],
    }
    right = range(2, 9)
    lines = [*table(cells_of(rows), right=right), "", *table(cells_of(summary), right=right), "", f"{folder / TABLE}"]
    present(as_json=options.json, document=document, lines=[*lines, *([page] if page else []), *map(str, pictures)])
    return 0


def _cells(options: Namespace) -> list[Cell]:
    """Every tuner on every race; checks all that was asked for, and plans."""
    names = [tuners.build(name).name for name in options.tuners.split(",")]
    budgets = _budgets(options.budget)
    if not 1 <= options.seeds <= MOST_SEEDS:
        raise InputError("--seeds", "", f"must be from 1 to {MOST_SEEDS}, not {options.seeds}")
    if options.jobs < 0:
        raise InputError("--jobs", "", f"must not be negative, not {options.jobs}")
    world = worlds.build(options.on)
    if options.randomise and not world.takes_vehicle_parameters:
        raise InputError("--randomise", "", f"{world.name} flies the vehicle that it has")
    numbers = {name: getattr(options, name) for name in ("validation", "confirm", "randomise", "samples")}
    same = {"goal": parse_goal(options.goal), "reliability": 0.0, **numbers}
    settings = {name: TuningSettings(budget=budget_of(name, budgets), **same) for name in names}
    seeds, rule = tuple(range(options.seeds)), SegmentationRule(options.segments)
    races = [_race(name, options) for name in dict.fromkeys(options.races)]
    for race, name in zip(races, dict.fromkeys(options.races), strict=True):
        if sum(other.name == race.name for other in races) > 1:
            raise InputError(name, "name", f"'{race.name}' is the name of another race too, and a table could not tell them apart")
    for race in races:
        with working(f"planning {race.name}"):
            scenario = prepare(race, segments=rule)
        make_ready(world, scenario)
    return [
        Cell(race, name, settings[name], seeds, options.on, rule, options.first_guess) for race in races for name in dict.fromkeys(names)
    ]


def _race(name: str, options: Namespace) -> Race:
    """A race with the controller that was asked for."""
    race = load_race(name)
    return race if options.controller is None else race.with_controller(ControllerKind(options.controller))


def _budgets(text: str) -> Mapping[str, int]:
    """`200,cma_es=1000`: flights for all, and for some algorithms or presets."""
    budgets = {"": 200}
    for part in text.split(","):
        name, separator, number = part.rpartition("=")
        try:
            budgets[tuners.build(name).name if ":" in name else name] = int(number)
        except ValueError:
            raise InputError("--budget", "", f"must be like 200,cma_es=1000, not '{part}'") from None
        if separator and ":" not in name:
            tuners.build(name)
    return budgets


def _write(folder: Path, runs: Sequence[Run]) -> tuple[Path, ...]:
    """The tables and pictures."""
    (folder / TABLE).write_text(f"{markdown(overall(runs))}\n{markdown(rows_of(runs))}", encoding="utf-8")
    from hotlap.report.comparison import draw_comparison  # noqa: PLC0415  matplotlib takes half a second to load

    try:
        return draw_comparison(folder, runs)
    except (HotlapError, OSError) as error:
        note(f"note: no pictures: {error}")
        return ()


def _write_page(folder: Path, runs: Sequence[Run], pictures: Sequence[Path], options: Namespace) -> str | None:
    """The same as one page that opens anywhere."""
    from hotlap.report.comparison_article import compose_article  # noqa: PLC0415  only where there is something to show

    command = shlex.join(["hotlap", "compare", *options.arguments])
    try:
        replace(folder / PAGE, compose_article(runs, pictures, RunJournal.file, command).html)
    except (HotlapError, OSError) as error:
        note(f"note: no page: {error}")
        return None
    return str(folder / PAGE)

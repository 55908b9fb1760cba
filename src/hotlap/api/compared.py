"""Compared: tuners on equal terms: same first guess, budget, seeds and noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hotlap import tuners, worlds
from hotlap.analysis.comparison import Cell, Run, RunJournal, budget_of
from hotlap.analysis.comparison_table import Row, cells_of, held_cells_of, markdown, overall, rows_of
from hotlap.analysis.paired import Paired, paired, paired_cells
from hotlap.analysis.resumable import ResumableJobs
from hotlap.api.asked import Asked
from hotlap.api.held import read_hold
from hotlap.api.inputs import as_path, check_source, one_of
from hotlap.api.outcome import Outcome
from hotlap.api.rates import Flown
from hotlap.api.scenarios import load, make_ready, make_scenario
from hotlap.api.wording import percent
from hotlap.core.counts import count
from hotlap.core.errors import HotlapError, InputError, UnknownNameError
from hotlap.core.shown import Listed
from hotlap.files.descriptions import names
from hotlap.files.kinds import Kind
from hotlap.files.suites import expand
from hotlap.first_guess.names import NAMES
from hotlap.race.hold import parse_hold
from hotlap.race.race import Race
from hotlap.reference.segmentation_rule import SegmentationRule
from hotlap.system.engine import check_jobs, opened
from hotlap.system.regular_files import check_folder
from hotlap.system.text_files import replace
from hotlap.tuning.goal import parse_goal
from hotlap.tuning.loop import TuningSettings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TABLE, PAGE = "table.md", "comparison.html"
MOST_SEEDS = 100_000


@dataclass(frozen=True, repr=False)
class ComparisonResult(Outcome):
    """How tuners did on races.

    Attributes:
        races: names, in the order in which they were asked for.
        tuners: names with presets, likewise.
        budget: flights of a run, for each tuner.
        seeds: runs of each tuner on each race.
        runs: all of them.
        folder: where they are kept.
        table: the file of both tables.
        page: the page; None where it could not be written.
        pictures: files.
    """

    races: tuple[str, ...]
    tuners: tuple[str, ...]
    budget: Mapping[str, int]
    seeds: int
    runs: tuple[Run, ...]
    folder: Path
    table: Path
    page: Path | None
    pictures: tuple[Path, ...]

    @property
    def by_race(self) -> Listed[Row]:
        """A row for each tuner on each race."""
        return Listed(rows_of(self.runs))

    @property
    def overall(self) -> Listed[Row]:
        """A row for each tuner over all races, the best first."""
        return Listed(overall(self.runs))

    @property
    def paired(self) -> Listed[Paired]:
        """A row for each two tuners, compared race by race and seed by seed; the better one first."""
        return Listed(paired(self.runs))

    def facts(self) -> dict[str, str]:
        """How often each tuner confirmed a candidate, over all races."""
        head = f"{count(len(self.tuners), 'tuner')} on {count(len(self.races), 'race')}, {count(self.seeds, 'seed')} each"
        rates = {row.tuner: f"{row.tuner} confirmed in {percent(row.success_rate)}" for row in self.overall}
        return {"comparison": head, **rates, "page": str(self.page or self.folder)}

    def rows(self) -> list[dict[str, Any]]:
        """A row for each run."""
        return [{key: value for key, value in run.dump().items() if key not in {"curve", "held"}} | _held(run) for run in self.runs]

    def to_dict(self) -> dict[str, Any]:
        """The keys of `hotlap compare --json`."""
        return {
            "races": list(self.races),
            "tuners": list(self.tuners),
            "budget": dict(self.budget),
            "seeds": self.seeds,
            "rows": [row.dump() for row in self.by_race],
            "overall": [row.dump() for row in self.overall],
            "paired": [row.dump() for row in self.paired],
            "folder": str(self.folder),
            "page": None if self.page is None else str(self.page),
            "pictures": [str(path) for path in self.pictures],
        }

    def plot(self) -> Figure:
        """Completion of the best candidate so far over flights, for each race."""
        from hotlap.report.comparison import curves  # noqa: PLC0415  matplotlib, only where there is something to draw

        return curves(self.runs)


def _held(run: Run) -> dict[str, float]:
    """Share of successes of a run under each condition that was asked for, by column."""
    return {f"held: {change}": successes / flights for change, successes, flights in run.held}


def carry_out(asked: Asked) -> ComparisonResult:
    """Fly what is missing, and write tables, pictures and page."""
    check_jobs(asked.jobs, asked.cluster)
    folder = Path(asked.out)
    with opened(asked.cluster, _processes(asked), asked.progress.note) as engine:
        cells = _cells(asked)
        check_folder(folder, "the folder of a comparison")
        with asked.remarked("go on"):
            engine.require(*_needed(asked))
            jobs = ResumableJobs(folder, progress=asked.progress.pieces, note=asked.progress.note, engine=engine)
            runs = tuple(jobs.compare(cells, Flown()))
            pictures = _write(folder, runs, asked)
            page = _write_page(folder, runs, asked)
    return ComparisonResult(
        races=tuple(dict.fromkeys(cell.race.name for cell in cells)),
        tuners=tuple(dict.fromkeys(cell.tuner for cell in cells)),
        budget={cell.tuner: cell.settings.budget for cell in cells},
        seeds=asked.seeds,
        runs=runs,
        folder=folder,
        table=folder / TABLE,
        page=page,
        pictures=pictures,
    )


def _processes(asked: Asked) -> int:
    """How many processes fly; one where each would need simulators of its own."""
    return asked.jobs if asked.on == worlds.DEFAULT else 1


def _needed(asked: Asked) -> list[str | Path]:
    """Files and modules of the user's own, which must be the same where runs are done."""
    own = (name.partition(":")[0].rpartition(".")[0] for name in _listed(asked))
    return [*own, *worlds.needed(asked.on), *([] if asked.reference is None else [asked.reference])]


def _listed(asked: Asked) -> Sequence[str]:
    """The tuners that were asked for."""
    return asked.tuners.split(",") if isinstance(asked.tuners, str) else asked.tuners


def _cells(asked: Asked) -> list[Cell]:
    """Every tuner on every race; checks all that was asked for, and plans."""
    names = [tuners.build(name).name for name in _listed(asked)]
    budgets = _budgets(str(asked.budget))
    if not 1 <= asked.seeds <= MOST_SEEDS:
        raise InputError("", "seeds", f"must be from 1 to {MOST_SEEDS}, not {asked.seeds}")
    world = worlds.build(asked.on, asked.instances)
    if asked.cluster is not None:
        worlds.check_spread(asked.on)
    if asked.randomise and not world.takes_vehicle_parameters:
        raise InputError("", "randomise", f"{world.name} flies the vehicle that it has")
    if asked.first_guess not in NAMES:
        raise UnknownNameError("first guess", asked.first_guess, NAMES, key="first_guess")
    numbers = {name: getattr(asked, name) for name in ("validation", "confirm", "randomise", "samples")}
    same = {"goal": parse_goal(asked.goal), "reliability": 0.0, **numbers}
    settings = {name: TuningSettings(budget=budget_of(name, budgets), **same) for name in names}
    seeds, rule = tuple(range(asked.seeds)), one_of(SegmentationRule, asked.segments, "segmentation rule", "segments")
    races, reference = _races(asked), as_path(asked.reference)
    check_source(reference)
    if reference is not None and len(races) > 1:
        raise InputError("", "reference", f"belongs to one race; {len(races)} are asked for")
    hold = parse_hold(asked.hold)
    for race in races:
        read_hold(asked.hold, race, world)
        make_ready(world, make_scenario(race, asked), asked.progress)
    return [
        Cell(race, name, settings[name], seeds, asked.on, rule, asked.first_guess, reference, hold, asked.instances)
        for race in races
        for name in dict.fromkeys(names)
    ]


def _races(asked: Asked) -> list[Race]:
    """Each race once; no two of one name."""
    listed = [asked.races] if isinstance(asked.races, Race | str | Path) else asked.races
    given = [race for word in listed for race in (expand([word], names(Kind.RACE), "race") if isinstance(word, str) else [word])]
    if not given:
        raise InputError("", "races", "are none")
    distinct = [race for i, race in enumerate(given) if race not in given[:i]]
    races = [load(race, asked.controller) for race in distinct]
    for race, source in zip(races, distinct, strict=True):
        if sum(other.name == race.name for other in races) > 1:
            where = source.name if isinstance(source, Race) else str(source)
            raise InputError(where, "name", f"'{race.name}' is the name of another race too, and a table could not tell them apart")
    return races


def _budgets(text: str) -> Mapping[str, int]:
    """`200,cma_es=1000`: flights for all, and for some algorithms or presets."""
    budgets = {"": 200}
    for part in text.split(","):
        name, separator, number = part.rpartition("=")
        tuner = tuners.build(name).name if separator else ""
        try:
            budgets[tuner if ":" in name else tuner.partition(":")[0]] = int(number)
        except ValueError:
            raise InputError("", "budget", f"must be like 200,cma_es=1000, not '{part}'") from None
    return budgets


def _write(folder: Path, runs: Sequence[Run], asked: Asked) -> tuple[Path, ...]:
    """The tables and pictures."""
    both = overall(runs), rows_of(runs)
    tables = [*map(cells_of, both), *filter(None, [paired_cells(paired(runs)), *map(held_cells_of, both)])]
    replace(folder / TABLE, "\n".join(map(markdown, tables)))
    from hotlap.report.comparison import draw_comparison  # noqa: PLC0415  matplotlib takes half a second to load

    try:
        return draw_comparison(folder, runs)
    except (HotlapError, OSError) as error:
        asked.progress.note(f"note: no pictures: {error}")
        return ()


def _write_page(folder: Path, runs: Sequence[Run], asked: Asked) -> Path | None:
    """The same as one page that opens anywhere."""
    from hotlap.report.comparison_article import compose_article  # noqa: PLC0415  only where there is something to show

    try:
        replace(folder / PAGE, compose_article(runs, RunJournal.file, asked.command(cluster=None)).html)
    except (HotlapError, OSError) as error:
        asked.progress.note(f"note: no page: {error}")
        return None
    return folder / PAGE

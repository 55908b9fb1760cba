"""Transferred: tuned and default parameters flown in other worlds than that of their study, and how they fared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hotlap import worlds
from hotlap.analysis.transfer import DEFAULT, TUNED, Journey, TransferFlight, TransferRow, metres, rows_of
from hotlap.api.asked import Asked
from hotlap.api.inputs import check_range
from hotlap.api.outcome import Outcome
from hotlap.api.scenarios import make_ready
from hotlap.api.spreading import simulators_on
from hotlap.core.counts import count
from hotlap.core.errors import HotlapError, InputError, StudyError, UnknownNameError
from hotlap.core.seeds import LARGEST_RUN_SEED, Stream, flight_seeds
from hotlap.core.shown import Listed
from hotlap.first_guess.guess import first_guess
from hotlap.reference.scenario import Scenario
from hotlap.study.snapshot import ELSEWHERE, Snapshot, read_snapshot
from hotlap.study.study import Study
from hotlap.study.versions import describe_changes
from hotlap.system.engine import Engine
from hotlap.system.regular_files import check_folder
from hotlap.system.text_files import replace
from hotlap.worlds.world import World

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE = "page.md"
FEWEST, MOST = 3, 1000  # flights of each set in each world


@dataclass(frozen=True, repr=False)
class TransferResult(Outcome):
    """Tuned and default parameters in several worlds.

    Attributes:
        scenario: what was flown.
        study: the folder of the study.
        worlds: names, that of the study first.
        flights: all of them, world by world.
        folder: where they are kept, and what was written about them.
        page: as HTML; None where it could not be written.
        pictures: files.
    """

    scenario: Scenario
    study: Path
    worlds: tuple[str, ...]
    flights: tuple[TransferFlight, ...]
    folder: Path
    page: Path | None
    pictures: tuple[Path, ...]

    @property
    def by_world(self) -> Listed[TransferRow]:
        """A row for each set of parameters in each world."""
        return Listed(rows_of(self.flights))

    def facts(self) -> dict[str, str]:
        """How many of the flights with tuned parameters passed every gate in each world, and their error."""
        home, *others = self.worlds
        tuned = {row.world: _in_short(row) for row in self.by_world if row.label == TUNED}
        return {"race": f"{self.scenario.race.name}: tuned in {home}, flown in {', '.join(others)}", **tuned, "page": str(self.page or "")}

    def rows(self) -> list[dict[str, Any]]:
        """A row for each flight."""
        return [flight.summary() for flight in self.flights]

    def to_dict(self) -> dict[str, Any]:
        """The keys of `hotlap transfer --json`."""
        return {
            "race": self.scenario.race.name,
            "study": str(self.study),
            "worlds": list(self.worlds),
            "rows": [row.dump() for row in self.by_world],
            "flights": self.rows(),
            "folder": str(self.folder),
            "page": None if self.page is None else str(self.page),
            "pictures": [str(path) for path in self.pictures],
        }

    def plot(self) -> Figure:
        """Tracking error of all control steps: a box for each set of parameters in each world."""
        from hotlap.report.transfer_charts import error_boxes  # noqa: PLC0415  matplotlib, only where there is something to draw

        return error_boxes(self.scenario.race.name, self.by_world)


def _in_short(row: TransferRow) -> str:
    """How flights went in a world."""
    return f"{row.world} {row.complete.successes} of {count(row.complete.flights, 'flight')} complete, {metres(row.mean_error)} m"


def carry_out(asked: Asked) -> TransferResult:
    """Fly what is missing, and write about it."""
    with simulators_on(asked) as engine:
        return _carry_out(asked, engine)


def _carry_out(asked: Asked, engine: Engine | None) -> TransferResult:
    """The same, with simulators on the workers of an engine; None: here."""
    check_range("flights", asked.flights, FEWEST, MOST)
    check_range("seed", asked.seed, 0, LARGEST_RUN_SEED)
    snapshot = _read(Path(asked.folder))
    configuration, folder = snapshot.configuration, snapshot.folder / ELSEWHERE.parent
    scenario, everywhere = configuration.scenario, _worlds(asked.to, configuration.world, engine)
    sets = {DEFAULT: first_guess(scenario, DEFAULT), TUNED: snapshot.best}
    journey = Journey(scenario, sets, everywhere, flight_seeds(asked.seed, Stream.DEMONSTRATION, 0, asked.flights))
    check_folder(folder, "a folder for flights")
    with _about_to():
        opened = journey.open(folder)
    told = describe_changes(dict(snapshot.openings[-1][1]) if snapshot.openings else {}, [world.name for world in everywhere])
    if told:
        asked.progress.note(f"note: {told}")
    with asked.remarked("go on"), _about_to():
        for world in opened:
            make_ready(world, journey.flown, asked.progress)
        flights = tuple(journey.fly(folder, partial(asked.progress.pieces, even=False), asked.progress.note))
        pictures, page = _write(folder, scenario.race.name, rows_of(flights), asked)
    return TransferResult(scenario, snapshot.folder, tuple(world.name for world in everywhere), flights, folder, page, pictures)


def _read(folder: Path) -> Snapshot:
    """A study that has ended."""
    with Study.read(folder) as study:
        snapshot = read_snapshot(study)
    if not snapshot.finished:
        raise StudyError(str(folder), "", f"holds a study that has not ended; hotlap.tune(RACE, out={str(folder)!r}) goes on with it")
    return snapshot


def _worlds(to: str | World | Sequence[str | World], home: str, engine: Engine | None) -> list[World]:
    """All worlds, that of the study first; each once."""
    given = to.split(",") if isinstance(to, str) else to if isinstance(to, Sequence) else [to]
    listed = [one.strip() if isinstance(one, str) else one for one in given]
    with _about_to():
        others = [worlds.build(one, 1, engine) if isinstance(one, str) else one for one in listed if one != home]
        found = [worlds.build(home, 1, engine), *others]
    distinct = {world.name: world for world in reversed(found)}
    if len(distinct) < 2:
        raise InputError("", "to", f"must name another world than {home}, where the study was tuned")
    return [distinct[name] for name in dict.fromkeys(world.name for world in found)]


@contextmanager
def _about_to() -> Iterator[None]:
    """What is said about a world that is flown on is said about one that is flown to."""
    try:
        yield
    except InputError as error:
        if error.source or error.key != "on":
            raise
        known = isinstance(error, UnknownNameError)
        raise UnknownNameError(error.kind, error.name, error.available, key="to") if known else InputError("", "to", error.reason) from None


def _write(folder: Path, race: str, rows: Sequence[TransferRow], asked: Asked) -> tuple[tuple[Path, ...], Path | None]:
    """Charts and page; without them the flights are kept all the same."""
    from hotlap.report.transfer_article import compose_article  # noqa: PLC0415  only where there is something to show
    from hotlap.report.transfer_charts import draw_transfer  # noqa: PLC0415  matplotlib takes half a second to load

    pictures: tuple[Path, ...] = ()
    try:
        pictures = draw_transfer(folder, race, rows)
        article = compose_article(race, rows, pictures, asked.command(cluster=None))
        replace(folder / PAGE, article.markdown)
        replace(folder / ELSEWHERE.name, article.html)
    except (HotlapError, OSError) as error:
        asked.progress.note(f"note: no page: {error}")
        return pictures, None
    return pictures, folder / ELSEWHERE.name

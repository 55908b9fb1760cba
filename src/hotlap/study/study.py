"""Study: a folder that keeps every flight of a tuning, and from which an interrupted tuning is continued.

The folder holds one SQLite file. A batch of flights and what it changed in the state of the run (the tuner, its random generator, the
best candidate) are written in one transaction: after a kill or a power cut the run continues bit for bit as if never interrupted.
"""

from __future__ import annotations

import json
import math
import re
import sqlite3
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from datetime import datetime
from functools import reduce
from pathlib import Path
from typing import Any, Self

import numpy as np

from hotlap.core.errors import InputError, StudyError
from hotlap.core.ledger import Ledger
from hotlap.core.parameters import Parameters
from hotlap.core.seeds import Stream
from hotlap.core.shown import Framed, fitted, html_table
from hotlap.study.checksums import checksum
from hotlap.study.configuration import Configuration, first_difference, load_configuration, load_rival, pack_reference, unpack_reference
from hotlap.study.database import FILE, Database
from hotlap.study.increments import grow, increment
from hotlap.study.result import Result
from hotlap.study.tried_plan import TriedPlan
from hotlap.study.versions import digest_of_flights, versions_now
from hotlap.tuners.tuner import remark_of
from hotlap.tuning.loop import Batch, Tuning, tune
from hotlap.tuning.objective import Objective
from hotlap.tuning.timekeeper import Timekeeper
from hotlap.worlds.world import is_slow

RUNS = Path("runs")
PAGE = "report.html"

_ORDER = "CASE stream WHEN 'SELECTION' THEN 1 WHEN 'VALIDATION' THEN 2 ELSE 0 END, number"
_INSERT = "INSERT INTO flight VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"


class Study(Framed):
    """A study: `Study("runs/mine")` opens one to look at, also while another process works on it; `Study.open` begins one or goes on.

    It is closed by leaving its `with`, by `close`, or when nobody needs it any more.

    Args:
        folder: of a study that is there.
        configuration: None: look at it; else begin a study, or go on with one of the same configuration, as `Study.open` does.

    Raises:
        StudyError: the folder holds no study, or one that cannot be used so.

    Attributes:
        folder: where it is kept.
        configuration: what is tuned, and how.
    """

    configuration: Configuration

    def __init__(self, folder: str | Path, configuration: Configuration | None = None) -> None:
        self.folder = Path(folder)
        if configuration is None and not _is_there(self.folder):
            raise StudyError(str(folder), "", f"holds no study ({FILE})")
        self._database = Database(self.folder, owned=configuration is not None)
        self._clock, self._mark = time.monotonic, time.monotonic()
        self._state: Any = None  # as it was recorded last, if anything was
        with self._closed_on_error():
            if configuration is None:
                self._load()
            elif self._database.is_new():
                self._create(configuration)
            else:
                self._continue(configuration)

    @classmethod
    def open(cls, folder: str | Path, configuration: Configuration, command: str = "", hold: str = "") -> Self:
        """Begin a study, or continue one of the same configuration; a larger budget may be given.

        Args:
            folder: of the study.
            configuration: what is tuned, and how.
            command: that does the same again, to be kept.
            hold: conditions that the result is to hold under, to be kept; "": those that were kept before.

        Raises:
            StudyError: another configuration, another process at work, a file that is no study or of a newer format, no room.
        """
        study = cls(folder, configuration)
        with study._closed_on_error():
            study.keep_command(command)
            if hold:
                study._enter("hold", hold)
        return study

    @classmethod
    def read(cls, folder: str | Path) -> Self:
        """The same as `Study(folder)`.

        Raises:
            StudyError: there is none, or it cannot be read.
        """
        return cls(folder)

    def _load(self) -> None:
        """What was asked for, from what is recorded."""
        if self._database.is_new():
            raise StudyError(str(self.folder), "", f"holds no study: {FILE} is empty")
        plain = self._plain_configuration()
        with self._database.decoding("its reference"):
            reference = unpack_reference(self._entry("reference"))
        with self._database.decoding("its configuration"):
            try:
                self.configuration = load_configuration(plain, reference)
            except InputError as fault:
                raise StudyError(str(self.folder), fault.key, f"{fault.reason} (the study is of another version of hotlap)") from None

    def __repr__(self) -> str:
        title, *others = [value for _, value in self._facts()]
        return fitted(f"<Study {title}{': ' if others else ''}", others, ">", "; ")

    def _repr_html_(self) -> str:
        (_, title), *others = self._facts()
        return html_table(f"study {title}", others)

    def _facts(self) -> list[tuple[str, str]]:
        """What one wants to know at a glance, by name; of a study that is closed the folder alone."""
        try:
            result = self.result
        except (StudyError, sqlite3.ProgrammingError):
            return [("study", f"{self.folder} (closed)")]
        asked = self.configuration
        begun = [("study", str(self.folder)), ("race", asked.scenario.race.name), ("tuner", asked.tuner)]
        if result is None:
            return [*begun, ("budget", f"none of {asked.settings.budget} flights")]
        best = result.best
        state = f"{result.goal} {'confirmed' if best.confirmed else 'not confirmed'}, {100 * best.completion:.3g} % of the gates"
        page = self.folder / PAGE
        shown = [("page", str(page))] if page.is_file() else []
        return [*begun, ("budget", f"{result.flights} of {asked.settings.budget} flights"), ("best", state), *shown]

    def records(self) -> list[dict[str, Any]]:
        """A row for each flight; its parameters are an array, shape (S, K)."""
        return self.flights().records()

    @property
    def values(self) -> Parameters:
        """The best parameters so far, shape (S, K); the first guess before the first flight."""
        result = self.result
        return self.configuration.first_guess if result is None else result.best.parameters

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file and unlock the folder; everything is written already."""
        self._database.close()

    @property
    def tuning(self) -> Tuning:
        """The run after the last recorded batch, ready to be continued."""
        asked = self.configuration
        tuner, state = asked.build_tuner(), self._recorded_state()
        with self._database.decoding("the state of its run"):
            return Tuning(tuner, asked.scenario, asked.settings, asked.first_guess, state)

    @property
    def wall_time(self) -> float:
        """[s] that processes have spent on its flights, until the last record; planning and compiling are not among them."""
        return self._seconds("wall_time")

    @property
    def result(self) -> Result | None:
        """The result so far; None before the first flight."""
        tuning = self.tuning
        if tuning.best is None:
            return None
        return Result(
            race=self.configuration.scenario.race.name,
            tuner=tuning.tuner.name,
            goal=str(tuning.settings.goal),
            seed=tuning.settings.seed,
            flights=tuning.flights,
            search_flights=tuning.search_flights,
            best=tuning.best,
            validation=tuning.validation,
            validation_flights=tuning.validation_flights,
            selection_flights=tuning.selection_flights,
            wall_time=self.wall_time,
            remark=remark_of(tuning.tuner),
        )

    @property
    def command(self) -> str:
        """The command that does the same again; "" where it was not kept."""
        return self._text("command")

    def keep_command(self, command: str) -> None:
        """Keep the command that does the same again; "" leaves that of before."""
        command = command.encode("utf-8", "backslashreplace").decode()  # names of files need not be text
        if command and command != self.command:
            self._enter("command", command)

    @property
    def hold(self) -> str:
        """Conditions that the result is to hold under, as they were asked for; "" where nobody asked."""
        return self._text("hold")

    @property
    def advice(self) -> list[str]:
        """What to try where its result is not confirmed, beside what flights say; empty where nothing was found out."""
        with self._database.decoding("its advice"):
            return [str(line) for line in json.loads(self._text("advice") or "[]")]

    def keep_advice(self, advice: Sequence[str]) -> None:
        """Keep what to try, in place of that of before."""
        if list(advice) != self.advice:
            self._enter("advice", json.dumps(list(advice)))

    @property
    def plans(self) -> list[TriedPlan]:
        """The plans that were tried before this one was chosen, this one among them, in the order tried; empty where the race fixes it."""
        with self._database.decoding("its plans"):
            return [TriedPlan.load(plain) for plain in json.loads(self._text("plans") or "[]")]

    @property
    def beside(self) -> float:
        """[s] that choosing its plan took beside its own search; 0 where the race fixes it, or time is not counted."""
        return self._seconds("beside")

    def record_plans(self, plans: Sequence[TriedPlan], beside: float = 0.0) -> None:
        """Keep which plans were tried, and [s] what that took beside the search of this one, where time is counted."""
        with self._transaction():
            self._enter("plans", json.dumps([plan.dump() for plan in plans], allow_nan=False))
            if beside:
                self._enter("beside", beside)

    @property
    def openings(self) -> list[tuple[str, dict[str, str]]]:
        """When it was opened to be continued, with the versions of the software that did."""
        rows = self._database.rows("opening")
        with self._database.decoding("when it was opened"):
            return [(str(moment), {**json.loads(versions)}) for moment, versions in rows]

    @property
    def codes(self) -> set[str]:
        """Digests of the source code that it was opened with to be continued; "" for versions that kept none."""
        return {str(versions.get("code", "")) for _, versions in self.openings}

    def flights(self) -> Ledger:
        """All flights: search and confirmation in the order flown, then the selection, then the validation."""
        rows = self._database.rows("flight", order=_ORDER)
        with self._database.decoding("its flights"):
            return self._as_ledger(rows)

    def _as_ledger(self, rows: Sequence[tuple[Any, ...]]) -> Ledger:
        """Flights as they are recorded.

        Raises:
            ValueError: the parameters of one are more or fewer than others'.
        """
        streams, numbers, seeds, parameters, *floats, accepted = zip(*rows, strict=True) if rows else [()] * 11
        cost, completion, failed_segment, mean_error, max_error, lap_time = floats
        shape = self.configuration.first_guess.shape
        if any(len(values) != 8 * math.prod(shape) for values in parameters):
            raise ValueError("a flight has parameters of another shape")
        return Ledger(
            numbers=np.array(numbers, dtype=np.int64),
            streams=np.array([Stream[name] for name in streams], dtype=np.int64),
            parameters=np.frombuffer(b"".join(parameters), dtype="<f8").reshape(-1, *shape),
            seeds=np.array(seeds, dtype=np.int64),
            cost=np.array(cost, dtype=np.float64),  # SQLite keeps NaN as NULL; it comes back as None and so as NaN
            completion=np.array(completion, dtype=np.float64),
            failed_segment=np.array(failed_segment, dtype=np.int64),
            mean_error=np.array(mean_error, dtype=np.float64),
            max_error=np.array(max_error, dtype=np.float64),
            lap_time=np.array(lap_time, dtype=np.float64),
            accepted=np.array(accepted, dtype=np.bool_),
        )

    def at_one_moment(self) -> AbstractContextManager[None]:
        """A context within which all that is read is of one moment, also while another process works on the study; keep it short."""
        return self._database.at_one_moment()

    def record(self, batch: Batch) -> None:
        """Keep the flights of a batch and what it changed in the state of the run: both or neither.

        Raises:
            StudyError: there is no room; what was recorded before is kept.
        """
        before = self._recorded_state() if self._state is None else self._state
        change = json.dumps(increment(before, batch.state), allow_nan=False)
        with self._transaction():
            self._insert(batch.ledger)
            self._append("increment", change)
        self._state = grow(before, json.loads(change))  # shares no memory with the tuner

    def run(
        self, objective: Objective, watch: Callable[[Batch], None] = lambda _: None, clock: Callable[[], float] = time.monotonic
    ) -> Result:
        """Continue the tuning to its end, and record every batch; a finished study flies nothing.

        The time since the study was opened is not the search's: something may have been compiled.

        Args:
            objective: the scenario of the study, bound to its world and metric.
            watch: called after each batch, for progress.
            clock: [s]

        Raises:
            StudyError: the objective's world, metric, cost or randomisation is not the study's.
        """
        self._check(objective)
        tuning = self.tuning
        if tuning.flights and not tuning.done and self.codes - {digest_of_flights()}:
            told = "some of its flights are of other source code than this; on one code alone it is tuned in a new folder"
            warnings.warn(f"{self.folder}: {told}", stacklevel=2)
        tuning.together = self.configuration.settings.batch if is_slow(objective.world) else 0
        self._clock, self._mark = clock, clock()
        keeper = Timekeeper(tuning, objective, self.wall_time, clock)
        for batch in tune(keeper, tuning):
            self.record(batch)
            watch(batch)
            keeper.attend()
        result = self.result
        assert result is not None, "a run that has ended has flown"  # noqa: S101  our own mistake
        return result

    def _recorded_state(self) -> Any:
        """The state of the run after the last recorded batch, put together from its increments; None before the first."""
        rows = self._database.rows("increment")
        with self._database.decoding("the state of its run"):
            return reduce(grow, (json.loads(change) for (change,) in rows), None)

    def _check(self, objective: Objective) -> None:
        """Whether an objective flies what is recorded; scenarios are too large to be compared at every opening."""
        asked = self.configuration
        for key, mine, theirs in (
            ("world", asked.world, objective.world.name),
            ("metric", asked.metric, objective.metric),
            ("cost", asked.cost, objective.own_cost),
            ("randomise", asked.settings.randomise, objective.randomise),
        ):
            if mine != theirs:
                raise StudyError(str(self.folder), key, f"this study has {_show(mine)}, what it is to be flown with has {_show(theirs)}")

    def _create(self, configuration: Configuration) -> None:
        """Everything but flights, in one transaction."""
        self.configuration = configuration
        with self._transaction():
            self._database.create()
            self._enter("configuration", json.dumps(configuration.dump(), allow_nan=False))
            self._enter("fingerprint", configuration.fingerprint)
            self._enter("reference", pack_reference(configuration.scenario.reference))
            self._note_opening()

    def _continue(self, configuration: Configuration) -> None:
        """Check that the study is the one asked for; take over a larger budget."""
        plain, asked = self._plain_configuration(), configuration.dump()
        self._database.rows("flight")  # nothing is added to what is damaged
        with self._database.decoding("its configuration"):
            difference = first_difference(plain, asked)
            rival, name, budget = load_rival(plain), str(plain["first_guess_name"]), int(plain["budget"])
        if difference is not None:
            key, mine, theirs = difference
            reason = f"this study has {_show(mine)}, asked for is {_show(theirs)}; another study needs another folder"
            raise StudyError(str(self.folder), key, reason)
        if asked["budget"] < budget:
            reason = f"this study has {budget} flights and may be given more, not {asked['budget']}"
            raise StudyError(str(self.folder), "budget", reason)
        self.configuration = replace(configuration, first_guess_name=name, rival=rival)
        with self._transaction():
            taken_over = {key: asked[key] for key in ("budget", "selection", "minutes")}
            self._enter("configuration", json.dumps({**plain, **taken_over}, allow_nan=False))
            self._note_opening()

    def _plain_configuration(self) -> dict[str, Any]:
        """The configuration as it was recorded."""
        text = self._entry("configuration")
        if text is None:
            raise self._database.damaged("it has lost its configuration")
        with self._database.decoding("its configuration"):
            return {**json.loads(text)}

    def _note_opening(self) -> None:
        """When, and with which versions."""
        moment = datetime.now().astimezone().isoformat(timespec="seconds")
        self._append("opening", moment, json.dumps(versions_now()))

    def _insert(self, ledger: Ledger) -> None:
        """Add flights."""
        floats = (
            ledger.cost,
            ledger.completion,
            ledger.failed_segment,
            ledger.mean_error,
            ledger.max_error,
            ledger.lap_time,
            ledger.accepted,
        )
        streams = [Stream(stream).name for stream in ledger.streams.tolist()]
        blobs = [parameters.astype("<f8").tobytes() for parameters in ledger.parameters]
        columns = (values.tolist() for values in floats)
        rows = zip(streams, ledger.numbers.tolist(), ledger.seeds.tolist(), blobs, *columns, strict=True)
        self._database.insert(_INSERT, ((*row, checksum(row)) for row in rows))

    def _append(self, table: str, *values: str) -> None:
        """Add a row to a table whose checksums are a chain."""
        last = self._database.execute(f"SELECT digest FROM {table} ORDER BY rowid DESC LIMIT 1")  # noqa: S608  a name of ours
        with self._database.decoding(f"what was recorded as {table}"):
            digest = checksum(values, last[0][0] if last else 0)
        marks = ", ".join("?" * (len(values) + 1))
        self._database.execute(f"INSERT INTO {table} VALUES ({marks})", (*values, digest))  # noqa: S608  likewise

    def _seconds(self, key: str) -> float:
        """A time [s], 0 where none is recorded."""
        with self._database.decoding(key):
            return float(self._entry(key) or 0.0)

    def _text(self, key: str) -> str:
        """A text, "" where none is recorded."""
        found = self._entry(key) or ""
        if not isinstance(found, str):
            raise self._database.damaged(f"{key} cannot be read back")
        return found

    def _entry(self, key: str) -> Any:
        """A value by its key, None if there is none."""
        rows = self._database.rows("entry", where="key = ?", values=(key,), order="key")
        return rows[0][1] if rows else None

    def _enter(self, key: str, value: str | bytes | float) -> None:
        """Set a value, within a transaction."""
        self._database.execute("INSERT OR REPLACE INTO entry VALUES (?, ?, ?)", (key, value, checksum((key, value))))

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        """All or nothing; the time since the last one is added to the wall time."""
        now = self._clock()
        with self._database.transaction():
            yield
            self._enter("wall_time", self.wall_time + now - self._mark)
        self._mark = now

    @contextmanager
    def _closed_on_error(self) -> Iterator[None]:
        try:
            yield
        except BaseException:
            self.close()
            raise


def new_folder(race: str, parent: Path = RUNS) -> Path:
    """Make a new folder `RACE-DATE` for a study.

    Raises:
        InputError: when it cannot be made.
    """
    name = re.sub(r"[^\w.-]+", "-", race).strip(".-") or "race"
    stem = f"{name}-{datetime.now().astimezone():%Y%m%d-%H%M%S}"
    for suffix in ("", *(f"-{k}" for k in range(2, 1000))):
        folder = parent / f"{stem}{suffix}"
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            continue
        except OSError as error:
            raise InputError(str(folder), "", f"cannot be made: {error.strerror}") from None
        return folder
    raise InputError(str(parent / stem), "", "exists already, a thousand times")


def _is_there(folder: Path) -> bool:
    """Whether a folder has something in the place of a study; a name that cannot be one is said by who opens it."""
    try:
        return (folder / FILE).exists()
    except (OSError, ValueError):
        return True


def count_flights(folder: str | Path) -> int:
    """Number of flights that a study has recorded, by one short query: cheap enough to be asked every second.

    Raises:
        StudyError: the study cannot be read.
    """
    database = Database(Path(folder), owned=False)
    try:
        return int(database.execute("SELECT COUNT(*) FROM flight")[0][0]) if database.format() else 0
    finally:
        database.close()


def _show(value: Any) -> str:
    """A value, shortened."""
    text = json.dumps(value)
    return text if len(text) <= 60 else text[:57] + "..."

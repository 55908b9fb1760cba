"""Film of a study: the flight with the best parameters, beside the flight with the default or the first guess."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from hotlap.core.counts import count
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.report.film.flight_frames import film_flights
from hotlap.report.film.frames import Titles, draw_frames
from hotlap.report.film.recording import RATES, Pixels, record
from hotlap.report.page.replay import BEST, DEFAULT, FIRST, choose
from hotlap.report.scene import stage
from hotlap.study.kept_guess import find_kept_guess
from hotlap.study.snapshot import Snapshot, begins_at_default
from hotlap.worlds.world import World

Progress = Callable[[str, int, int], AbstractContextManager[Callable[[str], None]]]
"""(unit, wanted, done) -> a context, in which to call what it gives with a few words on each piece that has ended."""

LONGEST = 13.0  # s of a film, at a pace of at least 1
PACES = (1, 1.25, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10, 15, 20, 30, 60)
NAMES = {DEFAULT: "before: default weights", FIRST: "before: first guess"}


@contextmanager
def silent(*_: object) -> Iterator[Callable[[str], None]]:
    """Progress that is not shown."""
    yield lambda _: None


def write_film(path: Path, snapshot: Snapshot, world: World, progress: Progress = silent) -> Path:
    """Fly the best parameters and the controller's default (or the first guess) once, and record them beside each other.

    Args:
        path: .gif or .mp4; its suffix decides.
        snapshot: of the study.
        world: where its flights happen.
        progress: shows how many frames are drawn.

    Returns:
        The file.

    Raises:
        InputError: when it cannot be written.
    """
    asked = snapshot.configuration
    scenario = asked.scenario
    known = choose(scenario, asked.first_guess, snapshot.best)
    best, before = known[0], known[1:][-1:]  # the default if there is one, else the first guess
    pace = pace_of(scenario.reference.duration)
    interval = pace / RATES[path.suffix.lower()]
    seed = int(flight_seeds(asked.settings.seed, Stream.DEMONSTRATION, 0, 1)[0])
    flights = film_flights(scenario, world, (*before, best), seed, interval)
    gates = count(len(scenario.race.track.counted), "gate")
    title = f"{scenario.race.name}: {gates}, planned in {scenario.reference.lap_time:.2f} s"
    slow = f"   at {pace:g} times real speed" if pace > 1 else "   real time"
    titles = Titles(title, slow, tuple(_label(flight.label, snapshot) for flight in flights))
    frames = draw_frames(stage(scenario), flights, titles, interval)
    with progress("frames", max(map(len, flights)), 0) as say:
        return record(path, _watched(frames, say))


def _watched(frames: Iterable[Pixels], say: Callable[[str], None]) -> Iterator[Pixels]:
    """The same frames; each is reported to the progress."""
    for frame in frames:
        yield frame
        say("drawing")


def pace_of(duration: float) -> float:
    """How many times faster than real time a flight is shown, so that the film lasts at most `LONGEST` seconds."""
    return next((pace for pace in PACES if duration / pace <= LONGEST), math.ceil(duration / LONGEST))


def _label(label: str, snapshot: Snapshot) -> str:
    """The title of a panel."""
    result = snapshot.result
    if label == FIRST and begins_at_default(snapshot.configuration):
        label = DEFAULT
    if label != BEST or result is None:
        return NAMES.get(label, label)
    kept = find_kept_guess(snapshot.configuration, result)
    if kept is not None:
        return f"after: the {kept.guess}, kept"
    return f"after: tuned in {count(result.search_flights, 'flight')}" if result.best.confirmed else "after: the best so far"

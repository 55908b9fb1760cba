"""Pictures: the figures of a study or a plan as files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from matplotlib.figure import Figure

from hotlap.analysis.sensitivity import survey_sensitivity
from hotlap.core.counts import count
from hotlap.core.errors import InputError
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.reference.scenario import Scenario
from hotlap.report.figures import convergence, inputs, samples, sensitivity, track, tracking_error, tuned_parameters
from hotlap.report.formats import FORMATS
from hotlap.report.history import Change, collect, compare, recount
from hotlap.report.page.replay import IN_SIMULATORS, choose, demonstrate
from hotlap.report.scene import Scene, stage
from hotlap.report.style import own_settings
from hotlap.study.snapshot import Snapshot, read_snapshot
from hotlap.study.study import Study
from hotlap.system.whole_files import written_whole
from hotlap.worlds.world import World, is_slow

FLIGHTS = 8  # of each set of parameters, all with the same noise; the first of each is drawn in full
SETS = 2  # the best, and the first guess, or the default where that is the best


def draw(folder: Path, study: Study, world: World, flights: int = FLIGHTS) -> tuple[Path, ...]:
    """Draw four pictures of a study: track, convergence, tracking error and parameters.

    The best parameters and the first guess (or the default) are flown again with new noise; nothing is chosen among these flights.

    Args:
        folder: where the pictures go.
        study: to be drawn; it may have no flights yet.
        world: where its flights happen.
        flights: how many of each to fly, at least 1.

    Returns:
        The files.

    Raises:
        InputError: when one cannot be written.
    """
    snapshot = read_snapshot(study)
    return _save_all(folder, _plain(snapshot, _fly(snapshot, world, flights)), FORMATS[0])


def draw_everything(folder: Path, study: Study, world: World, kind: str, flights: int = FLIGHTS) -> tuple[Path, ...]:
    """Draw all pictures of a study: those of `draw`, and inputs, sensitivity (unless flights take seconds) and samples of the search.

    Args:
        folder: where the pictures go.
        study: to be drawn; it may have no flights yet.
        world: where its flights happen.
        kind: one of `FORMATS`.
        flights: how many of each to fly, at least 1.

    Returns:
        The files.

    Raises:
        InputError: when one cannot be written.
    """
    return _save_all(folder, figures_of(read_snapshot(study), world, flights), kind)


def figures_of(snapshot: Snapshot, world: World, flights: int = FLIGHTS) -> dict[str, Figure]:
    """All figures of a study by their names.

    Args:
        snapshot: of the study; it may have no flights yet.
        world: where its flights happen.
        flights: how many of each set of parameters to fly, at least 1.
    """
    asked, best, scene = snapshot.configuration, snapshot.best, _fly(snapshot, world, flights)
    surveyed = {}
    if not is_slow(world):
        found = survey_sensitivity(asked.scenario, world, best, asked.settings.seed, asked.metric)
        surveyed["sensitivity"] = sensitivity(found, _change(snapshot), f"{scene.race}: sensitivity to the parameters", asked.metric_name)
    searched = collect(snapshot.ledger, asked.settings.goal)
    return {
        **_plain(snapshot, scene),
        "inputs": inputs(scene, asked.scenario),
        **surveyed,
        "samples": samples(searched, asked.scenario.space, best, f"{scene.race}: parameters of the search flights"),
    }


def _fly(snapshot: Snapshot, world: World, flights: int) -> Scene:
    """Fly the best parameters, and the first guess or the default, for the pictures."""
    asked, flights = snapshot.configuration, min(flights, IN_SIMULATORS) if is_slow(world) else flights
    sets = choose(asked.scenario, asked.first_guess, snapshot.best)[:SETS]
    return demonstrate(asked.scenario, world, sets, flight_seeds(asked.settings.seed, Stream.DEMONSTRATION, 0, flights))


def _plain(snapshot: Snapshot, scene: Scene) -> dict[str, Figure]:
    """The four figures that every study has."""
    return {
        "track": track(scene),
        "convergence": draw_convergence(snapshot),
        "error": tracking_error(scene),
        "parameters": tuned_parameters(_change(snapshot), f"{scene.race}: tuned parameters"),
    }


def draw_convergence(snapshot: Snapshot) -> Figure:
    """Completion and cost of a study over its flights."""
    asked = snapshot.configuration
    history = recount(snapshot.ledger, asked.settings.goal, asked.cost_name, snapshot.best if len(snapshot.ledger) else None)
    return convergence(history, f"{asked.scenario.race.name}: {asked.tuner}", _verdict(snapshot))


def _change(snapshot: Snapshot) -> Change:
    """First guess and best parameters."""
    scenario, first = snapshot.configuration.scenario, snapshot.configuration.first_guess
    return compare(scenario.space, scenario.segments, first, snapshot.best, scenario.race.controller.horizon_unit)


def _save_all(folder: Path, figures: Mapping[str, Figure], kind: str) -> tuple[Path, ...]:
    return tuple(save(folder / f"{name}.{kind}", figure) for name, figure in figures.items())


def draw_plan(path: Path, scenario: Scenario) -> None:
    """Draw a plan; the suffix of the file decides the format.

    Raises:
        InputError: for another suffix than those in `FORMATS`, or when the file cannot be written.
    """
    check_format(path)
    save(path, track(stage(scenario)))


def check_format(path: Path) -> str:
    """The format that a file's suffix asks for.

    Raises:
        InputError: when there is no such format.
    """
    suffix = path.suffix.removeprefix(".").lower()
    if suffix not in FORMATS:
        raise InputError(str(path), "", f"is no picture that can be drawn; it may end in {', '.join(f'.{name}' for name in FORMATS)}")
    return suffix


def save(path: Path, figure: Figure) -> Path:
    """Write a picture whole or not at all; returns its path.

    Raises:
        InputError: when it cannot be written.
    """
    kind = check_format(path)
    metadata = {"png": {"Software": "hotlap"}, "pdf": {"CreationDate": None}, "svg": {"Date": None}}[kind]
    with written_whole(path) as part, own_settings():
        figure.savefig(part, format=kind, metadata=metadata)
    return path


def _verdict(snapshot: Snapshot) -> str:
    """The result of a study so far, in one line."""
    result = snapshot.result
    if result is None:
        return "no flights yet"
    parts = [f"goal {result.goal}", f"{count(result.search_flights, 'search flight')}, {result.flights} with re-flights"]
    parts.append("confirmed" if result.best.confirmed else "not confirmed")
    if result.validation is not None:
        low, high = result.validation.interval
        share = f"{result.validation.successes} of {result.validation.flights}"
        parts.append(f"validated: {share} flights (95 % interval {100 * low:.0f} to {100 * high:.0f} %)")
    return "; ".join(parts)

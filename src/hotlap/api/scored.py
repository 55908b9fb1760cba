"""Scored: a flight that really happened, judged by a race's judge, beside simulated flights of the same race."""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hotlap import worlds
from hotlap.analysis.log_frame import LogFrame, find_frame
from hotlap.analysis.log_judge import ending, judge_log, missing
from hotlap.analysis.transfer import metres
from hotlap.api.asked import Asked
from hotlap.api.inputs import as_path, check_range, check_source, check_target
from hotlap.api.outcome import Outcome
from hotlap.api.scenarios import check_guess, fitting, load, make_ready, make_scenario, planned_as, read_guess, read_parameters
from hotlap.api.wording import share
from hotlap.core.parameters import Parameters
from hotlap.core.records import Flights, Scores
from hotlap.core.seeds import LARGEST_RUN_SEED, Stream, flight_seeds
from hotlap.core.success_rate import Validation
from hotlap.logs.flight_log import FlightLog
from hotlap.logs.key_map import asked_map
from hotlap.logs.readers import need, read
from hotlap.logs.window import check_window, cut
from hotlap.reference.scenario import Scenario
from hotlap.report.effort import Effort, effort_of
from hotlap.report.page.replay import LOGGED, typical
from hotlap.report.scene import Scene, Trace, repeat, stage, trace
from hotlap.system.text_files import replace as write_text
from hotlap.tuning.objective import Objective
from hotlap.tuning.scoring import score

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FLOWN, SIMULATED = "flown", "simulated"
MOST_FLIGHTS = 10_000
EFFORTS = ("thrust_activity", "rate_activity", "saturated")
PAGES = (".html", ".htm")


@dataclass(frozen=True, repr=False)
class ScoredFlight(Outcome):
    """A flight that really happened, and simulated ones.

    Attributes:
        scenario: that was flown.
        log: of the flight.
        frame: where the log lies in the race.
        flights: the flight as the judge has seen it, with its record; one.
        scores: what it was worth.
        simulated: flights of the same race in the built-in world.
        simulated_scores: what they were worth.
        scene: both as they are drawn, the flight first, then a simulated one from the middle of all.
        efforts: of the commands of these two.
        notes: what was assumed, a line each.
        page: that was written; None where none was asked for.
    """

    scenario: Scenario
    log: FlightLog
    frame: LogFrame
    flights: Flights
    scores: Scores
    simulated: Flights
    simulated_scores: Scores
    scene: Scene
    efforts: tuple[Effort, Effort]
    notes: tuple[str, ...]
    page: Path | None = None

    @property
    def flown(self) -> Trace:
        """The flight, with its time series."""
        return self.scene.traces[0]

    @property
    def complete(self) -> Validation:
        """How many simulated flights passed every gate, with the interval of that share."""
        return Validation(len(self.simulated_scores), int(self.simulated_scores.complete.sum()))

    def figures(self) -> list[tuple[str, str, str]]:
        """What was measured, of the flight and of the simulated ones, in words."""
        mine, others = self.scores, self.simulated_scores
        laps = others.lap_time[others.complete]
        gates = len(self.flights.gate_positions)
        passed = f"{self.flights.gates_passed[0]} of {gates}{'' if mine.complete[0] else f': {self.flown.ending}'}"
        rows = [
            ("gates", passed, f"all in {share(self.complete)}"),
            ("lap time", _seconds(float(mine.lap_time[0])), _seconds(float(laps.mean())) if len(laps) else "-"),
            ("mean error", f"{metres(float(mine.mean_error[0]))} m", f"{metres(float(np.nanmean(others.mean_error)))} m"),
            ("largest error", f"{metres(float(mine.max_error[0]))} m", f"{metres(float(np.nanmax(others.max_error)))} m"),
        ]
        mine_told, others_told = map(_effort_words, self.efforts)
        return [*rows, ("command effort", mine_told, others_told)]

    def facts(self) -> dict[str, str]:
        """Race and log, and what was measured, simulated in brackets."""
        title = f"{self.scenario.race.name}: {self.log.name}, {self.log.kind}"
        told = {name: f"{mine} (simulated: {others})" for name, mine, others in self.figures()}
        place = f"race begins at {self.frame.start:.3f} s of the log; {self.frame.words}"
        return {"race": title, **told, "time and frame": place, "page": str(self.page or "")}

    def rows(self) -> list[dict[str, Any]]:
        """A row for each gate: distance and time, flown and simulated."""
        flown, other = self.scene.traces[:2]
        columns = {
            "gate": [point.name for point in self.scenario.race.track.route if point.counts],
            "passed": (np.arange(len(flown.gate_distance)) < flown.gates_passed).tolist(),
            "distance": flown.gate_distance.tolist(),
            "time": flown.seen_times.tolist(),
            "simulated_distance": other.gate_distance.tolist(),
            "simulated_time": other.seen_times.tolist(),
            "planned_time": self.scenario.reference.gate_times.tolist(),
        }
        return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]

    def to_dict(self) -> dict[str, Any]:
        """The keys of `hotlap score --json`."""
        mine, others = self.scores, self.simulated_scores
        return {
            "race": self.scenario.race.name,
            "log": self.log.name,
            "kind": self.log.kind,
            "completion": float(mine.completion[0]),
            "gates_passed": int(self.flights.gates_passed[0]),
            "ending": self.flown.ending,
            "lap_time": float(mine.lap_time[0]),
            "planned_lap_time": self.scenario.reference.lap_time,
            "mean_error": float(mine.mean_error[0]),
            "max_error": float(mine.max_error[0]),
            "cost": float(mine.cost[0]),
            "effort": _effort(self.efforts[0]),
            "start": self.frame.start,
            "yaw": self.frame.yaw,
            "shift": self.frame.shift.tolist(),
            "residual": self.frame.residual,
            "notes": list(self.notes),
            "simulated": {
                "flights": len(others),
                "successes": self.complete.successes,
                "lap_time": float(np.nanmean(others.lap_time)) if others.complete.any() else math.nan,
                "mean_error": float(np.nanmean(others.mean_error)),
                "max_error": float(np.nanmax(others.max_error)),
                "effort": _effort(self.efforts[1]),
            },
            "gates": self.rows(),
            "page": None if self.page is None else str(self.page),
        }

    def plot(self) -> Figure:
        """Both flights over the plan, from above and from the side."""
        from hotlap.report.track_view import track  # noqa: PLC0415  matplotlib, only where there is something to draw

        return track(self.scene)


def carry_out(asked: Asked) -> ScoredFlight:
    """Check what was asked for, read the log, judge it, fly beside it."""
    check_range("flights", asked.flights, 1, MOST_FLIGHTS)
    check_range("seed", asked.seed, 0, LARGEST_RUN_SEED)
    check_source(as_path(asked.reference))
    check_window(asked.window)
    page = as_path(asked.out)
    check_target(page, PAGES)
    race = load(asked.race, asked.controller)
    check_guess(str(asked.first_guess))
    log = cut(read(asked.log, asked_map(asked.map)), asked.window)
    need(log, ("position",), "the judge of a race")
    race = planned_as(race, asked.first_guess if asked.parameters is None else asked.parameters) if asked.reference is None else race
    scenario = make_scenario(race, asked)
    frame, world = find_frame(log, scenario, align=asked.align, start=asked.start), worlds.build("built-in", 1)
    make_ready(world, scenario, asked.progress)
    with asked.progress.working(f"judging {log.name}"):
        flights = judge_log(log, scenario, frame)
    seeds = flight_seeds(asked.seed, Stream.DEMONSTRATION, 0, asked.flights)
    parameters = np.repeat(_parameters(asked, scenario)[None], len(seeds), axis=0)
    simulated, scores = Objective(scenario, world).fly_recorded(parameters, seeds, log=range(min(LOGGED, len(seeds))))
    one = replace(trace(scenario, flights, 0, FLOWN), ending=ending(scenario, flights, log, frame))
    whole = slice(0, len(seeds))
    other = trace(scenario, simulated, typical(simulated, whole), SIMULATED)
    scene = stage(scenario, (one, other), (repeat(race, flights, slice(0, 1), FLOWN), repeat(race, simulated, whole, SIMULATED)))
    efforts = effort_of(one, scenario)[0], effort_of(other, scenario)[0]
    notes = (*log.notes, *missing(log, frame))
    mine = score(flights, race.judge)
    scored = ScoredFlight(scenario, log, frame, flights, mine, simulated, scores, scene, efforts, notes, page)
    if page is not None:
        _write(page, scored, asked)
    return scored


def _parameters(asked: Asked, scenario: Scenario) -> Parameters:
    """What is flown in the simulation, shape (S, K)."""
    given = asked.parameters
    if given is None:
        return read_guess(str(asked.first_guess), scenario, asked.progress)
    return read_parameters(Path(given), scenario, asked.progress) if isinstance(given, str | Path) else fitting(given, scenario)


def _write(page: Path, scored: ScoredFlight, asked: Asked) -> None:
    """The page, whose pictures are within it."""
    from hotlap.report.score_article import compose_article  # noqa: PLC0415  only where there is something to show

    with tempfile.TemporaryDirectory() as folder:
        article = compose_article(
            Path(folder), scored.scene, scored.scenario, scored.facts(), scored.figures(), scored.rows(), scored.notes, asked.command()
        )
        write_text(page, article.html)


def _seconds(time: float) -> str:
    return f"{time:.2f} s" if math.isfinite(time) else "-"


def _effort(effort: Effort) -> dict[str, float]:
    return {name: getattr(effort, name) for name in EFFORTS}


def _effort_words(effort: Effort) -> str:
    """How fast commands change, and how long they are at a limit."""
    if not effort.rate_activity:
        return "-"
    saturated = f"{100 * effort.saturated:.0f} % at a limit"
    return f"thrust {effort.thrust_activity:.0f} m/s^3, rates {effort.rate_activity:.0f} rad/s^2, {saturated}"

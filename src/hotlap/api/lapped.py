"""Lapped: a real vehicle flown once, and how that went."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hotlap.analysis.log_frame import find_frame
from hotlap.analysis.log_judge import ending, judge_log
from hotlap.api.asked import Asked
from hotlap.api.flown import write_log
from hotlap.api.inputs import as_path, check_source, check_target, one_of
from hotlap.api.outcome import Outcome
from hotlap.api.progress import Progress
from hotlap.api.scenarios import fitting, load, make_ready, make_scenario, planned_as, read_parameters
from hotlap.api.wording import share
from hotlap.core.errors import HotlapError, InputError
from hotlap.core.parameters import Parameters
from hotlap.core.records import Flights, Scores
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.core.success_rate import Validation
from hotlap.logs.hotlap_csv import read_hotlap_csv
from hotlap.real_flight import open_link
from hotlap.real_flight.geofence import MARGIN
from hotlap.real_flight.guard import STRAY, Halt
from hotlap.real_flight.link import Request
from hotlap.real_flight.settings import FlightSettings, Flown, Phase
from hotlap.real_flight.speaker import Speaker
from hotlap.reference.scenario import Scenario
from hotlap.tuning.objective import Objective
from hotlap.tuning.scoring import score
from hotlap.worlds.built_in import BuiltIn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hotlap.real_flight.flight import RealFlight

REHEARSED, HOLDS = 100, 0.9  # flights, and the share of them that has to pass every gate
WAIT = 10.0  # s
LOOKING = 10.0  # s of a dry run
LEAST_ROWS = 2  # of a log that can be judged


@dataclass(frozen=True, repr=False)
class LapResult(Outcome):
    """A real flight.

    Attributes:
        scenario: what was flown.
        vehicle: what has flown it, in words.
        flown: the flight; None: a dry run.
        flights: the flight as the judge of the race sees it; None: it did not begin the race.
        scores: what it was worth; likewise.
        ending: how it ended, by the judge, in words; "" likewise.
        log: that was written; None: nothing was flown.
    """

    scenario: Scenario
    vehicle: str
    flown: Flown | None
    flights: Flights | None = None
    scores: Scores | None = None
    ending: str = ""
    log: Path | None = None

    @property
    def stopped(self) -> str:
        """What has stopped it, in words; "" where it went to its end."""
        return "" if self.flown is None or self.flown.halt is None else f"{self.flown.halt} (during {self.flown.phase})"

    def facts(self) -> dict[str, str]:
        """Gates passed, lap, errors; what has stopped it; what hovering has shown."""
        known = {"race": f"{self.scenario.race.name}: {'a dry run' if self.flown is None else 'flown'} on {self.vehicle}"}
        if self.flown is None:
            return known
        if self.flights is not None and self.scores is not None:
            gates, scores = len(self.flights.gate_positions), self.scores
            passed = f"{self.flights.gates_passed[0]} of {gates}"
            known["gates"] = passed if scores.complete[0] else f"{passed}: {self.ending}"
            known["lap time"] = f"{scores.lap_time[0]:.2f} s" if math.isfinite(scores.lap_time[0]) else "-"
            known["mean error"] = f"{scores.mean_error[0]:.2f} m from the reference"
            known["largest error"] = f"{scores.max_error[0]:.2f} m"
        if math.isfinite(self.flown.gain):
            known["thrust"] = f"{self.flown.gain:.2f} of the file's, by hovering"
        return {**known, "stopped": self.stopped}

    def rows(self) -> list[dict[str, Any]]:
        """A row for each gate: whether it was passed, and how far from it."""
        if self.flights is None:
            return []
        names = [point.name for point in self.scenario.race.track.route if point.counts]
        passed = (np.arange(len(names)) < self.flights.gates_passed[0]).tolist()
        distances = self.flights.clock_distance[0].tolist()
        return [{"gate": name, "passed": one, "distance": away} for name, one, away in zip(names, passed, distances, strict=True)]

    def to_dict(self) -> dict[str, Any]:
        """The keys of `hotlap lap --json`."""
        flown, scores = self.flown, self.scores
        return {
            "race": self.scenario.race.name,
            "vehicle": self.vehicle,
            "dry_run": flown is None,
            "phase": None if flown is None else flown.phase.value,
            "stopped": None if flown is None or flown.halt is None else flown.halt.reason.name.lower(),
            "detail": self.stopped,
            "thrust_gain": None if flown is None or math.isnan(flown.gain) else flown.gain,
            "geofence": None if flown is None else flown.geofence.to_dict(),
            "completion": None if scores is None else float(scores.completion[0]),
            "lap_time": None if scores is None else float(scores.lap_time[0]),
            "mean_error": None if scores is None else float(scores.mean_error[0]),
            "max_error": None if scores is None else float(scores.max_error[0]),
            "gates": self.rows(),
            "log": None if self.log is None else str(self.log),
        }

    def plot(self) -> Figure:
        """The flight over the reference, from above and from the side.

        Raises:
            InputError: it did not begin the race.
        """
        from hotlap.report.scene import repeat, stage, trace  # noqa: PLC0415  matplotlib, only where there is something to draw
        from hotlap.report.track_view import track  # noqa: PLC0415

        if self.flights is None:
            raise InputError("", "", "there is no flight to draw: it did not begin the race")
        label = "flown"
        one = replace(trace(self.scenario, self.flights, 0, label), ending=self.ending)
        return track(stage(self.scenario, (one,), (repeat(self.scenario.race, self.flights, slice(0, 1), label),)))


def carry_out(asked: Asked) -> LapResult:
    """Check what was asked for, rehearse it, and fly it."""
    from hotlap.real_flight.flight import RealFlight  # noqa: PLC0415  the flight core loads a compiler

    settings = _settings(asked)
    log = as_path(asked.log) or _log_name(asked)
    check_source(as_path(asked.reference))
    check_target(None if asked.dry_run else log)
    race = load(asked.race, asked.controller)
    link = open_link(asked.on, race.controller.period, mute=asked.dry_run)
    try:
        race = planned_as(race, asked.parameters) if asked.reference is None else race
        scenario = make_scenario(race, asked)
        parameters = _parameters(asked, scenario)
        if asked.rehearsal:
            _rehearse(scenario, parameters, asked.progress)
        speaker = Speaker(asked.progress.note)
        with asked.progress.working("making the controller ready"):
            flight = RealFlight(link, scenario, parameters, settings, speaker)
    except BaseException:
        link.close()
        raise
    with speaker:
        if not asked.dry_run:
            return _fly(flight, scenario, log, speaker)
        try:
            flight.look(LOOKING)
        except Halt as halt:
            raise InputError("", "on", f"{link.name}: {halt}") from None
        return LapResult(scenario, link.name, None)


def _fly(flight: RealFlight, scenario: Scenario, log: Path, say: Callable[[str], None]) -> LapResult:
    """Fly, and write what was flown, however it ended."""
    try:
        flown = flight.fly()
    except BaseException as error:
        if flight.phase is not Phase.MEET:
            written = _write(log, flight, scenario, say)
            kept = "" if written is None else f"; its flight is in {written}"
            asked = f"was asked to {flight.asked_to}" if flight.asked_to else "does not follow hotlap, and was not asked to stop"
            error.add_note(f"the vehicle {asked}{kept}")
        raise
    if flown.halt is not None and flown.phase in {Phase.MEET, Phase.ENGAGE}:
        raise InputError("", "on", f"{flown.vehicle}: {flown.halt}")
    written = _write(log, flight, scenario, say)
    if written is None or flown.record.race_begun is None or flown.record.log(1).times[-1] <= 0:
        return LapResult(scenario, flown.vehicle, flown, log=written)
    read = read_hotlap_csv(written)
    frame = find_frame(read, scenario)
    flights = judge_log(read, scenario, frame)
    ended = ending(scenario, flights, read, frame)
    return LapResult(scenario, flown.vehicle, flown, flights, score(flights, scenario.race.judge), ended, written)


def _write(log: Path, flight: RealFlight, scenario: Scenario, say: Callable[[str], None]) -> Path | None:
    """Write the log of what was flown, if that is anything; where it is. A flight is not lost over a disk that is full."""
    if len(flight.stream.record.seen) < LEAST_ROWS:
        return None
    for place in (log, Path(tempfile.gettempdir()) / log.name):
        try:
            write_log(place, flight.stream.record.log(scenario.race.vehicle.rotor_count))
        except (HotlapError, OSError) as error:
            say(f"the log is not written: {error}")
        else:
            return place
    return None


def _settings(asked: Asked) -> FlightSettings:
    """How it is to be flown.

    Raises:
        InputError: a setting is none.
    """
    requests = [request.value for request in (Request.LAND, Request.HOLD, Request.DISARM)]
    if asked.on_stop not in requests:
        raise InputError("", "on_stop", f"must be one of {', '.join(requests)}, not '{asked.on_stop}'")
    automatic = {"wait": WAIT, "margin": MARGIN, "stray": STRAY}
    limits = {key: value if getattr(asked, key) is None else getattr(asked, key) for key, value in automatic.items()}
    for key, value in limits.items():
        if not 0 < value < math.inf:
            raise InputError("", key, f"must be above 0, not {value:g}")
    if not 0 <= asked.throttle_curve <= 1:
        raise InputError("", "throttle_curve", f"must be from 0 to 1, not {asked.throttle_curve:g}")
    request = one_of(Request, asked.on_stop, "request", "on_stop")
    return FlightSettings(
        arm=asked.arm,
        on_stop=request,
        geofence=asked.geofence,
        origin=asked.origin,
        curve=asked.throttle_curve,
        with_battery=asked.battery,
        **limits,
    )


def _parameters(asked: Asked, scenario: Scenario) -> Parameters:
    """What is flown, shape (S, K)."""
    given = asked.parameters
    return read_parameters(Path(given), scenario, asked.progress) if isinstance(given, str | Path) else fitting(given, scenario)


def _rehearse(scenario: Scenario, parameters: Parameters, progress: Progress) -> None:
    """Fly the same in simulation; what does not hold there is not flown here.

    Raises:
        InputError: it does not.
    """
    world, seeds = BuiltIn(), flight_seeds(0, Stream.DEMONSTRATION, 0, REHEARSED)
    make_ready(world, scenario, progress)
    with progress.working(f"flying {scenario.race.name} {REHEARSED} times in simulation first"):
        _, scores = Objective(scenario, world).fly_recorded(np.repeat(parameters[None], REHEARSED, axis=0), seeds, log=())
    passed = Validation(REHEARSED, int(scores.complete.sum()))
    if scores.complete.mean() < HOLDS:
        reason = f"pass every gate in {share(passed)} in simulation, too few for a real flight; rehearsal=... says not to ask"
        raise InputError("", "parameters", reason)
    progress.note(f"in simulation all gates in {share(passed)}")


def _log_name(asked: Asked) -> Path:
    """A file that is named by race and time."""
    name = Path(asked.race).stem if isinstance(asked.race, str | Path) else asked.race.name
    return Path(f"{name}-{datetime.now().astimezone():%Y%m%d-%H%M%S}.csv")

"""AutoTune on a physical platform (a figure of the paper), with Betaflight's firmware in the place of the platform.

The paper tunes in simulation and flies the double Split-S on a real drone, with weights by a human and with tuned ones. Here the tuned
weights and hotlap's default ones are flown by the firmware that real drones have; airframe and sensors are simulated. Tuned is twice: for
the drone with the rate loop of its file, and with the one that the firmware has.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hotlap import tuners, worlds
from hotlap.analysis.learning import built_in_world
from hotlap.analysis.resumable import ResumableJobs
from hotlap.analysis.transfer import DEFAULT, STARTING, TUNED, Journey, TransferRow, metres, rows_of
from hotlap.core.counts import count
from hotlap.core.errors import InputError
from hotlap.core.parameters import Parameters
from hotlap.core.records import Flights
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.files.descriptions import load_race
from hotlap.first_guess.guess import first_guess
from hotlap.planning.preparation import prepare
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import Race
from hotlap.reference.scenario import Scenario
from hotlap.report.article import Article
from hotlap.report.transfer_article import CAPTIONS, HEADS, cells_of, changes, endings
from hotlap.reproduce.early_turns import sets_of, tell_early_turns
from hotlap.reproduce.experiments import UnavailableError
from hotlap.reproduce.published import REAL_WORLD, REAL_WORLD_MEDIANS
from hotlap.system.engine import Engine
from hotlap.tuning.goal import Goal, Quantity
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune
from hotlap.tuning.objective import Objective
from hotlap.worlds.betaflight.gains import as_flown

WORLD, RACE = "betaflight", "split-s"
KNOWN = "tuned for the firmware"
FLIGHTS, BUDGET, SELECTION = 3, 200, 50
OUT_OF_REACH = 1e-3  # m: a goal that no controller reaches, so that the search looks for the least error until its budget is spent
UNKNOWN_DELAY = 0.045  # s, as in the default suite


@dataclass(frozen=True)
class HomeJob:
    """A race on which the mean tracking error is to be made as small as possible."""

    race: Race
    budget: int


class AsFlown:
    """The built-in world with the rate loop and the mixer that the firmware has.

    Attributes:
        name: what it is called.
        takes_vehicle_parameters: False.
    """

    name = "built-in, firmware's loop"
    takes_vehicle_parameters = False

    def fly(
        self,
        scenario: Scenario,
        parameters: Parameters,
        seeds: NDArray[np.int64],
        *,
        vehicle_parameters: NDArray[np.float64] | None = None,
        log: Sequence[int] = (),
    ) -> Flights:
        """Fly a batch, as `World.fly` says."""
        race = flown_by(scenario.race, as_flown(scenario.race.vehicle))
        return built_in_world().fly(replace(scenario, race=race), parameters, seeds, vehicle_parameters=vehicle_parameters, log=log)


def tune_at_home(wanted: HomeJob) -> Iterator[list[list[float]]]:
    """The best parameters that the default tuner finds from the default weights, shape (S, K)."""
    tuner = tuners.build(tuners.DEFAULT)
    scenario = scenario_for(prepare(wanted.race), tuner)
    goal = Goal(Quantity.MEAN_ERROR, OUT_OF_REACH)
    settings = TuningSettings(goal=goal, budget=wanted.budget, validation=0, reliability=0.0, selection=SELECTION)
    run = Tuning(tuner, scenario, settings, first_guess(scenario, DEFAULT))
    for _ in tune(Objective(scenario, built_in_world(), goal.metric), run):
        pass
    assert run.best is not None, "it has flown"  # noqa: S101  our own mistake
    yield run.best.parameters.tolist()


def real_world(jobs: ResumableJobs, *, quick: bool) -> Article:
    """Tuned at home, flown by a real firmware: tracking errors beside those of the paper's real drone."""
    flights, budget = (1, 20) if quick else (FLIGHTS, BUDGET)
    races = _races(quick=quick)
    with _available():
        journeys = {name: _journey(race, flights, jobs.cluster) for name, race in races.items()}
        next(iter(journeys.values())).open(jobs.folder)  # what is not installed is told before anything is tuned
    vehicles = {TUNED: races, KNOWN: {name: flown_by(race, as_flown(race.vehicle)) for name, race in races.items()}}
    wanted = {f"{name}, {label}": HomeJob(race, budget) for label, each in vehicles.items() for name, race in each.items()}
    found = {key: np.array(parameters) for key, parameters in jobs.each("tunings", wanted, tune_at_home).items()}
    page = Article("The physical platform, with a real firmware in its place")
    _introduce(page, flights, budget)
    again = dict[str, list[TransferRow]]()
    for name, journey in journeys.items():
        with _available():
            sets = {**journey.sets, **{label: found[f"{name}, {label}"] for label in vehicles}}
            flown = replace(journey, sets=sets).fly(jobs.folder, jobs.progress, jobs.note)
        _show(jobs, page, name, rows_of(flown))
        if not quick:
            with _available():
                again[name] = rows_of(_early(journey).fly(jobs.folder, jobs.progress, jobs.note))
    if again:
        some = journeys[RACE]
        tell_early_turns(page, some.scenario, some.sets[DEFAULT], again)
    return page


def _races(*, quick: bool) -> dict[str, Race]:
    """The paper's track as hotlap describes it, and flown by a drone with dead time that its controller does not know of."""
    race = load_race(RACE)
    if quick:
        return {RACE: race}
    late = flown_by(race, race.vehicle.model_copy(update={"delay": UNKNOWN_DELAY}))
    return {RACE: race, f"{RACE}-late": late.model_copy(update={"name": f"{RACE}-late"})}


def flown_by(race: Race, vehicle: Quadrotor) -> Race:
    """A race that another drone flies, of which plan and controller know nothing."""
    planning = race.planning.model_copy(update={"quadrotor": race.planning_model})
    return race.model_copy(update={"vehicle": vehicle, "model": race.control_model, "planning": planning})


def _journey(race: Race, flights: int, cluster: Engine | None) -> Journey:
    """Flights with the default weights, at home and abroad; the tuned ones are still to be found."""
    scenario = prepare(race)
    sets: Mapping[str, Parameters] = {DEFAULT: first_guess(scenario, DEFAULT)}
    everywhere = (built_in_world(), AsFlown(), worlds.build(WORLD, 1, cluster))
    return Journey(scenario, sets, everywhere, flight_seeds(0, Stream.DEMONSTRATION, 0, flights))


def _early(journey: Journey) -> Journey:
    """Flights with the default weights and a short horizon, by the firmware and by what is nearest to it."""
    _, *worlds = journey.worlds
    return replace(journey, sets=sets_of(journey.scenario, journey.sets[DEFAULT]), worlds=tuple(worlds))


@contextmanager
def _available() -> Iterator[None]:
    """A firmware that cannot be flown is something that is not installed."""
    try:
        yield
    except InputError as error:
        if error.source or error.key != "on":
            raise
        raise UnavailableError("", "", error.reason) from None


def _introduce(page: Article, flights: int, budget: int) -> None:
    """What it is, and what it is not; and what the paper found."""
    page.say(
        f"The paper tunes in simulation and flies the double Split-S on a real drone. Here {count(flights, 'flight')} with each set of "
        "weights are flown by *Betaflight*, the firmware of most racing drones, unmodified: rate loop and mixer are the real ones, "
        "airframe, motors and sensors are simulated. **No real drone has flown.** The weights of the paper's human are not published; "
        "hotlap's default weights stand for them. The tuned ones were found in the built-in world by the default tuner, from the default "
        f"weights, in {budget} flights for the least mean tracking error: *{TUNED}* for the drone as its file has it, *{KNOWN}* for the "
        "drone with the rate loop and the mixer that the firmware's settings amount to. All worlds have the same noise. It draws where a "
        f"flight begins, up to 0.14 m beside the reference here: the largest error is looked for from {STARTING:g} s on (in the published "
        "flights in all of them)."
    )
    page.head("Published: a real drone")
    page.table(
        ("weights", "mean error [m]", "largest error [m]", "median of all steps [m]"),
        [
            [f"{name} (published)", *(" / ".join(f"{value:.2f}" for value in values) for values in errors), REAL_WORLD_MEDIANS[name]]
            for name, errors in REAL_WORLD.items()
        ],
    )
    (human, most), (tuned, least) = (map(np.mean, REAL_WORLD[name]) for name in ("human", "AutoTune"))
    mean, largest = (f"{100 * (now / before - 1):+.0f} %" for now, before in ((tuned, human), (least, most)))
    page.say(f"Tuned against human, by the means of the flights: mean error {mean}, largest error {largest}; the paper says -6 and -12 %.")


def _show(jobs: ResumableJobs, page: Article, name: str, rows: list[TransferRow]) -> None:
    """One race: table, changes, both charts."""
    from hotlap.report.transfer_charts import draw_transfer  # noqa: PLC0415  matplotlib takes half a second to load

    late = f"{RACE}, with {1e3 * UNKNOWN_DELAY:.0f} ms of dead time that the controller does not know of"
    page.head(f"{RACE} as it is" if name == RACE else late)
    medians = [metres(float(np.median(row.errors))) for row in rows]
    page.table((*HEADS, "median [m]"), [[*cells, middle] for cells, middle in zip(cells_of(rows), medians, strict=True)])
    for line in changes(rows):
        page.say(line)
    for world, label, ended in endings(rows):
        page.say(f"{world}, {label}: {ended}")
    for path, caption in zip(draw_transfer(jobs.folder, name, rows, f"{name}-"), CAPTIONS, strict=True):
        page.picture(path, f"{name}: {caption[0].lower()}{caption[1:]}")

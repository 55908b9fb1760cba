"""`hotlap fly RACE`: given parameters once more, with fresh noise."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import Any

import numpy as np

from hotlap import worlds
from hotlap.cli.flying import check_guess, load, make_ready, make_scenario, read_guess, read_parameters
from hotlap.cli.inputs import check_range, check_source, check_target
from hotlap.cli.output import present, working
from hotlap.cli.summary import describe_flights
from hotlap.core.records import End, Flights, Log, Scores
from hotlap.core.seeds import LARGEST_RUN_SEED, Stream, flight_seeds
from hotlap.files.descriptions import load_parameters
from hotlap.system.text_files import replace
from hotlap.tuning.objective import Objective

MOST_FLIGHTS = 100_000
COLUMNS = (
    *("t", "p_x", "p_y", "p_z", "q_w", "q_x", "q_y", "q_z", "v_x", "v_y", "v_z", "w_x", "w_y", "w_z"),
    *("u_1", "u_2", "u_3", "u_4", "command_thrust", "command_w_x", "command_w_y", "command_w_z"),
)


def run(options: Namespace) -> int:
    """Fly them, and say how they ended; drones that crash are a result, not a failure."""
    check_range("--flights", options.flights, 1, MOST_FLIGHTS)
    check_range("--seed", options.seed, 0, LARGEST_RUN_SEED)
    check_source(options.reference)
    check_target(options.log)
    world, race = worlds.build(options.on), load(options)
    if options.parameters is not None and options.parameters.is_file():
        load_parameters(options.parameters)
    check_guess(options.first_guess)
    scenario = make_scenario(race, options)
    parameters = read_guess(options.first_guess, scenario) if options.parameters is None else read_parameters(options.parameters, scenario)
    make_ready(world, scenario)
    seeds = flight_seeds(options.seed, Stream.DEMONSTRATION, 0, options.flights)
    with working(f"flying {race.name} {options.flights} times"):
        repeated = np.repeat(parameters[None], options.flights, axis=0)
        flights, scores = Objective(scenario, world).fly_recorded(repeated, seeds, log=() if options.log is None else (0,))
    if options.log is not None:
        write_log(options.log, flights.logs[0])
    rows = _rows(flights, scores)
    document = {"race": race.name, "world": world.name, "flights": rows}
    lines = list(describe_flights(scenario, flights, scores))
    present(as_json=options.json, document=document, lines=[*lines, *([f"log written to {options.log}"] if options.log else [])])
    return 0


def write_log(path: Path, log: Log) -> None:
    """One flight as CSV: time, state, rotor thrusts and command of each step."""
    table = np.column_stack([log.times, log.states, log.rotor_thrusts, log.commands])
    lines = [",".join(COLUMNS), *(",".join(map(repr, row)) for row in table.tolist())]
    replace(path, "\n".join(lines) + "\n")


def _rows(flights: Flights, scores: Scores) -> list[dict[str, Any]]:
    """What `hotlap fly --json` says of each flight; null where there is nothing to say."""
    failed = [None if segment < 0 else segment for segment in scores.failed_segment.tolist()]
    columns = {
        "seed": flights.seeds.tolist(),
        "completion": scores.completion.tolist(),
        "lap_time": scores.lap_time.tolist(),
        "cost": scores.cost.tolist(),
        "end": [End(end).name.lower() for end in flights.end.tolist()],
        "failed_segment": failed,
        "mean_error": scores.mean_error.tolist(),
        "max_error": scores.max_error.tolist(),
    }
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]

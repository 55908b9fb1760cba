"""Mean error of the MPC over its settings, on a plant that is its model, without noise: python benchmarks/settings.py [RACE ...]

A row for each number of nodes and horizon, a column for each period and number of sweeps; "-" is refused. The weights are the defaults.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from flight.perfect_plant import mean_error
from flight.test_line_search import WEIGHTS, drag_free
from hotlap.race.controllers import ControllerKind
from hotlap.race.race import ControllerSettings
from hotlap.reference.scenario import Scenario

NODES, HORIZONS, PERIODS, SWEEPS = (2, 5, 10, 18, 20, 40, 60, 100), (0.5, 2.0, 3.5), (0.0025, 0.01, 0.05), (1, 2, 10)


def cell(scenario: Scenario, solver: str | None, nodes: int, horizon: float, period: float, sweeps: int) -> str:
    """Mean error [m]."""
    bounds = {
        "low": (1.0, 100.0, 1.0, 1.0, 0.1),
        "high": (1000.0, 1500.0, 100.0, 1000.0, 2 * horizon),
        "default": (9.0, 100.0, 9.0, 9.0, 0.2),
    }
    kept = scenario.race.controller.model_dump(exclude={"low", "high", "default"})
    changes = {"solver": solver, "nodes": nodes, "period": period, "sweeps": sweeps, "predict": False}
    quiet = {"offset_free": False, "reference_drag": False, "kind": ControllerKind.MPC}
    try:
        controller = ControllerSettings(**{**kept, **bounds, **changes, **quiet})
    except ValueError:
        return "-"
    flown = Scenario(scenario.race.model_copy(update={"controller": controller}), scenario.reference, scenario.segments)
    return f"{mean_error(flown, np.array([*WEIGHTS['default'], 2 * horizon])):.3f}"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("races", nargs="*", default=["circle-34", "split-s"])
    parser.add_argument("--solver", choices=["real_time", "line_search"], help="instead of the one that a race would have")
    asked = parser.parse_args()
    columns = [(period, sweeps) for period in PERIODS for sweeps in SWEEPS]
    for race in asked.races:
        scenario = drag_free(race)
        print(f"\n| {race}: nodes | horizon | {' | '.join(f'{1e3 * p:g} ms, {n}' for p, n in columns)} |\n|{'---|' * (2 + len(columns))}")
        for nodes in NODES:
            for horizon in HORIZONS:
                cells = [cell(scenario, asked.solver, nodes, horizon, period, sweeps) for period, sweeps in columns]
                if set(cells) != {"-"}:
                    print(f"| {nodes} | {horizon:g} s | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()

"""Completion and tracking error of the controller in flight: python benchmarks/controller_quality.py [--flights 192]

Tables over the number of Riccati sweeps, and over the dead time, in the controller's model or not.
"""

from __future__ import annotations

import argparse

import numpy as np

from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare
from hotlap.race.race import Race
from hotlap.reference.scenario import Scenario
from hotlap.tuning.scoring import score
from hotlap.worlds.built_in import BuiltIn

TABLE_I = ("circle-20", "circle-34", "drop-20", "flip-16", "spiral-53", "qualifier-20", "final-22")
TUNED = (33.5, 357.0, 44.0, 7.1, 6.0)  # one set of parameters that passes every gate of every race of the default suite
SWEEPS = (1, 2, 3, 5)
DEAD_TIMES = (0.0, 0.02, 0.045, 0.05, 0.1)  # s


def fly(scenario: Scenario, values: np.ndarray, scatter: float, flights: int) -> str:
    """Mean completion and share of complete flights [%], and mean error of the complete flights [m]."""
    space, rng = scenario.space, np.random.default_rng(0)
    scattered = space.clip(values * np.exp(scatter * space.log_step * rng.standard_normal((flights, space.size))))
    parameters = np.repeat(scattered[:, None], len(scenario.segments), axis=1)
    scores = score(BuiltIn().fly(scenario, parameters, np.arange(flights)), scenario.race.judge)
    complete = scores.complete
    error = f", {scores.mean_error[complete].mean():.2f} m" if complete.any() else ""
    return f"{100 * scores.completion.mean():.0f} / {100 * complete.mean():.0f}{error}"


def with_sweeps(race: Race, sweeps: int) -> Race:
    """The same race with another number of Riccati sweeps in each control step."""
    return race.model_copy(update={"controller": race.controller.model_copy(update={"sweeps": sweeps})})


def with_delay(race: Race, delay: float, *, known: bool) -> Race:
    """The same race with another dead time of the vehicle [s], which is in the controller's model where it is known."""
    vehicle = race.vehicle.model_copy(update={"delay": delay})
    return race.model_copy(update={"vehicle": vehicle, "model": race.control_model.model_copy(update={"delay": delay if known else 0.0})})


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flights", type=int, default=192)
    flights = parser.parse_args().flights
    weights = {"default": (None, 0.0), "tuned": (TUNED, 0.0), "default scattered": (None, 0.5), "tuned scattered": (TUNED, 0.5)}
    print("completion % / complete %, mean error of complete flights\n")
    print(f"| race | weights | {' | '.join(f'{sweeps} sweeps' for sweeps in SWEEPS)} |\n|{'---|' * (2 + len(SWEEPS))}")
    for name in TABLE_I:
        scenarios = [prepare(with_sweeps(load_race(name), sweeps)) for sweeps in SWEEPS]
        for label, (values, scatter) in weights.items():
            chosen = scenarios[0].space.default if values is None else np.array(values)
            print(f"| {name} | {label} | {' | '.join(fly(scenario, chosen, scatter, flights) for scenario in scenarios)} |", flush=True)
    print(
        f"\n| race | weights | dead time | {' | '.join(f'{1e3 * delay:g} ms' for delay in DEAD_TIMES)} |\n|{'---|' * (3 + len(DEAD_TIMES))}"
    )
    for name in ("circle-34", "qualifier-20"):
        for known in (True, False):
            scenarios = [prepare(with_delay(load_race(name), delay, known=known)) for delay in DEAD_TIMES]
            for label in ("default", "tuned"):
                chosen = scenarios[0].space.default if label == "default" else np.array(TUNED)
                cells = " | ".join(fly(scenario, chosen, 0.0, flights) for scenario in scenarios)
                print(f"| {name} | {label} | {'known' if known else 'unknown'} | {cells} |", flush=True)


if __name__ == "__main__":
    main()

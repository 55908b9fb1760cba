"""A cost of your own: pass every gate as close to its centre as possible, instead of in the shortest time."""

import numpy as np

from hotlap import tuners
from hotlap.core.records import Flights, Scores
from hotlap.planning.preparation import prepare
from hotlap.tuning.goal import Goal, Quantity
from hotlap.tuning.loop import Tuning, TuningSettings, tune
from hotlap.tuning.objective import Objective
from hotlap.worlds import BuiltIn

MISSED = 10.0  # m: cost of a gate that was missed


def worst_gate(flights: Flights, scores: Scores) -> np.ndarray:
    """Largest distance [m] from the centre of a passed gate, plus `MISSED` for each missed gate; shape (B,)."""
    passed = np.arange(flights.clock_distance.shape[1]) < flights.gates_passed[:, None]
    worst = np.where(passed, flights.clock_distance, 0.0).max(axis=1)
    return worst + MISSED * (1 - scores.completion) * passed.shape[1]


scenario = prepare("circle-34")
objective = Objective(scenario, BuiltIn(), cost=worst_gate)
settings = TuningSettings(goal=Goal(Quantity.NONE), budget=150, validation=0, samples=3)  # no goal: the lowest mean over three flights
*_, last = tune(objective, Tuning(tuners.build("gate_gp"), scenario, settings))

seeds = np.arange(100)
for label, parameters in (("default", scenario.space.first_guess(len(scenario.segments))), ("tuned", last.best.parameters)):
    scores = objective.fly(np.repeat(parameters[None], len(seeds), axis=0), seeds)
    worst = np.median(scores.cost[scores.complete]) if scores.complete.any() else np.nan
    print(f"{label}: passes all gates in {scores.complete.mean():.0%} of the flights; there the worst gate is passed at {worst:.2f} m")

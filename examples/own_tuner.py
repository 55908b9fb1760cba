"""A tuner of your own, used like the built-in ones: also `hotlap compare RACE... --tuners own_tuner.Hill,gate_gp`."""

from dataclasses import dataclass

import numpy as np

from hotlap import tuners
from hotlap.planning.preparation import prepare
from hotlap.tuning.loop import Tuning, TuningSettings, tune
from hotlap.tuning.objective import Objective
from hotlap.worlds import BuiltIn


@dataclass(frozen=True)
class Settings:
    step: float = 0.3  # standard deviation of a step, in logarithms


PRESETS = {"default": Settings(), "bold": Settings(step=0.8)}


class Hill:
    """Random steps from the best parameters so far, the same in all segments; the protocol is `hotlap.tuners.Tuner`."""

    def __init__(self, name, settings):
        self.name, self.settings = name, settings

    def start(self, first_guess, space, rng):
        self.space, self.rng, self.best, self.cost = space, rng, space.clip(first_guess), np.inf

    def ask(self, n):
        steps = self.settings.step * self.rng.standard_normal((n, 1, self.space.size)) * (self.cost < np.inf)
        return self.space.clip(self.best * np.exp(steps))[: n if self.cost < np.inf else 1]

    def tell(self, parameters, scores):
        accepted = scores.cost <= min(self.cost, scores.cost.min())
        if accepted.any():
            self.best, self.cost = parameters[accepted.argmax()], float(scores.cost.min())
        return accepted

    def state(self):
        return {"best": self.best.tolist(), "cost": None if self.cost == np.inf else self.cost, "rng": self.rng.bit_generator.state}

    def restore(self, state):
        self.best, self.cost = np.array(state["best"]), np.inf if state["cost"] is None else state["cost"]
        self.rng.bit_generator.state = state["rng"]


if __name__ == "__main__":
    scenario = prepare("drop-20")
    for name in ("own_tuner.Hill", "own_tuner.Hill:bold", "gate_gp"):
        *_, last = tune(Objective(scenario, BuiltIn()), Tuning(tuners.build(name), scenario, TuningSettings(validation=50)))
        print(f"{name:<20} confirmed: {last.best.confirmed}, after {last.search_flights} search flights, {last.flights} in all")

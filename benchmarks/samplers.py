"""The tuners as samplers of Optuna, with and without trials elsewhere, beside TPE and random search: `python benchmarks/samplers.py`."""

from __future__ import annotations

import argparse

import numpy as np
import optuna
from optuna.samplers import RandomSampler, TPESampler

from hotlap.optuna import HotlapSampler

SEEDS = 5


def bowl(seed):
    """A noisy bowl in five logarithms; the squared distance from its optimum is kept."""
    optimum, noise = np.random.default_rng(100 + seed).uniform(-2, 2, 5), np.random.default_rng(seed)

    def objective(trial):
        values = [trial.suggest_float(f"x{k}", 1e-3, 1e3, log=True) for k in range(5)]
        distance = float(((np.log10(values) - optimum) ** 2).sum())
        trial.set_user_attr("distance", distance)
        return distance + 0.5 * noise.standard_normal()

    return objective


def rosenbrock(_seed):
    """Rosenbrock's function of four variables."""

    def objective(trial):
        x = np.array([trial.suggest_float(f"x{k}", -2.0, 2.0) for k in range(4)])
        value = float((100 * (x[1:] - x[:-1] ** 2) ** 2 + (1 - x[:-1]) ** 2).sum())
        trial.set_user_attr("distance", value)
        return value

    return objective


def median(sampler, make, trials):
    """Distance of the best trial from the optimum, median over seeds."""
    found = []
    for seed in range(SEEDS):
        study = optuna.create_study(sampler=sampler(seed))
        study.optimize(make(seed), n_trials=trials)
        found.append(study.best_trial.user_attrs["distance"])
    return float(np.median(found))


def main():
    argparse.ArgumentParser(description=__doc__).parse_args()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    samplers = {
        f"{tuner}, elsewhere={elsewhere}": lambda seed, tuner=tuner, elsewhere=elsewhere: HotlapSampler(
            tuner, seed=seed, elsewhere=elsewhere
        )
        for tuner in ("guided_walk", "cma_es", "trust_region")
        for elsewhere in (0, 10)
    }
    samplers |= {"TPE": lambda seed: TPESampler(seed=seed), "random": lambda seed: RandomSampler(seed=seed)}
    for name, sampler in samplers.items():
        print(f"{name:<28} bowl {median(sampler, bowl, 100):6.2f}  Rosenbrock {median(sampler, rosenbrock, 150):6.2f}", flush=True)


if __name__ == "__main__":
    main()

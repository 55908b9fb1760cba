"""hotlap's tuners on an objective of your own, through Optuna: here a noisy function of real and whole numbers.

Needs `pip install 'hotlap[optuna]'`. The study is kept in a file; a second run continues it.
"""

import numpy as np
import optuna

from hotlap.optuna import HotlapSampler

optuna.logging.set_verbosity(optuna.logging.WARNING)


def true_cost(params: dict[str, float]) -> float:
    """The cost without noise; it is lowest at gain 20, delay 0.1 and 8 nodes."""
    return (np.log10(params["gain"]) - 1.3) ** 2 + (10 * (params["delay"] - 0.1)) ** 2 + np.log2(params["nodes"] / 8) ** 2


def objective(trial: optuna.Trial) -> float:
    params = {
        "gain": trial.suggest_float("gain", 1e-3, 1e3, log=True),
        "delay": trial.suggest_float("delay", 0.0, 0.5),
        "nodes": trial.suggest_int("nodes", 1, 64, log=True),
    }
    return float(true_cost(params) + 0.3 * np.random.default_rng(trial.number).standard_normal())


for label, sampler in (("guided walk", HotlapSampler("guided_walk", seed=0)), ("random", optuna.samplers.RandomSampler(seed=0))):
    study = optuna.create_study(storage="sqlite:///study.db", study_name=label, sampler=sampler, load_if_exists=True)
    study.optimize(objective, n_trials=60)
    found = ", ".join(f"{name} {value:.3g}" for name, value in study.best_params.items())
    print(f"{label}: {found}; true cost {true_cost(study.best_params):.3f}, {len(study.trials)} trials")

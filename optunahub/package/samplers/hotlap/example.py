"""Minimise a noisy function: run beside the folder `package`, or load the module from the registry by `optunahub.load_module`."""

from __future__ import annotations

import numpy as np
import optuna
import optunahub


def objective(trial: optuna.Trial) -> float:
    """A bowl in logarithms, with noise."""
    gain = trial.suggest_float("gain", 1e-3, 1e3, log=True)
    delay = trial.suggest_float("delay", 0.0, 0.5)
    nodes = trial.suggest_int("nodes", 1, 64, log=True)
    bowl = (np.log10(gain) - 1.3) ** 2 + (10 * (delay - 0.1)) ** 2 + np.log2(nodes / 8) ** 2
    return float(bowl + 0.1 * np.random.default_rng(trial.number).standard_normal())


module = optunahub.load_local_module(package="samplers/hotlap", registry_root="package")
study = optuna.create_study(sampler=module.HotlapSampler(seed=0))
study.optimize(objective, n_trials=50)
print(study.best_trial.params, study.best_value)

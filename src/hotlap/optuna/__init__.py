"""hotlap's tuners as samplers of Optuna, for any objective; needs `pip install 'hotlap[optuna]'`.

In short:

    study = optuna.create_study(sampler=HotlapSampler())
    study.optimize(objective, n_trials=100)
"""

from __future__ import annotations

from hotlap.optuna.sampler import HotlapSampler

__all__ = ["HotlapSampler"]

"""hotlap's tuners as a sampler of Optuna."""

from hotlap.optuna import HotlapSampler

__all__ = ["HotlapSampler"]

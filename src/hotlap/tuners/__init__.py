"""Tuners by name: one algorithm, one file; `build` makes one.

One of your own is a class in a module of your own, laid out as those here: `my_module.MyTuner`, made as `MyTuner(name, settings)`, and
beside it `PRESETS`, names and settings.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from hotlap.core.errors import InputError, UnknownNameError
from hotlap.tuners import (
    bayesian,
    cma_es,
    gate_gp,
    gradient,
    gradient_boosting,
    guided_walk,
    metropolis_hastings,
    particle_swarm,
    random_search,
    safe_bayesian,
    simulated_annealing,
    tempered,
    trust_region,
    weighted_likelihood,
)
from hotlap.tuners.bayesian import Bayesian
from hotlap.tuners.cma_es import CmaEs
from hotlap.tuners.gate_gp import GateGp
from hotlap.tuners.gradient import Gradient
from hotlap.tuners.gradient_boosting import GradientBoosting
from hotlap.tuners.guided_walk import GuidedWalk
from hotlap.tuners.metropolis_hastings import MetropolisHastings
from hotlap.tuners.particle_swarm import ParticleSwarm
from hotlap.tuners.random_search import RandomSearch
from hotlap.tuners.safe_bayesian import SafeBayesian
from hotlap.tuners.simulated_annealing import SimulatedAnnealing
from hotlap.tuners.tempered import Tempered
from hotlap.tuners.trust_region import TrustRegion
from hotlap.tuners.tuner import Tuner
from hotlap.tuners.weighted_likelihood import WeightedLikelihood

DEFAULT = "gate_gp"

_ALGORITHMS: Mapping[str, tuple[Callable[[str, Any], Tuner], Mapping[str, Any]]] = {
    "bayesian": (Bayesian, bayesian.PRESETS),
    "cma_es": (CmaEs, cma_es.PRESETS),
    "gate_gp": (GateGp, gate_gp.PRESETS),
    "gradient": (Gradient, gradient.PRESETS),
    "gradient_boosting": (GradientBoosting, gradient_boosting.PRESETS),
    "guided_walk": (GuidedWalk, guided_walk.PRESETS),
    "metropolis_hastings": (MetropolisHastings, metropolis_hastings.PRESETS),
    "particle_swarm": (ParticleSwarm, particle_swarm.PRESETS),
    "random_search": (RandomSearch, random_search.PRESETS),
    "safe_bayesian": (SafeBayesian, safe_bayesian.PRESETS),
    "simulated_annealing": (SimulatedAnnealing, simulated_annealing.PRESETS),
    "tempered": (Tempered, tempered.PRESETS),
    "trust_region": (TrustRegion, trust_region.PRESETS),
    "weighted_likelihood": (WeightedLikelihood, weighted_likelihood.PRESETS),
}


def names() -> tuple[str, ...]:
    """Every algorithm with each of its presets, `NAME:PRESET`; the first preset of an algorithm is its default."""
    return tuple(f"{algorithm}:{preset}" for algorithm, (_, presets) in _ALGORITHMS.items() for preset in presets)


def build(name: str) -> Tuner:
    """A tuner, not yet started.

    Args:
        name: `ALGORITHM` or `ALGORITHM:PRESET`; the preset may be `default`. An algorithm with a dot is a class to import.

    Raises:
        UnknownNameError: with the names that there are.
        InputError: a class that cannot be imported.
    """
    algorithm, separator, preset = name.partition(":")
    if algorithm not in _ALGORITHMS and "." not in algorithm:
        raise UnknownNameError("tuner", name, (*_ALGORITHMS, *names()), key="tuner")
    make, presets = _ALGORITHMS[algorithm] if algorithm in _ALGORITHMS else _import(algorithm)
    if not separator or preset == "default":
        preset = next(iter(presets))
    if preset not in presets:
        raise UnknownNameError(f"preset of {algorithm}", preset, (*presets, "default"), key="tuner")
    return make(f"{algorithm}:{preset}", presets[preset])


def _import(path: str) -> tuple[Callable[[str, Any], Tuner], Mapping[str, Any]]:
    """A class and its presets from a module outside of hotlap."""
    place, _, name = path.rpartition(".")
    try:
        module = import_module(place)
        made, presets = getattr(module, name), module.PRESETS
    except Exception as error:  # a module of someone else's may raise anything
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError("", "tuner", f"{path} cannot be imported: {reason}") from error
    if not isinstance(made, type):
        raise InputError("", "tuner", f"{path} cannot be imported: it is no class")
    if not presets:
        raise InputError("", "tuner", f"{path} cannot be imported: its PRESETS are empty")
    return made, presets


__all__ = ["DEFAULT", "Tuner", "build", "names"]

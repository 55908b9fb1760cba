"""Particle swarm optimisation (Kennedy, Eberhart, ICNN 1995), with the paper's settings: a baseline of Table I."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores
from hotlap.tuners.unit_box import UnitBox

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ParticleSwarmSettings:
    """What tells one swarm from another.

    Attributes:
        particles: how many.
        inertia: share of its velocity that a particle keeps.
        cognitive: pull towards a particle's own best place.
        social: pull towards the swarm's best place.
        spread: half width of the particles' first places around the first guess, in the unit box.
        log: whether the unit box is one of logarithms; else of the parameters' own units.
    """

    particles: int = 10  # Table I
    inertia: float = 0.5
    cognitive: float = 1.0
    social: float = 2.0
    spread: float = 0.5
    log: bool = False


PRESETS: Mapping[str, ParticleSwarmSettings] = {"paper": ParticleSwarmSettings(), "log": ParticleSwarmSettings(spread=0.15, log=True)}


class ParticleSwarm:
    """Particles in a unit box; the first one begins at the first guess, the others around it. A turn moves all of them once.

    Places are clipped at the box, and a velocity is set to nothing where that happens.
    """

    def __init__(self, name: str, settings: ParticleSwarmSettings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Scatter the swarm."""
        self._rng, self._box = rng, UnitBox(space, first_guess.shape, self.settings.log)
        self._first = space.clip(first_guess)
        count, size = self.settings.particles, first_guess.size
        centre = self._box.encode(self._first)
        scattered = centre + self.settings.spread * rng.uniform(-1, 1, (count - 1, size))
        self._places: Floats = np.vstack([centre, np.clip(scattered, 0, 1)])
        self._velocities: Floats = np.zeros((count, size))
        self._best_places, self._best_costs = self._places.copy(), np.full(count, math.inf)
        self._next, self._told = 0, 0  # particle to ask for, and to be told of
        self._flown = 0

    def ask(self, n: int) -> Parameters:
        """The next particles of the turn, shape (1 to n, S, K)."""
        last = min(self._next + n, self.settings.particles)
        asked = self._box.decode(self._places[self._next : last])
        if self._flown == 0 and self._next == 0:
            asked[0] = self._first  # without the rounding of the unit box
        self._next = last
        return asked

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Remember the best places; when the turn is over, move. True where a particle found its best place."""
        better = np.zeros(len(parameters), dtype=np.bool_)
        for i, cost in enumerate(scores.cost.tolist()):
            particle = self._told
            if math.isfinite(cost) and cost < self._best_costs[particle]:
                self._best_costs[particle], better[i] = cost, True
                self._best_places[particle] = self._places[particle]
            self._told += 1
            self._flown += 1
        if self._told == self.settings.particles:
            self._move()
            self._next = self._told = 0
        return better

    def state(self) -> dict[str, Any]:
        """The swarm and the random generator."""
        return {
            "places": self._places.tolist(),
            "velocities": self._velocities.tolist(),
            "best_places": self._best_places.tolist(),
            "best_costs": [cost if math.isfinite(cost) else None for cost in self._best_costs.tolist()],
            "counts": [self._next, self._told, self._flown],
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go on where `state()` was taken."""
        self._places, self._velocities = np.array(state["places"]), np.array(state["velocities"])
        self._best_places = np.array(state["best_places"])
        self._best_costs = np.array([math.inf if cost is None else cost for cost in state["best_costs"]])
        self._next, self._told, self._flown = state["counts"]
        self._rng.bit_generator.state = state["rng"]

    def _move(self) -> None:
        """v <- w v + c1 r1 (own best - x) + c2 r2 (swarm's best - x), x <- x + v."""
        s, shape = self.settings, self._places.shape
        own, swarm = self._rng.random(shape), self._rng.random(shape)
        leader = self._best_places[int(np.argmin(self._best_costs))]
        pull = s.cognitive * own * (self._best_places - self._places) + s.social * swarm * (leader - self._places)
        self._velocities = s.inertia * self._velocities + pull
        moved = self._places + self._velocities
        self._places = np.clip(moved, 0, 1)
        self._velocities[moved != self._places] = 0.0

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
    """Settings of the swarm.

    Attributes:
        particles: number of particles.
        inertia: w, share of its velocity that a particle keeps.
        cognitive: c1, acceleration towards the best position of the particle itself.
        social: c2, acceleration towards the best position of the swarm.
        spread: half width of the first positions around the first guess, in the unit box.
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
    """Particles in a unit box; the first one begins at the first guess, the others around it. An iteration moves all of them once.

    Positions are clipped at the box; where that happens, the velocity along that axis becomes 0.
    """

    def __init__(self, name: str, settings: ParticleSwarmSettings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Draw the first positions."""
        self._rng, self._box = rng, UnitBox(space, first_guess.shape, self.settings.log)
        self._first = space.clip(first_guess)
        count, size = self.settings.particles, first_guess.size
        centre = self._box.encode(self._first)
        scattered = centre + self.settings.spread * rng.uniform(-1, 1, (count - 1, size))
        self._places: Floats = np.vstack([centre, np.clip(scattered, 0, 1)])
        self._velocities: Floats = np.zeros((count, size))
        self._best_places, self._best_costs = self._places.copy(), np.full(count, math.inf)
        self._next, self._reported = 0, 0  # next particle to be flown, and next one whose score is reported
        self._flown = 0

    def ask(self, n: int) -> Parameters:
        """The next particles of the iteration, shape (1 to n, S, K)."""
        last = min(self._next + n, self.settings.particles)
        asked = self._box.decode(self._places[self._next : last])
        if self._flown == 0 and self._next == 0:
            asked[0] = self._first  # without the rounding of the unit box
        self._next = last
        return asked

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Store the best positions; at the end of the iteration, move. True where a particle has its best position so far."""
        better = np.zeros(len(parameters), dtype=np.bool_)
        for i, cost in enumerate(scores.cost.tolist()):
            particle = self._reported
            if math.isfinite(cost) and cost < self._best_costs[particle]:
                self._best_costs[particle], better[i] = cost, True
                self._best_places[particle] = self._places[particle]
            self._reported += 1
            self._flown += 1
        if self._reported == self.settings.particles:
            self._move()
            self._next = self._reported = 0
        return better

    def state(self) -> dict[str, Any]:
        """Positions, velocities, best positions and the random generator."""
        return {
            "places": self._places.tolist(),
            "velocities": self._velocities.tolist(),
            "best_places": self._best_places.tolist(),
            "best_costs": [cost if math.isfinite(cost) else None for cost in self._best_costs.tolist()],
            "counts": [self._next, self._reported, self._flown],
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`."""
        self._places, self._velocities = np.array(state["places"]), np.array(state["velocities"])
        self._best_places = np.array(state["best_places"])
        self._best_costs = np.array([math.inf if cost is None else cost for cost in state["best_costs"]])
        self._next, self._reported, self._flown = state["counts"]
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

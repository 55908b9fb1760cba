"""RaceEnv: a race of the built-in world as a Gymnasium environment; the agent is the controller."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import HotlapError
from hotlap.core.records import Cause, End, Floats
from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare
from hotlap.race.endings import in_words
from hotlap.race.race import Race
from hotlap.reference.attitude import rotate

if TYPE_CHECKING:
    from hotlap.gym.piloted import PilotedFlight

AXES = np.eye(3)
FAR = 1000.0  # m, m/s, rad/s: as far as an observation reaches
PENALTY = 10.0  # m of progress that a flight costs which ends before the last gate
SEEDS = 2**40
Observation = NDArray[np.float32]


class RaceEnv(gymnasium.Env[Observation, NDArray[np.float32]]):
    """Fly a race, a step a control period, judged as all flights of hotlap are: against the clock of the reference, by the race's rule.

    Actions, from -1 to 1: collective thrust per mass from the least to the largest that may be commanded, and the body rates as shares
    of their limits. Observations, 29 numbers in SI units: the way to the next gate and to the one behind it, the way to where the
    reference is now, velocity (all in the world's frame), the body's three axes, body rates, the action before, and the time until the
    reference passes the next gate. The reward is the progress along the gates [m], less `PENALTY` where a flight ends before the last.
    Noise of start, thrust and actuation is the race's; wind does not blow.

    Args:
        race: name of a built-in race, a TOML file, or a `Race`.
        reference: a CSV file to read in place of a plan; None: plan.
        render_mode: None; hotlap draws flights on its pages.

    Raises:
        InputError: race or reference cannot be used.
        PlanningError: there is no plan.
    """

    metadata = {"render_modes": []}  # noqa: RUF012  as Gymnasium declares it

    def __init__(self, race: str | Path | Race = "circle-34", reference: str | Path | None = None, render_mode: None = None) -> None:
        if render_mode is not None:
            raise HotlapError(f"hotlap/Race-v0 has no render mode {render_mode!r}: hotlap score and hotlap report draw flights")
        self.render_mode = render_mode
        self.scenario = prepare(race if isinstance(race, Race) else load_race(race), reference)
        low, high = self.scenario.thrust_limits
        self._middle = np.array([(low + high) / 2, 0.0, 0.0, 0.0])
        self._reach = np.array([(high - low) / 2, *self.scenario.race.controller.rates])
        self._gates = self.scenario.race.track.gate_positions
        self._legs = np.append(np.cumsum(np.linalg.norm(np.diff(self._gates, axis=0), axis=1)[::-1])[::-1], 0.0)
        self._period = self.scenario.race.controller.period
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (4,), np.float32)
        self.observation_space = gymnasium.spaces.Box(-FAR, FAR, (29,), np.float32)
        self._flight: PilotedFlight | None = None
        self._action, self._over, self._left = np.zeros(4), True, 0.0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        """Begin a flight, with noise that depends on the seed alone."""
        from hotlap.gym.piloted import PilotedFlight  # noqa: PLC0415  the flight core loads a compiler

        super().reset(seed=seed, options=options)
        self._flight = PilotedFlight(self.scenario, int(self.np_random.integers(SEEDS)))
        self._action, self._over, self._left = np.zeros(4), False, self._remaining()
        return self._observe(), self._inform()

    def step(self, action: NDArray[np.float32]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Fly a control period.

        Raises:
            HotlapError: the flight is over, or none has begun.
        """
        if self._over or self._flight is None:
            raise HotlapError("the flight is over: call reset()")
        self._action = np.clip(np.asarray(action, dtype=np.float64), -1.0, 1.0)
        self._over = self._flight.fly(self._middle + self._reach * self._action)
        left = self._remaining()
        reward, self._left = self._left - left, left
        missed = self._over and self._flight.gates_passed < len(self._gates)
        reward = reward - PENALTY if missed else reward
        return self._observe(), reward if math.isfinite(reward) else -PENALTY, self._over, False, self._inform()

    def _remaining(self) -> float:
        """[m] through all gates that were not passed."""
        flight = self._flown
        if flight.gates_passed >= len(self._gates):
            return 0.0
        return float(np.linalg.norm(self._gates[flight.gates_passed] - flight.state[:3]) + self._legs[flight.gates_passed])

    def _observe(self) -> Observation:
        flight, reference = self._flown, self.scenario.reference
        state, last, time = flight.state, len(self._gates) - 1, flight.tick * self._period
        upcoming = min(flight.gates_passed, last)
        parts = (
            self._gates[upcoming] - state[:3],
            self._gates[min(upcoming + 1, last)] - state[:3],
            reference.position_at(np.array([time]))[0] - state[:3],
            state[7:10],
            rotate(np.repeat(state[None, 3:7], 3, axis=0), AXES).ravel(),
            state[10:13],
            self._action,
            [reference.gate_times[upcoming] - time],
        )
        numbers: Floats = np.nan_to_num(np.concatenate(parts), nan=FAR)
        return np.clip(numbers, -FAR, FAR).astype(np.float32)

    def _inform(self) -> dict[str, Any]:
        """How far the flight has come, and how it ended where it has."""
        flight = self._flown
        told: dict[str, Any] = {"time": flight.tick * self._period, "gates_passed": flight.gates_passed}
        told["completion"] = flight.gates_passed / len(self._gates)
        if self._over:
            flights = flight.verdict()
            cause, index = Cause(int(flights.cause[0])), int(flights.cause_index[0])
            told["ending"] = in_words(self.scenario.race, End(int(flights.end[0])), flight.gates_passed, cause, index)
            told |= {name: float(getattr(flights, name)[0]) for name in ("lap_time", "mean_error", "max_error")}
        return told

    @property
    def _flown(self) -> PilotedFlight:
        assert self._flight is not None, "reset comes first"  # noqa: S101  our own mistake
        return self._flight

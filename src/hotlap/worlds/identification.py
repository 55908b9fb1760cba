"""Identification: which rate gain and dead time of the built-in world come nearest to the rate loop of a simulator."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from hotlap.flight.rate_response import RateResponse
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import PLANT_STEP
from hotlap.worlds.simulator import Simulator, Start

Floats = NDArray[np.float64]

PERIOD = 0.01  # s between two commands
SIZE = np.array([3.0, 3.0, 1.5])  # rad/s: largest rates that are commanded
SHORTEST, LONGEST = 4, 16  # periods that a rate is held
MOST_DELAY = 8  # steps of the plant
FASTEST, SLOWEST = 400.0, 0.5  # 1/s: limits of the gain
HEIGHT = 50.0  # m


@dataclass(frozen=True)
class RateLoopFit:
    """A rate loop of the built-in world that stands for a simulator's.

    Attributes:
        rate_gain: shape (3,) [1/s].
        delay: [s] of dead time, besides that of the quadrotor.
        error: shape (3,) root mean square of what is left, over that of the rates [-].
        former_error: shape (3,) the same with the quadrotor as its file has it.
    """

    rate_gain: Floats
    delay: float
    error: Floats
    former_error: Floats

    def lines(self, quadrotor: Quadrotor) -> str:
        """Two lines for the file of a quadrotor."""
        gains = ", ".join(f"{gain:.1f}" for gain in self.rate_gain)
        return f"rate_gain = [{gains}]  # 1/s\ndelay = {quadrotor.delay + self.delay:g}  # s"


def identify_rate_loop(simulator: Simulator, quadrotor: Quadrotor, *, seconds: float = 6.0, thrust: float | None = None) -> RateLoopFit:
    """Fly random steps of body rates, and find the rate loop of the built-in world that answers most nearly.

    Args:
        simulator: its first drone flies.
        quadrotor: that it simulates; its own dead time does not count.
        seconds: of flight.
        thrust: [m/s^2] that is held meanwhile; None: that of hovering.

    Raises:
        SimulatorError: the simulator is lost.
    """
    commands = _commands(round(seconds / PERIOD), quadrotor.gravity if thrust is None else thrust)
    measured = _fly(simulator, commands)
    response = RateResponse(quadrotor, commands, round(PERIOD / PLANT_STEP))
    sizes = np.sqrt(np.mean(measured**2, axis=0))

    def misfit(gain: Floats, delay: int) -> Floats:
        """What is left, shape (N, 3), over the size of the rates."""
        return (response.rates(gain, delay) - measured) / sizes

    def rms(left: Floats) -> Floats:
        return np.sqrt(np.mean(left**2, axis=0))

    own = np.array(quadrotor.rate_gain)
    bounds = np.log(SLOWEST), np.log(FASTEST)
    fits = [
        (least_squares(lambda x, d=delay: misfit(np.exp(x), d).ravel(), np.log(own), bounds=bounds, diff_step=1e-4), delay)
        for delay in range(MOST_DELAY + 1)
    ]
    best, delay = min(fits, key=lambda fit: fit[0].cost)
    gain = np.exp(best.x)
    return RateLoopFit(gain, delay * PLANT_STEP, rms(misfit(gain, delay)), rms(misfit(own, 0)))


def _commands(count: int, thrust: float) -> Floats:
    """Thrust that is held, and random rates, each held for a random time, shape (count, 4)."""
    random = np.random.default_rng(1)
    commands = np.full((count, 4), thrust)
    for axis, size in enumerate(SIZE):
        k = 0
        while k < count:
            held = int(random.integers(SHORTEST, LONGEST + 1))
            commands[k : k + held, 1 + axis] = random.uniform(-size, size)
            k += held
    return commands


def _fly(simulator: Simulator, commands: Floats) -> Floats:
    """Body rates of the first drone when each command has been held, shape (N, 3)."""
    simulator.reset(0, Start(np.array([0.0, 0.0, HEIGHT, 1.0, *np.zeros(9)])))
    rates = np.empty((len(commands), 3))
    for k, command in enumerate(commands):
        simulator.advance(np.tile(command, (simulator.lanes, 1)), PERIOD)
        rates[k] = simulator.states()[0, 10:13]
    return rates

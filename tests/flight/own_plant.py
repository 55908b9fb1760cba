"""A drone in numpy that shares nothing with the flight core: lags of first order, gusts, a battery that sags, thrust that is lost."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

STEP = 0.001  # s


@dataclass
class Drone:
    """A rigid body whose collective thrust per mass and body rates follow their commands with a lag.

    Attributes:
        position, velocity: shape (3,) [m], [m/s] (world).
        attitude: body to world.
        sag: [1/s] share of the thrust that the battery loses in a second.
        lost, lost_from: share of the thrust that is lost at a time [s].
        gusts, gust_time: standard deviation [m/s^2] and correlation time [s] of the wind's acceleration.
        drag: [1/s] linear.
    """

    position: np.ndarray
    velocity: np.ndarray
    attitude: Rotation
    sag: float = 0.0
    lost: float = 0.0
    lost_from: float = 0.0
    gusts: float = 0.0
    gust_time: float = 1.0
    drag: float = 0.0
    thrust_time: float = 0.02
    rate_time: float = 0.04
    time: float = 0.0
    thrust: float = 9.81
    rates: np.ndarray = field(default_factory=lambda: np.zeros(3))
    wind: np.ndarray = field(default_factory=lambda: np.zeros(3))
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))

    @property
    def state(self) -> np.ndarray:
        """Position, attitude (w, x, y, z) and velocity, shape (10,)."""
        x, y, z, w = self.attitude.as_quat()
        return np.concatenate([self.position, [w, x, y, z], self.velocity])

    @property
    def share(self) -> float:
        """Share of the thrust that is left."""
        return (1 - self.sag * self.time) * (1 - self.lost * (self.time >= self.lost_from))

    def fly(self, command: np.ndarray, duration: float) -> None:
        """Hold a command, thrust per mass and body rates, for a time [s]."""
        for _ in range(round(duration / STEP)):
            self.thrust += STEP / self.thrust_time * (command[0] - self.thrust)
            self.rates = self.rates + STEP / self.rate_time * (command[1:] - self.rates)
            self.wind = self.wind - STEP / self.gust_time * self.wind
            self.wind = self.wind + self.gusts * np.sqrt(2 * STEP / self.gust_time) * self.rng.normal(size=3)
            lift = self.attitude.apply([0.0, 0.0, self.share * self.thrust])
            acceleration = lift - [0.0, 0.0, 9.81] - self.drag * self.velocity + self.wind
            self.position = self.position + STEP * self.velocity + STEP**2 / 2 * acceleration
            self.velocity = self.velocity + STEP * acceleration
            self.attitude = self.attitude * Rotation.from_rotvec(STEP * self.rates)
            self.time += STEP

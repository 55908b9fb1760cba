"""Reference demands: what a reference asks of the vehicle that flies it: thrust, body rates, and both at its first moment.

The vehicle has drags of its own, of which a reference need not know. What it has to give is the vector

    f = dv/dt + g e3 + R D(R^T v),

of the reference's acceleration and the vehicle's drag per mass D. Its length is the thrust per mass.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import Race
from hotlap.reference.reference import Reference
from hotlap.reference_files.thrust_vectors import with_drag

Floats = NDArray[np.float64]

HELD = 0.1  # s for which a thrust has to be held to count: a controller cuts shorter peaks
FIRST = 0.05  # s that are the first moment
SUDDEN_SPEED, SUDDEN_RATE = 0.5, 3.0  # m/s and rad/s at the first moment that matter
FULL = 0.97  # share of the thrust beyond which all of it is asked for


@dataclass(frozen=True)
class Demands:
    """What a reference asks of the vehicle.

    Attributes:
        thrust_share: largest share of the vehicle's thrust that is held for 0.1 s [-].
        rotor_share: the same of the rotor that has to give most [-].
        mean_share: mean share of the thrust [-].
        full_time: share of the duration at 97 % of the thrust or more [-].
        rates: shape (3,) largest body rates [rad/s] (body).
        rate_shares: shape (3,) the same over `controller.rates` [-].
        first_share: share of the vehicle's thrust in the first 50 ms, their mean [-].
        first_rates: shape (3,) body rates at the first moment [rad/s] (body).
        first_speed: [m/s] at the first moment.
        top_speed: [m/s] largest.
        length: [m] flown.
        duration: [s].
    """

    thrust_share: float
    rotor_share: float
    mean_share: float
    full_time: float
    rates: Floats
    rate_shares: Floats
    first_share: float
    first_rates: Floats
    first_speed: float
    top_speed: float
    length: float
    duration: float

    @property
    def exhausting(self) -> bool:
        """Whether it asks for all of the vehicle's thrust, so that nothing is left to correct with."""
        return max(self.thrust_share, self.rotor_share) > FULL

    @property
    def too_quick(self) -> bool:
        """Whether it turns faster than the controller may command."""
        return bool((self.rate_shares > 1).any())


def demands(race: Race, reference: Reference) -> Demands:
    """What a reference, planned or read, asks of the vehicle of a race.

    Args:
        race: its vehicle and `controller.rates` count.
        reference: its planned rows are looked at.
    """
    rows, period = reference.planned_rows, reference.period
    shares = needed_thrust(race.vehicle, reference) / race.vehicle.max_acceleration
    rates = np.abs(reference.rates[:rows]).max(axis=0)
    return Demands(
        thrust_share=float(running_mean(shares, round(HELD / period)).max()),
        rotor_share=_rotor_share(race, reference),
        mean_share=float(shares.mean()),
        full_time=float((shares >= FULL).mean()),
        rates=rates,
        rate_shares=rates / np.array(race.controller.rates),
        first_share=float(shares[: max(1, round(FIRST / period))].mean()),
        first_rates=reference.rates[0].copy(),
        first_speed=float(reference.speeds[0]),
        top_speed=reference.max_speed,
        length=float(np.linalg.norm(np.diff(reference.position[:rows], axis=0), axis=1).sum()),
        duration=reference.duration,
    )


def advice(race: Race, reference: Reference) -> tuple[str, ...]:
    """What of a reference no weights can make up for, a clause each; none where nothing stands out.

    Args:
        race: its track, vehicle and controller count.
        reference: planned or read.
    """
    asked, found = demands(race, reference), list[str]()
    thrust, limit = float(reference.thrust[: reference.planned_rows].max()), race.controller.thrust[1]
    if asked.exhausting:
        share = max(asked.thrust_share, asked.rotor_share)
        found.append(f"this reference asks for {share:.0%} of the vehicle's thrust: no tuner will help; fly it slower")
    elif thrust > limit:  # what the vehicle has not got, no setting gives it
        found.append(f"it asks for a thrust of up to {thrust:.1f} m/s^2; raise controller.thrust, which allows {limit:g}")
    for axis, rate, most in zip(("roll", "pitch", "yaw"), asked.rates.tolist(), race.controller.rates, strict=True):
        if rate > 1.001 * most:
            found.append(f"it asks for a {axis} rate of up to {rate:.1f} rad/s; raise controller.rates, which allow {most:g}")
    away = float(np.linalg.norm(reference.velocity[0] - np.array(race.track.start_velocity)))
    if away > SUDDEN_SPEED:
        found.append(f"it begins at {asked.first_speed:.1f} m/s; set track.start_velocity, or let it begin as flights do")
    turning = float(np.linalg.norm(asked.first_rates))
    if turning > SUDDEN_RATE:
        found.append(f"it begins with body rates of {turning:.1f} rad/s, which a drone at rest cannot have")
    return tuple(found)


def needed_thrust(vehicle: Quadrotor, reference: Reference) -> Floats:
    """Thrust per mass that the vehicle has to give from each planned row to the next, shape (rows - 1,) [m/s^2]."""
    return np.linalg.norm(needed_vectors(vehicle, reference), axis=1)


def needed_vectors(vehicle: Quadrotor, reference: Reference) -> Floats:
    """The same as vectors f, shape (rows - 1, 3) [m/s^2] (world).

    The vehicle is free to tilt as its own drags need it; the attitudes of the reference do not count.
    """
    velocity = reference.velocity[: reference.planned_rows]
    acceleration = np.diff(velocity, axis=0) / reference.period
    return with_drag(vehicle, (velocity[1:] + velocity[:-1]) / 2, acceleration)


def _rotor_share(race: Race, reference: Reference) -> float:
    """Largest share of one rotor's thrust per mass that is held for `HELD` [-]; a reference's rotors push the planning model."""
    thrusts = reference.rotor_thrusts[: reference.planned_rows] / race.planning_model.mass
    held = max(running_mean(rotor, round(HELD / reference.period)).max() for rotor in thrusts.T)
    return float(held) / (race.vehicle.rotor_thrust[1] / race.vehicle.mass)


def running_mean(values: Floats, count: int) -> Floats:
    """Means of so many values in a row, shape (n - count + 1,); of all where there are fewer."""
    count = max(1, min(count, len(values)))
    return np.convolve(values, np.full(count, 1 / count), mode="valid")

"""Parameters of PX4, as QGroundControl loads them: a rate loop as quick as the one that the study has flown with.

PX4 1.14 and later: torque setpoint u = K (P e + ...), 1 at most; its allocator gives motor j the signal M_ja u, where M are the columns of
the pseudo-inverse of the rotors' effect, roll and pitch scaled alike so that the mean square of those that are not 0 is one half, yaw so
that its largest is 1. With thrust linear in the signal (THR_MDL_FAC) the gain from rate error to angular acceleration is then
P T sum_j r_ja M_ja / I_a, with T the largest thrust and r the lever of rotor j: P follows from the gain that hotlap's vehicle has.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from hotlap.core.records import Floats
from hotlap.race.quadrotor import Quadrotor
from hotlap.reference.scenario import Scenario
from hotlap.study.study import Study
from hotlap.system.text_files import replace

AXES = ("ROLL", "PITCH", "YAW")
REAL = 9  # MAV_PARAM_TYPE_REAL32
TINY = 1e-3  # of a share of the mix
NOTE = """# Parameters of PX4 (1.14 and later) for {name}, by hotlap. Vehicle-Id, Component-Id, Name, Value, Type, separated by tabs.
# They make PX4's rate loop as quick as that of the vehicle that {race} was flown with: {gains} 1/s about roll, pitch and yaw.
# What they rest on: mass, inertia, rotor positions and largest thrust of that vehicle, and thrust linear in the motors' signal: set
# THR_MDL_FAC and CA_ROTOR* to your drone first. They are a place to begin at. Look at the steps of each axis before you fly fast.
# What they do not say: motor order and directions, filters, the integral and derivative parts{missing}, failsafes, battery.
# hotlap's controller sends thrust and body rates (SET_ATTITUDE_TARGET); the attitude and position loops of PX4 are not used then.
"""


def write(study: Study, path: Path) -> tuple[Path, ...]:
    """Write them; the study need not have ended.

    Raises:
        InputError: the file cannot be written.
    """
    scenario = study.configuration.scenario
    lines = [f"1\t1\t{name}\t{value:.7g}\t{REAL}" for name, value in parameters(scenario).items()]
    replace(path, _head(scenario) + "\n".join(lines) + "\n")
    return (path,)


def parameters(scenario: Scenario) -> dict[str, float]:
    """Names and values."""
    vehicle = scenario.race.vehicle
    return dict([*_gains(vehicle), *_limits(scenario), ("MPC_THR_HOVER", 1 / vehicle.thrust_to_weight)])


def allocation(vehicle: Quadrotor) -> Floats:
    """What of a torque setpoint each motor gets, shape (n, 3)."""
    effect = np.vstack([vehicle.torque_matrix, np.ones(vehicle.rotor_count)])
    mix = np.linalg.pinv(effect)[:, :3]
    used = np.maximum((np.abs(mix) > TINY).sum(axis=0) / 2, 0.5)
    sizes = np.sqrt((mix**2).sum(axis=0) / used)
    level = max(sizes[0], sizes[1])
    return mix / np.array([level, level, mix[:, 2].max()])


def torque_slopes(vehicle: Quadrotor) -> Floats:
    """Torque [N m] about roll, pitch and yaw of a torque setpoint of 1, shape (3,), while no motor is at a limit."""
    return vehicle.rotor_thrust[1] * (vehicle.torque_matrix * allocation(vehicle).T).sum(axis=1)


def _gains(vehicle: Quadrotor) -> Iterator[tuple[str, float]]:
    """Of the rate loop; the integral and derivative parts where the vehicle has a loop with them."""
    gains = vehicle.hover_rate_gain * vehicle.inertia_vector / torque_slopes(vehicle)
    loop = vehicle.rate_loop
    for a, axis in enumerate(AXES):
        yield f"MC_{axis}RATE_K", 1.0
        yield f"MC_{axis}RATE_P", float(gains[a])
        if loop is not None:
            yield f"MC_{axis}RATE_I", float(gains[a]) * loop.i[a] / loop.p[a]
            yield f"MC_{axis}RATE_D", float(gains[a]) * loop.d[a] / loop.p[a]


def _limits(scenario: Scenario) -> Iterator[tuple[str, float]]:
    """Body rates [deg/s] that the controller may ask for."""
    for axis, rate in zip(AXES, scenario.race.controller.rates, strict=True):
        yield f"MC_{axis}RATE_MAX", math.degrees(rate)


def _head(scenario: Scenario) -> str:
    vehicle = scenario.race.vehicle
    gains = ", ".join(f"{gain:.3g}" for gain in vehicle.hover_rate_gain)
    missing = "" if vehicle.rate_loop is not None else " (the vehicle of hotlap has none: PX4's own stay)"
    return NOTE.format(name=vehicle.name, race=scenario.race.name, gains=gains, missing=missing)

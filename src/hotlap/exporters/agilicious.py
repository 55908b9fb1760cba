"""Vehicle and reference for agilicious: its quadrotor file (YAML), and beside it the reference as a sampled trajectory (CSV).

Its MPC commands rotor thrusts, not body rates, so the tuned weights mean nothing to it and are not written.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from hotlap.core.errors import InputError
from hotlap.exporters.rpg_mpc import number
from hotlap.race.quadrotor import Quadrotor
from hotlap.reference_files.csv import save_reference
from hotlap.study.study import Study
from hotlap.system.text_files import replace

PLACES = {"fr": (1, -1), "bl": (-1, 1), "br": (-1, -1), "fl": (1, 1)}  # signs of x and y, in the order of its motors
ON_AXIS = 1e-6  # of the arm
ASSUMED_SPEED = 2000.0  # rad/s at the largest thrust, where nobody says


def write(study: Study, path: Path) -> tuple[Path, ...]:
    """Write both; the study need not have ended.

    Raises:
        InputError: the vehicle has other rotors than agilicious knows, or a file cannot be written.
    """
    scenario = study.configuration.scenario
    reference = path.with_suffix(".csv")
    if reference == path:
        raise InputError(str(path), "", "is the name of the reference, which is written beside the vehicle: give a name that ends in .yaml")
    replace(path, quadrotor_yaml(scenario.race.vehicle, scenario.race.name, reference.name))
    save_reference(reference, scenario.reference)
    return path, reference


def quadrotor_yaml(vehicle: Quadrotor, race: str, reference: str) -> str:
    """The quadrotor file.

    Raises:
        InputError: it has not four rotors, one in each quarter.
    """
    least, most = vehicle.rotor_thrust
    fastest = vehicle.rotor_speed or ASSUMED_SPEED
    slope, (up, down) = most / fastest**2, vehicle.motor_time
    known = (
        ""
        if vehicle.rotor_speed
        else f"# The speed of its rotors is not known: thrust_map supposes {ASSUMED_SPEED:g} rad/s at thrust_max.\n"
    )
    lags = "" if up == down else f"# motor_tau is the mean of {up:g} s up and {down:g} s down.\n"
    rows = {
        "mass": number(vehicle.mass),
        **_places(vehicle),
        "inertia": _list(vehicle.inertia),
        "motor_omega_min": number(math.sqrt(least / slope)),
        "motor_omega_max": number(fastest),
        "motor_tau": number(round((up + down) / 2, 9)),
        "omega_max": _list(vehicle.rate_limit),
        "thrust_map": _list((slope, 0.0, 0.0)),
        "kappa": number(vehicle.torque_ratio),
        "thrust_min": number(least),
        "thrust_max": number(most),
        "aero_coeff_1": _list([vehicle.mass * value for value in vehicle.drag]),
    }
    head = f"# {vehicle.name}, by hotlap from the race {race}; the reference lies in {reference} (t, p, q, v, w, rotor thrusts).\n"
    return head + known + lags + "".join(f"{key}: {value}\n" for key, value in rows.items())


def _places(vehicle: Quadrotor) -> dict[str, str]:
    """Where each of four rotors sits; those of a plus count as an X that is turned by 45 degrees: the one in front as the front right."""
    places, turn = vehicle.rotor_positions, 1.0
    if np.abs(places).min() < ON_AXIS * vehicle.arm:
        turn = np.exp(-0.25j * np.pi)
    angles = (places @ [1, 1j]) * turn
    found = {}
    for name, (x, y) in PLACES.items():
        here = places[(angles.real * x > 0) & (angles.imag * y > 0)].tolist()
        if len(here) != 1 or vehicle.rotor_count != len(PLACES):
            raise InputError("", "format", f"agilicious takes four rotors, one in each quarter; {vehicle.name} has others")
        found[f"tbm_{name}"] = _list([*here[0], 0.0])
    return found


def _list(values: tuple[float, ...] | list[float]) -> str:
    return f"[{', '.join(map(number, values))}]"

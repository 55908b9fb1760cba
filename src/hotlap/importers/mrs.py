"""MRS multirotor simulator: its vehicles, YAML (github.com/ctu-mrs/mrs_multirotor_simulator)."""

from __future__ import annotations

import math

import numpy as np

from hotlap.core.errors import UnknownNameError
from hotlap.files.content import Content
from hotlap.files.kinds import Kind
from hotlap.importers.imported import Findings, Format
from hotlap.importers.rotors import count_rotors, fill_radius, place_rotors, squared


def _vehicles(content: Content) -> dict[str, Content]:
    """The vehicles of a file by name."""
    return {name: content[name] for name in content.table() if name in content and content[name].has("n_motors")}


def _matches(content: Content) -> bool:
    return bool(_vehicles(content))


def _read(content: Content, name: str | None) -> Findings:
    vehicles = _vehicles(content)
    vehicle = chosen(vehicles, name, content)
    count_rotors(int(vehicle["n_motors"].positive()), vehicle)
    mass, propulsion = vehicle["mass"].positive(), vehicle["propulsion"]
    found = Findings({"name": name or vehicle.key, "mass": mass})
    length, height = vehicle["arm_length"].positive(), vehicle["body_height"].positive()
    flat = mass * (3 * length**2 + height**2) / 12
    found.table["inertia"] = [flat, flat, mass * length**2 / 2]
    found.taken.append("inertia is that of a cylinder of arm_length and body_height, as the simulator takes it")
    _arms(found, propulsion, length)
    turns = [propulsion["rpm"][key].number() for key in ("min", "max")]
    squared(found, propulsion["force_constant"].positive(), turns, "force_constant * rpm.max^2, in revolutions a minute,")
    found.table["torque_ratio"] = propulsion["moment_constant"].positive()
    found.table["motor_time"] = [vehicle["motor_time_constant"].number()] * 2
    if "air_resistance_coeff" in vehicle:
        found.table["body_drag"] = [vehicle["air_resistance_coeff"].number() * math.pi * length**2] * 3
        found.taken.append("body_drag = air_resistance_coeff * pi * arm_length^2 along each axis; there it acts along the velocity")
    if "prop_radius" in propulsion:
        fill_radius(found, propulsion["prop_radius"].number(), "prop_radius")
    return found


def chosen(vehicles: dict[str, Content], name: str | None, content: Content) -> Content:
    """The vehicle of a name; the only one has any name.

    Raises:
        UnknownNameError: there are several, and none of this name.
        InputError: there are several, and no name was given.
    """
    if name in vehicles:
        return vehicles[name]
    if len(vehicles) == 1:
        return next(iter(vehicles.values()))
    if name is None:
        raise content.fault(f"describes {len(vehicles)} vehicles; choose one with name=...: {', '.join(vehicles)}")
    raise UnknownNameError("vehicle", name, vehicles, content.file)


def _arms(found: Findings, propulsion: Content, length: float) -> None:
    """Where the rotors sit: the first two rows of the allocation are y and -x over the arm's length."""
    allocation = propulsion["allocation_matrix"].vector(16)
    roll, pitch = np.array(allocation[:4]), np.array(allocation[4:8])
    unit = np.stack([-pitch, roll], axis=1)
    norms = np.linalg.norm(unit, axis=1, keepdims=True)
    exact = np.where(np.abs(norms - 1) < 1e-2, unit / np.maximum(norms, 1e-9), unit)  # 0.707 stands for sqrt(1/2)
    place_rotors(found, length * exact, propulsion["allocation_matrix"])


FORMATS = (Format("a vehicle of the MRS multirotor simulator (YAML)", Kind.QUADROTOR, _matches, _read),)

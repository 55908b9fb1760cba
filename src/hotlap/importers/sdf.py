"""Gazebo: multirotors in SDF, with the motor plugins of PX4, RotorS and Gazebo Sim."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hotlap.files.kinds import Kind
from hotlap.importers.bodies import together
from hotlap.importers.imported import Findings, Format
from hotlap.importers.markup import Markup
from hotlap.importers.rotors import count_rotors, fill_radius, place_rotors, squared
from hotlap.importers.sdf_frames import Pose, body_of
from hotlap.importers.sdf_models import Parts, vehicles_of

OF_MOTORS = ("motorConstant", "momentConstant", "maxRotVelocity", "timeConstantUp", "timeConstantDown", "rotorDragCoefficient")
UPRIGHT = 2.0  # deg: rotor axes that lean less stand upright
SLANTED = 0.01  # share of the moments that products of inertia may have without a word


def _matches(document: Markup) -> bool:
    return document.tag == "sdf"


def _read(document: Markup, name: str | None) -> Findings:
    parts = next(vehicles_of(document), None)
    if parts is None:
        raise document.fault("no model has plugins of motors (motorConstant, momentConstant, maxRotVelocity)")
    count_rotors(len(parts.motors), parts.model.attributes)
    found = Findings({"name": name or parts.model.name or None})
    found.lost += [f"{uri}: what it includes is not in a folder beside this one" for uri in parts.absent]
    centre = _weigh(found, parts)
    rotors = [_rotor(motor, parts) for motor in parts.motors]
    place_rotors(found, np.array([pose.position[:2] - centre[:2] for _, pose in rotors]), parts.model.attributes)
    _thrust(found, parts.motors)
    _size(found, rotors[0][0])
    _tell(found, parts, [pose for _, pose in rotors])
    return found


def _weigh(found: Findings, parts: Parts) -> NDArray[np.float64]:
    """Set mass and inertia; the centre of mass, shape (3,) [m]."""
    bodies = {name: body_of(*place) for name, place in parts.links.items()}
    weighed = [body for body in bodies.values() if body is not None]
    if not weighed:
        raise parts.model.fault("none of its links has a mass (inertial)")
    whole = together(weighed)
    moments = np.diag(whole.inertia)
    found.table |= {"mass": whole.mass, "inertia": moments.tolist()}
    found.taken.append(f"mass and inertia are those of {len(weighed)} links together, rotors included, about their common centre")
    found.lost += [f"link {name}: has no mass in the file" for name, body in bodies.items() if body is None]
    if np.abs(whole.inertia - np.diag(moments)).max() > SLANTED * moments.max():
        found.lost.append("products of inertia: the axes of the body are taken as principal")
    return whole.centre


def _rotor(motor: Markup, parts: Parts) -> tuple[Markup, Pose]:
    """The link that a motor turns."""
    name = (motor.one("linkName").element.text or "").strip()
    known = [link for link in parts.links if link.split("::")[-1] == name.split("::")[-1]]
    if not known:
        raise motor.one("linkName").fault(f"there is no link {name}")
    return parts.links[name if name in known else known[0]]


def _size(found: Findings, rotor: Markup) -> None:
    """Set the radius of the vehicle from the disc that stands for a rotor, where there is one."""
    radius = rotor.element.find("collision/geometry/cylinder/radius")
    if radius is not None:
        fill_radius(found, Markup(rotor.file, radius, f"{rotor.key}.collision").content.number(), "the rotors' collision radius")


def _tell(found: Findings, parts: Parts, rotors: list[Pose]) -> None:
    """Name what a vehicle has that ours have not."""
    tilt = max(math.degrees(math.acos(min(1.0, max(-1.0, pose.rotation[2, 2])))) for pose in rotors)
    if tilt > UPRIGHT:
        found.lost.append(f"rotor axes: tilted by up to {tilt:.0f} deg; ours push along the body's z axis")
    if any("lift" in plugin.element.get("filename", "").lower() for plugin in parts.plugins):
        found.lost.append("plugins of lift and drag: wings")


def _thrust(found: Findings, motors: list[Markup]) -> None:
    """Thrust, torque, lag and drag of the rotors, by what the first motor says."""
    first = motors[0]
    for key in OF_MOTORS:
        values = {motor.number(key) for motor in motors if motor.first(key) is not None}
        if len(values) > 1:
            found.lost.append(f"{key}: differs from rotor to rotor; that of the first is taken")
    factor = first.one("motorConstant").content.positive()
    squared(found, factor, [0.0, first.one("maxRotVelocity").content.positive()], "motorConstant * maxRotVelocity^2, in rad/s,")
    found.table["torque_ratio"] = first.one("momentConstant").content.positive()
    found.taken.append("momentConstant is torque over thrust, as our torque_ratio")
    found.table["motor_time"] = [first.number("timeConstantUp"), first.number("timeConstantDown")]
    if first.first("rotorDragCoefficient") is not None:
        found.table["rotor_drag"] = first.number("rotorDragCoefficient") / math.sqrt(factor)
        found.taken.append(
            "rotor_drag = rotorDragCoefficient / sqrt(motorConstant): drag by the rotor's speed as drag by the root of its thrust"
        )
    if first.first("rollingMomentCoefficient") is not None:
        found.lost.append("rollingMomentCoefficient: the torque of a rotor in side wind")


FORMATS = (Format("a multirotor for Gazebo (SDF)", Kind.QUADROTOR, _matches, _read, xml=True),)

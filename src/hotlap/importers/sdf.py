"""Gazebo: multirotors in SDF, with the motor plugins of PX4, RotorS and Gazebo Sim."""

from __future__ import annotations

import math
import re
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from hotlap.files.kinds import Kind
from hotlap.importers.bodies import together
from hotlap.importers.documents import read_document
from hotlap.importers.imported import Findings, Format
from hotlap.importers.markup import Markup
from hotlap.importers.rotors import count_rotors, fill_radius, place_rotors, squared
from hotlap.importers.sdf_frames import Pose, body_of, links_of, own_pose

Links = dict[str, tuple[Markup, Pose]]

OF_MOTORS = ("motorConstant", "momentConstant", "maxRotVelocity", "timeConstantUp", "timeConstantDown", "rotorDragCoefficient")
MODEL = re.compile(r"model://([\w.-]+)/?")
SLANTED = 0.01  # share of the moments that products of inertia may have without a word


def _matches(document: Markup) -> bool:
    return document.tag == "sdf"


def _read(document: Markup, name: str | None) -> Findings:
    model = _vehicle(document)
    found = Findings({"name": name or model.name or None})
    links = _all_links(found, model)
    motors = _motors(model)
    centre = _weigh(found, links, model)
    rotors = [_rotor(motor, links) for motor in motors]
    place_rotors(found, np.array([pose.position[:2] - centre[:2] for _, pose in rotors]), model.attributes)
    _thrust(found, motors)
    radius = rotors[0][0].element.find("collision/geometry/cylinder/radius")
    if radius is not None:
        fill_radius(
            found, Markup(model.file, radius, f"{rotors[0][0].key}.collision.radius").content.number(), "the rotors' collision radius"
        )
    return found


def _vehicle(document: Markup) -> Markup:
    """The model that has motors."""
    models = list(document.within("model"))
    with_motors = [model for model in models if any(plugin.first("motorConstant") is not None for plugin in model.all("plugin"))]
    if not with_motors:
        raise document.fault("no model has plugins of motors (motorConstant, momentConstant, maxRotVelocity)")
    return with_motors[0]


def _motors(model: Markup) -> list[Markup]:
    """The plugins of the four motors."""
    motors = [plugin for plugin in model.all("plugin") if plugin.first("motorConstant") is not None]
    count_rotors(len(motors), model.attributes)
    return motors


def _all_links(found: Findings, model: Markup) -> Links:
    """The links of a model and of those that it includes, which lie in a folder beside its own."""
    links = links_of(model)
    for include in model.all("include"):
        inner = _included(include)
        if inner is None:
            found.lost.append(f"{include.one('uri').element.text}: what it includes is not in a folder beside this one")
            continue
        name = include.first("name")
        prefix = "" if include.element.get("merge") == "true" else f"{inner.name if name is None else name.element.text}::"
        links |= {prefix + link: place for link, place in links_of(inner, own_pose(include)).items()}
    return links


def _included(include: Markup) -> Markup | None:
    """The model that is included, if it can be found."""
    named = MODEL.fullmatch((include.one("uri").element.text or "").strip())
    if named is None:
        return None
    folder = Path(include.file).absolute().parent.parent / named[1]
    file = next((path for path in (folder / "model.sdf", folder / f"{named[1]}.sdf") if path.is_file()), None)
    root = None if file is None else read_document(file)
    return Markup(str(file), root).first("model") if isinstance(root, Element) else None


def _weigh(found: Findings, links: Links, model: Markup) -> NDArray[np.float64]:
    """Set mass and inertia; the centre of mass, shape (3,) [m]."""
    bodies = {name: body_of(*place) for name, place in links.items()}
    weighed = [body for body in bodies.values() if body is not None]
    if not weighed:
        raise model.fault("none of its links has a mass (inertial)")
    whole = together(weighed)
    moments = np.diag(whole.inertia)
    found.table |= {"mass": whole.mass, "inertia": moments.tolist()}
    found.taken.append(f"mass and inertia are those of {len(weighed)} links together, rotors included, about their common centre")
    found.lost += [f"link {name}: has no mass in the file" for name, body in bodies.items() if body is None]
    if np.abs(whole.inertia - np.diag(moments)).max() > SLANTED * moments.max():
        found.lost.append("products of inertia: the axes of the body are taken as principal")
    return whole.centre


def _rotor(motor: Markup, links: Links) -> tuple[Markup, Pose]:
    """The link that a motor turns."""
    name = (motor.one("linkName").element.text or "").strip()
    known = [name] if name in links else [link for link in links if link.split("::")[-1] == name.split("::")[-1]]
    if not known:
        raise motor.one("linkName").fault(f"there is no link {name}")
    return links[known[0]]


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

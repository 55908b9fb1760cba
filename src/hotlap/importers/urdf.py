"""gym-pybullet-drones: its URDF, which says thrust and torque in <properties> (github.com/utiasDSL/gym-pybullet-drones)."""

from __future__ import annotations

import math

import numpy as np

from hotlap.files.content import Content
from hotlap.files.kinds import Kind
from hotlap.importers.imported import Findings, Format
from hotlap.importers.markup import Markup
from hotlap.importers.rotors import PER_MINUTE, fill_radius, from_weight, place_rotors

OFF = 0.02  # share by which `arm` may differ from the rotors' places without a word
LOST = {
    "drag_coeff_z": "drag of the rotors along their axis",
    "gnd_eff_coeff": "ground effect",
    "dw_coeff_1": "downwash of other drones",
    "max_speed_kmh": "a limit of speed",
}


def _matches(document: Markup) -> bool:
    return document.tag == "robot"


def _read(document: Markup, name: str | None) -> Findings:
    properties = document.first("properties")
    if properties is None:
        raise document.fault(
            "has no <properties> with kf, km and thrust2weight: only the URDF of gym-pybullet-drones says what its rotors do"
        )
    said = properties.attributes
    found = Findings({"name": name or document.name or None})
    _weigh(found, document)
    _arms(found, document, said)
    from_weight(found, said["thrust2weight"].positive(), "thrust2weight")
    found.table["torque_ratio"] = said["km"].positive() / said["kf"].positive()
    found.table["motor_time"] = [0.0, 0.0]
    found.taken += ["torque_ratio = km / kf", "PyBullet's motors follow at once: motor_time is 0"]
    if "drag_coeff_xy" in said:
        found.table["rotor_drag"] = said["drag_coeff_xy"].number() * PER_MINUTE / math.sqrt(said["kf"].positive())
        found.taken.append("rotor_drag = drag_coeff_xy * 2 pi / 60 / sqrt(kf); in PyBullet it acts with Physics.PYB_DRAG alone")
    if "prop_radius" in said:
        fill_radius(found, said["prop_radius"].number(), "prop_radius")
    found.lost += [f"{key}: {meaning}" for key, meaning in LOST.items() if key in said]
    return found


def _weigh(found: Findings, document: Markup) -> None:
    """Mass and inertia of the first link, as gym-pybullet-drones takes them."""
    inertial = document.one("link").one("inertial")
    moments = inertial.one("inertia").attributes
    found.table |= {
        "mass": inertial.one("mass").attributes["value"].positive(),
        "inertia": [moments[key].positive() for key in ("ixx", "iyy", "izz")],
    }


def _arms(found: Findings, document: Markup, said: Content) -> None:
    """Layout by the places of the propellers, arm by the property of this name."""
    places = [link.one("inertial").one("origin").attributes["xyz"] for link in document.all("link") if link.name.startswith("prop")]
    positions = [Content(place.file, place.text().split(), place.key).vector()[:2] for place in places]
    place_rotors(found, np.array(positions).reshape(-1, 2), document.attributes)
    arm = said["arm"].positive()
    if abs(arm / found.table["arm"] - 1) > OFF:
        found.lost.append(f"properties.arm = {arm:g} m: the propellers sit {found.table['arm']:.4g} m from the centre")
    else:
        found.table["arm"] = arm


FORMATS = (Format("a drone of gym-pybullet-drones (URDF)", Kind.QUADROTOR, _matches, _read, xml=True),)

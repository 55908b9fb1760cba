"""Agilicious: its quadrotors, YAML (github.com/uzh-rpg/agilicious)."""

from __future__ import annotations

import numpy as np

from hotlap.files.content import Content
from hotlap.files.kinds import Kind
from hotlap.importers.imported import Findings, Format
from hotlap.importers.rotors import from_diagonal, place_rotors

POSITIONS = ("tbm_fr", "tbm_bl", "tbm_br", "tbm_fl")
CUBE = np.array([2.25, 2.25, 4.0]) / 12  # inertia over mass and arm^2 where the file has none


def _matches(content: Content) -> bool:
    return any(key in content for key in ("kappa", "t_BM", "thrust_map", *POSITIONS))


def _read(content: Content, name: str | None) -> Findings:
    found = Findings({"name": name, "mass": content["mass"].positive()})
    _arms(found, content)
    _inertia(found, content)
    _thrust(found, content)
    found.table["torque_ratio"] = content["kappa"].positive()
    if "motor_tau" in content:
        found.table["motor_time"] = [content["motor_tau"].number()] * 2
    if "omega_max" in content:
        found.table["rate_limit"] = content["omega_max"].vector()
    _drag(found, content)
    return found


def _arms(found: Findings, content: Content) -> None:
    if "arm_length" in content:
        from_diagonal(found, content["arm_length"].positive(), "arm_length")
    elif "t_BM" in content:
        x, y, _ = content["t_BM"].matrix(3, 4)
        place_rotors(found, np.array([x, y]).T, content["t_BM"])
    else:
        place_rotors(found, np.array([content[key].vector()[:2] for key in POSITIONS]), content)


def _inertia(found: Findings, content: Content) -> None:
    if "inertia" in content:
        found.table["inertia"] = content["inertia"].diagonal()
        return
    found.table["inertia"] = (CUBE * found.table["mass"] * found.table["arm"] ** 2).tolist()
    found.taken.append("there is no inertia: that of a box as wide as the arm and half as high, as in agilicious")


def _thrust(found: Findings, content: Content) -> None:
    """The limits of thrust; without them those that the motors' speeds give."""
    by_speed = content.has("thrust_map", "motor_omega_max")
    a, b, c = content["thrust_map"].vector() if by_speed else (0.0, 0.0, 0.0)

    def thrust(speed: float) -> float:
        return a * speed * speed + b * speed + c

    fastest = content["motor_omega_max"].positive() if by_speed else 0.0
    if "thrust_max" in content or not by_speed:
        largest = content["thrust_max"].positive()
        if by_speed and abs(thrust(fastest) / largest - 1) > 0.01:
            found.taken.append(
                f"thrust_max = {largest:g} N bounds the thrust; thrust_map at motor_omega_max would give {thrust(fastest):.4g} N"
            )
    else:
        largest = thrust(fastest)
        found.taken.append(f"there is no thrust_max: thrust_map at motor_omega_max = {fastest:g} rad/s gives {largest:.4g} N")
    slowest = content["motor_omega_min"].number() if by_speed and "motor_omega_min" in content else 0.0
    least = content["thrust_min"].number() if "thrust_min" in content else max(0.0, thrust(slowest))
    found.table["rotor_thrust"] = [least, largest]


def _drag(found: Findings, content: Content) -> None:
    """The linear part; the others have no place here."""
    if "aero_coeff_1" in content and any(content["aero_coeff_1"].vector()):
        found.table["drag"] = [value / found.table["mass"] for value in content["aero_coeff_1"].vector()]
        found.taken.append("aero_coeff_1 is linear drag in N s/m; our drag is per mass")
    if "aero_coeff_3" in content and any(content["aero_coeff_3"].vector()):
        found.lost.append("aero_coeff_3: cubic drag")
    if "aero_coeff_h" in content and content["aero_coeff_h"].number():
        found.lost.append("aero_coeff_h: lift that grows with the speed across the rotors")


FORMATS = (Format("a quadrotor of agilicious (YAML)", Kind.QUADROTOR, _matches, _read),)

"""drone-models: the vehicles of its params.toml (github.com/learnsyslab/drone-models), on which crazyflow and lsy_drone_racing fly."""

from __future__ import annotations

from hotlap.files.content import Content
from hotlap.files.kinds import Kind
from hotlap.importers.imported import Findings, Format
from hotlap.importers.mrs import chosen
from hotlap.importers.rotors import fill_radius, from_lever


def _vehicles(content: Content) -> dict[str, Content]:
    """The vehicles of a file by name."""
    return {name: content[name] for name in content.table() if name in content and content[name].has("mass", "L", "J")}


def _matches(content: Content) -> bool:
    return bool(_vehicles(content))


def _read(content: Content, name: str | None) -> Findings:
    vehicle = chosen(_vehicles(content), name, content)
    found = Findings({"name": name or vehicle.key, "mass": vehicle["mass"].positive(), "inertia": vehicle["J"].diagonal()})
    from_lever(found, vehicle["L"].positive(), "L")
    found.table["rotor_thrust"] = [vehicle["thrust_min"].number(), vehicle["thrust_max"].positive()]
    found.table["torque_ratio"] = vehicle["thrust2torque"].positive()
    _motors(found, vehicle)
    if "drag_matrix" in vehicle:
        found.table["drag"] = [abs(value) / found.table["mass"] for value in vehicle["drag_matrix"].diagonal()]
        found.taken.append("drag_matrix is linear drag in N s/m; our drag is per mass")
    if "prop_radius" in vehicle:
        fill_radius(found, vehicle["prop_radius"].number(), "prop_radius")
    found.lost += [f"{key}: thrust is commanded here, not speed or voltage" for key in ("rpm2thrust", "vmotor2thrust") if key in vehicle]
    return found


def _motors(found: Findings, vehicle: Content) -> None:
    """One time constant, that of the simple model."""
    if "rotor_dyn_coef_simple" in vehicle:
        time = 1 / vehicle["rotor_dyn_coef_simple"].positive()
        found.table["motor_time"] = [time, time]
        found.taken.append(f"motor_time = 1 / rotor_dyn_coef_simple = {time:.3g} s")
    if "rotor_dyn_coef" in vehicle:
        found.lost.append("rotor_dyn_coef: other lags for faster and slower, and a quadratic part")


FORMATS = (Format("vehicles of drone-models (TOML)", Kind.QUADROTOR, _matches, _read),)

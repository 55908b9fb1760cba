"""lsy_drone_racing: the levels of its races, TOML (github.com/utiasDSL/lsy_drone_racing)."""

from __future__ import annotations

from hotlap.files.content import Content
from hotlap.files.kinds import Kind
from hotlap.importers.imported import Findings, Format
from hotlap.importers.turning import is_level, quaternion_of

OPENING = {"side": 0.4, "frame": 0.16}  # m: a square of 0.4 m in a frame of 0.72 m, by the comments of its files
POLE = 0.03  # m, the diameter of an obstacle
STAND = (0.07, 0.36)  # m: radius of a gate's stand, 0.1 m square, and how far below the gate's centre it ends (envs/assets/gate.xml)
GROUND = 0.0  # m
DRONE = 0.1  # m: the safety limits bound the drone's centre; our box holds all of it


def _is_level_file(content: Content) -> bool:
    return "env" in content and "track" in content["env"]


def _read(content: Content, name: str | None) -> Findings:
    track = content["env"]["track"]
    if "randomize" in track and track["randomize"].value is True:
        raise track["randomize"].fault("the gates are drawn anew for each flight: there is no track to import, unless it is false")
    found = Findings({"name": name})
    _begin(found, _first_drone(found, track))
    found.table["gates"] = [_gate(gate) for gate in track["gates"].entries()]
    found.table |= {"opening": OPENING, "floor": GROUND}
    _bound(found, track)
    obstacles = track["obstacles"].items() if "obstacles" in track else ()
    found.table["poles"] = [*(_pole(obstacle) for obstacle in obstacles), *map(_stand, found.table["gates"])]
    found.taken += [
        "a gate is given by its centre, angles in radians; it is passed along its x axis",
        f"openings of {OPENING['side']:g} m in frames {OPENING['frame']:g} m wide, as the comments of these files say",
        f"obstacles are poles of {POLE:g} m diameter from the ground up to their position",
        f"the gates' own stands are poles, too: 0.1 m square in the simulator, up to {STAND[1]:g} m below the centre",
    ]
    _tell(found, content)
    return found


def _first_drone(found: Findings, track: Content) -> Content:
    """The drone that starts; of several the first."""
    if "drone" in track:
        return track["drone"]
    drones = track["drones"].entries()
    found.lost += [f"{drone.key}: one drone flies here" for drone in drones[1:]]
    return drones[0]


def _begin(found: Findings, drone: Content) -> None:
    found.table["start"] = drone["pos"].vector()
    attitude = quaternion_of(*drone["rpy"].vector()) if "rpy" in drone else [1.0, 0.0, 0.0, 0.0]
    if not is_level(attitude):
        found.table["attitude"] = attitude
    if "vel" in drone and any(drone["vel"].vector()):
        found.table["start_velocity"] = drone["vel"].vector()
    if "ang_vel" in drone and any(drone["ang_vel"].vector()):
        found.lost.append(f"{drone.key}.ang_vel: a start does not turn")


def _gate(gate: Content) -> dict:
    roll, pitch, yaw = gate["rpy"].vector()
    return {"position": gate["pos"].vector(), "yaw": yaw, **({"pitch": pitch} if pitch else {}), **({"roll": roll} if roll else {})}


def _pole(obstacle: Content) -> dict:
    x, y, top = obstacle["pos"].vector()
    if top <= GROUND:
        raise obstacle["pos"].fault(f"must be the top of a pole, above the ground, not at {top:g} m")
    return {"position": [x, y], "radius": POLE / 2, "top": top}


def _stand(gate: dict) -> dict:
    """The stand of a gate."""
    x, y, z = gate["position"]
    radius, below = STAND
    return {"position": [x, y], "radius": radius, "top": z - below}


def _bound(found: Findings, track: Content) -> None:
    """The box that must not be left."""
    if "safety_limits" not in track:
        return
    limits = track["safety_limits"]
    low, high = limits["pos_limit_low"].vector(), limits["pos_limit_high"].vector()
    found.table["box"] = {"low": [value - DRONE for value in low], "high": [value + DRONE for value in high]}
    found.taken.append(f"box is the safety limits and {DRONE:g} m around them: they bound the drone's centre, our box all of it")


def _tell(found: Findings, content: Content) -> None:
    """Name what is not carried over."""
    for key in ("disturbances", "randomizations"):
        if key in content["env"]:
            drawn = ", ".join(content["env"][key].table())
            found.lost.append(f"env.{key}: {drawn}: random there; here see [noise] of a race, and what a tuning can randomise")
    if "sensor_range" in content["env"]:
        found.lost.append("env.sensor_range: the controller knows every gate here")
    if "sim" in content and "drone_model" in content["sim"]:
        model = content["sim"]["drone_model"].text()
        found.lost.append(f"sim.drone_model: the vehicle is {model}; import it from params.toml of drone-models, as {model}")


FORMATS = (Format("a level of lsy_drone_racing (TOML)", Kind.TRACK, _is_level_file, _read),)

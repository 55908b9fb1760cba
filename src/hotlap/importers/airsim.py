"""AirSim: the gates of the level that runs, read over its API; for AirSim, Cosys-AirSim and AirSim Drone Racing Lab."""

from __future__ import annotations

import re
from contextlib import closing
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.files.content import Content
from hotlap.importers.imported import Findings
from hotlap.importers.turning import angles_of
from hotlap.worlds.airsim.address import address_of
from hotlap.worlds.airsim.client import CallError, Client
from hotlap.worlds.airsim.frames import rotation_of, vector_of
from hotlap.worlds.simulator import SimulatorError

Floats = NDArray[np.float64]
NAME = "the gates of a level of AirSim"
GATES, NUMBER = "Gate.*", re.compile(r"Gate\D*?(\d+)")
OPENING, OUTER = 1.6, 3.2 / 1.5  # m: the square opening of Drone Racing Lab's gate at scale 1, and the outside of its frame
NOISY, NED = False, True  # second argument of simGetObjectPose in Drone Racing Lab, and in Cosys-AirSim
TRIES = 10  # Drone Racing Lab says NaN now and then
NEAR = 0.01  # m
STANDING, HEIGHT = 0, 1.0  # landed_state on the ground; m above it from which a flight starts


@dataclass
class _Level:
    """What a level says of its gates, in the order of their numbers, and in our frame.

    Attributes:
        names: of the objects.
        positions: shape (gates, 3) [m].
        rotations: shape (gates, 3, 3): the columns are AirSim's front, right and down of a gate.
        scales: shape (gates, 3), along the same.
        start: shape (3,) [m] where the vehicle is, from where it was set up.
        origin: shape (3,) [m] where it was set up in the level; None: the level does not say.
        stands: whether it stands on the ground.
        is_racing_lab: whether it is a level of Drone Racing Lab.
        how: arguments behind an object's name that its pose is asked for with.
        others: objects that are called gates but have no number.
    """

    names: list[str] = field(default_factory=list)
    positions: Floats = field(default_factory=lambda: np.empty((0, 3)))
    rotations: Floats = field(default_factory=lambda: np.empty((0, 3, 3)))
    scales: Floats = field(default_factory=lambda: np.empty((0, 3)))
    start: Floats = field(default_factory=lambda: np.zeros(3))
    origin: Floats | None = None
    stands: bool = False
    is_racing_lab: bool = False
    how: tuple[bool, ...] = ()
    others: list[str] = field(default_factory=list)


def read_level(text: str, name: str | None) -> tuple[str, Findings]:
    """The track of a level that runs.

    Args:
        text: `airsim://host:port:vehicle`, of which everything after the first colon may be missing.
        name: what the track is to be called.

    Returns:
        The address as it was understood, and what was found there.

    Raises:
        InputError: nobody answers there, it has no gates with numbers, or says what cannot be.
    """
    try:
        address = address_of(text.partition(":")[2].strip("/"))
    except ValueError as error:
        raise InputError(text, "", str(error)) from None
    source = f"airsim://{address.host}:{address.port}{':' if address.vehicle else ''}{address.vehicle}"
    try:
        with closing(Client(address.host, address.port)) as client:
            level = _read(client, address.vehicle, source)
    except SimulatorError as error:
        raise InputError("", "", str(error)) from error
    found = Findings({"name": name or "airsim"})
    _start(found, level)
    _gates(found, level)
    return source, found


def _read(client: Client, vehicle: str, source: str) -> _Level:
    """Ask for everything."""
    names = Content(source, client.call("simListSceneObjects", GATES), "simListSceneObjects")
    numbered, level = [], _Level(is_racing_lab=_is_racing_lab(client, vehicle))
    level.how = (NOISY,) if level.is_racing_lab else ()
    for name in sorted(entry.text() for entry in names.items()):
        number = NUMBER.match(name)
        if number:
            numbered.append((int(number[1]), name))
        else:
            level.others.append(name)
    if not numbered:
        raise InputError(source, "", "no object of the level is called Gate with a number, Gate0, Gate1, ...: there is no course to read")
    level.names = [name for _, name in sorted(numbered)]
    poses = [_pose(client, name, level, source) for name in level.names]
    level.positions = np.array([vector_of(pose["position"]) for pose in poses]) + 0.0  # no negative zeros
    level.rotations = np.array([rotation_of(pose["orientation"]) for pose in poses])
    scales = [Content(source, client.call("simGetObjectScale", name), f"simGetObjectScale({name})") for name in level.names]
    level.scales = np.abs([vector_of(scale) for scale in scales])
    told = Content(source, client.call("getMultirotorState", vehicle), "getMultirotorState")
    level.start = vector_of(told["kinematics_estimated"]["position"]) + 0.0
    level.origin = _origin(client, vehicle, level, source)
    level.stands = "landed_state" in told and told["landed_state"].number() == STANDING
    return level


def _origin(client: Client, vehicle: str, level: _Level, source: str) -> Floats | None:
    """Where in the level the vehicle's own coordinates begin: `settings.json` may put it anywhere."""
    try:
        known = [vehicle] if vehicle else client.call("listVehicles")
        pose = _pose(client, str(known[0]), level, source)
        return vector_of(pose["position"]) - level.start
    except (CallError, InputError, LookupError, TypeError):
        return None


def _pose(client: Client, name: str, level: _Level, source: str) -> Content:
    """Where an object is, truly: Drone Racing Lab adds noise if it is asked to, and Cosys-AirSim turns the frame."""
    pose = Content(source, None)
    for _ in range(TRIES):
        try:
            told = client.call("simGetObjectPose", name, *level.how)
        except CallError as error:
            if level.how or not error.wants_other_arguments:
                raise
            level.how = (NED,)
            told = client.call("simGetObjectPose", name, *level.how)
        pose = Content(source, told, f"simGetObjectPose({name})")
        if all(value == value for value in pose["position"].table().values()):  # noqa: PLR0124  NaN is not itself
            break
    return pose


def _is_racing_lab(client: Client, vehicle: str) -> bool:
    """Whether this is Drone Racing Lab: it alone counts gates."""
    try:
        client.call("simGetLastGatePassed", vehicle)
    except CallError as error:
        return not error.unknown
    return True


def _start(found: Findings, level: _Level) -> None:
    """Where a flight begins: at the vehicle, off the ground."""
    height = HEIGHT if level.stands else 0.0
    found.table["start"] = (level.start + np.array([0.0, 0.0, height])).tolist()
    above = f", {HEIGHT:g} m above the ground on which it stands" if level.stands else ""
    found.taken.append(f"the start is where the vehicle is{above}")


def _gates(found: Findings, level: _Level) -> None:
    """The gates, turned so that they are passed along their normals."""
    course = _course(level)
    normals, axis = _normals(level, course)
    gates = []
    for position, rotation, normal in zip(level.positions - _moved(found, level), level.rotations, normals, strict=True):
        up = -rotation[:, 2]
        turned = np.stack([normal, np.cross(up, normal), up], axis=1)
        gates.append({"position": position.tolist(), **angles_of(turned)})
    found.table["gates"] = gates
    along = f"its {axis} axis" if level.is_racing_lab else f"its {axis} axis, which fits the course better, in the course's direction"
    found.taken += [
        "AirSim's north, east, down are our x, -y, -z",
        f"the order is that of the numbers: {', '.join(level.names)}",
        f"a gate is passed along {along}",
    ]
    against = [name for name, normal, along in zip(level.names, normals, course, strict=True) if normal @ along < 0]
    if against:
        found.taken.append(f"passed against the course from gate to gate, look at their yaw: {', '.join(against)}")
    _size(found, level)
    found.lost += [f"{name}: has no number, so its place in the order is not known" for name in level.others]


def _moved(found: Findings, level: _Level) -> Floats:
    """Where the vehicle's coordinates begin, shape (3,): gates are told in the level's, the vehicle's flight in its own."""
    if level.origin is None:
        found.taken.append("the vehicle's coordinates begin at the origin of the level, as it is set up at X = Y = Z = 0 in settings.json")
        return np.zeros(3)
    if np.abs(level.origin).max() > NEAR:
        x, y, z = level.origin
        found.taken.append(f"coordinates are the vehicle's, which begin at ({x:.2f}, {y:.2f}, {z:.2f}) m of the level")
    return level.origin


def _course(level: _Level) -> Floats:
    """From the gate before each gate to the one behind it, shape (gates, 3)."""
    around = np.vstack([level.start + (0.0 if level.origin is None else level.origin), level.positions, level.positions[-1:]])
    return around[2:] - around[:-2]


def _normals(level: _Level, course: Floats) -> tuple[Floats, str]:
    """The ways in which the gates are passed, shape (gates, 3), and the axis along which: y in Drone Racing Lab, else the likelier one."""
    front, right = level.rotations[:, :, 0], level.rotations[:, :, 1]
    if level.is_racing_lab:
        return right, "y"
    along = {axis: (vectors * course).sum(axis=1) for axis, vectors in (("x", front), ("y", right))}
    axis = max(along, key=lambda name: float(np.abs(along[name]).sum()))
    return np.sign(along[axis] + 1e-12)[:, None] * (front if axis == "x" else right), axis


def _size(found: Findings, level: _Level) -> None:
    """The openings, of which Drone Racing Lab alone says how large they are."""
    if not level.is_racing_lab:
        scales = ", ".join(f"{x:g} {y:g} {z:g}" for x, y, z in np.unique(level.scales, axis=0))
        found.lost.append(f"opening: AirSim does not say how large a gate is, only its scale ({scales}): set opening = {{ side = ... }}")
        return
    sizes = [{"width": OPENING * x, "height": OPENING * z, "frame": (OUTER - OPENING) / 2 * x} for x, _, z in level.scales.tolist()]
    found.taken.append(f"openings of {OPENING:g} m by {OPENING:g} m in frames {(OUTER - OPENING) / 2:.3f} m wide, by each gate's scale")
    if all(size == sizes[0] for size in sizes):
        found.table["opening"] = sizes[0]
    else:
        for gate, size in zip(found.table["gates"], sizes, strict=True):
            gate.update(size)

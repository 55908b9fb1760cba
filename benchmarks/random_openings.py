"""Plans on random tracks with openings and obstacles, tested by geometry of its own: python benchmarks/random_openings.py --help

Gates of all shapes, some of them flipped, turned sideways or tilted, tunnels, frames, and up to ten obstacles near the way. A track is
planned or refused with a reason; what is planned passes every gate in its turn and direction, crosses none the wrong way and touches
nothing. The test shares no code with the planner: it samples every millisecond, asks rays whether a point lies within a polygon, and takes
frames for clouds of points. Results are kept in `--out`; the same command continues where it was interrupted, and plans anew
what older code has planned.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial import KDTree

from hotlap.analysis.resumable import digest_code
from hotlap.core.errors import PlanningError
from hotlap.files.descriptions import load_race
from hotlap.planning import plan
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import PlanDynamics, PlanningSettings, Race
from hotlap.race.track import Gate, Track
from hotlap.reference.reference import Reference
from hotlap.system.journal import Journal

Floats = NDArray[np.float64]

STEP = 1e-3  # s between the places that are tested
CLOUD = 0.02  # m between the points that stand for a frame
NEAR = 2e-3  # m: what overlaps by less does not touch
EDGE = 0.002  # m: by how much a rim may be overlapped

DRONE = Quadrotor(
    name="racer",
    mass=0.85,
    inertia=(0.001, 0.001, 0.0017),
    arm=0.15,
    rotor_thrust=(0.0, 6.9),
    torque_ratio=0.05,
    rate_limit=(12.0, 12.0, 3.0),
    motor_time=(0.03, 0.03),
)


@dataclass(frozen=True)
class Outcome:
    """What became of one track: a duration [s], or the reason of a refusal; what the test found; and the planner's CPU time [s]."""

    seed: int
    gates: int
    obstacles: int
    duration: float | None
    refused: str
    faults: tuple[str, ...]
    cpu_time: float


def random_race(seed: int, dynamics: PlanDynamics = PlanDynamics.IDEAL) -> Race:
    """A race drawn from a seed."""
    rng = np.random.default_rng([seed, 0x6F70656E])
    count = int(rng.integers(3, 9))
    points = _walk(count + 2, rng)
    frame = float(rng.choice([0.0, 0.2, 0.4]))
    gates = [_gate(points, k, frame, rng) for k in range(1, count + 1)]
    radius = round(float(rng.uniform(0.08, 0.25)), 3)
    ends = {"end": _tuple(points[-1]), "end_at_rest": True} if rng.random() < 0.5 else {}
    track = Track.model_validate(
        {
            "name": f"openings-{seed}",
            "start": _tuple(points[0]),
            "gates": tuple(gates),
            "floor": 0.0,
            **_obstacles(points, radius, rng),
            **ends,
        }
    )
    vehicle = DRONE.model_copy(update={"radius": radius})
    settings = PlanningSettings(quadrotor=vehicle if dynamics is PlanDynamics.IDEAL else None, dynamics=dynamics)
    return load_race("circle-34").model_copy(
        update={"name": track.name, "track": track, "vehicle": vehicle, "model": None, "planning": settings}
    )


def _walk(count: int, rng: np.random.Generator) -> Floats:
    """Points from 4 to 10 m apart, 1 to 5 m high."""
    headings = np.cumsum(rng.normal(0, 0.9, count - 1))
    steps = np.stack([np.cos(headings), np.sin(headings)], axis=1) * rng.uniform(4, 10, (count - 1, 1))
    flat = np.vstack([[0.0, 0.0], np.cumsum(steps, axis=0)])
    return np.round(np.column_stack([flat, rng.uniform(1.2, 4.5, count)]), 3)


def _gate(points: Floats, k: int, frame: float, rng: np.random.Generator) -> dict[str, Any]:
    """A gate that faces the way, more or less; some are flipped, some stand sideways."""
    onwards = points[k + 1] - points[k - 1]
    turned = float(rng.choice([0.0, math.pi, math.pi / 2, -math.pi / 2], p=[0.7, 0.1, 0.1, 0.1]))
    yaw = math.atan2(onwards[1], onwards[0]) + rng.normal(0, 0.3) + turned
    size = float(rng.uniform(0.8, 2.4))
    shapes = (
        {"side": size},
        {"width": size, "height": 0.8 * size},
        {"radius": size / 2},
        {"corners": ((0.0, 0.6 * size), (-0.6 * size, -0.4 * size), (0.6 * size, -0.4 * size))},
    )
    gate: dict[str, Any] = {"position": _tuple(points[k]), "yaw": (yaw + math.pi) % (2 * math.pi) - math.pi, "frame": frame}
    gate |= shapes[int(rng.integers(len(shapes)))]
    if rng.random() < 0.2:
        gate["pitch"] = float(rng.uniform(-1.2, 1.2))
    if rng.random() < 0.1:
        gate["depth"] = float(rng.uniform(0.3, 2.0))
    gate["direction"] = str(rng.choice(["forward", "backward", "either"], p=[0.8, 0.1, 0.1]))
    if gate["direction"] == "backward":
        gate["yaw"] = (gate["yaw"] + 2 * math.pi) % (2 * math.pi) - math.pi
    return gate


def _obstacles(points: Floats, radius: float, rng: np.random.Generator) -> dict[str, Any]:
    """Up to ten obstacles beside the straight legs or on them, none at a gate."""
    found: dict[str, list[dict[str, Any]]] = {"poles": [], "spheres": [], "boxes": []}
    for _ in range(int(rng.integers(0, 11))):
        k = int(rng.integers(len(points) - 1))
        centre = points[k] + rng.uniform(0.25, 0.75) * (points[k + 1] - points[k]) + rng.normal(0, 0.7, 3)
        size, kind = float(rng.uniform(0.05, 0.6)), str(rng.choice(["poles", "spheres", "boxes"]))
        gaps = np.linalg.norm((points - centre)[:, :2], axis=1)
        if gaps.min() < 1.8 * size + 1.5 + radius:
            continue
        if kind == "poles":
            found[kind].append({"position": _tuple(centre[:2]), "radius": size / 3, **({"top": 3.0} if rng.random() < 0.5 else {})})
        elif kind == "spheres":
            found[kind].append({"position": _tuple(centre), "radius": size})
        else:
            half = size * rng.uniform(0.5, 1.0, 3)
            found[kind].append({"low": _tuple(centre - half), "high": _tuple(centre + half)})
    return {kind: tuple(things) for kind, things in found.items()}


def _tuple(values: Floats) -> tuple[float, ...]:
    return tuple(float(value) for value in np.round(values, 4))


def faults(race: Race, reference: Reference) -> tuple[str, ...]:
    """What a reference does wrong on its track."""
    rows = min(reference.planned_rows + 3, len(reference.times))
    spline = CubicHermiteSpline(reference.times[:rows], reference.position[:rows], reference.velocity[:rows])
    times = np.arange(0.0, reference.duration + 0.02, STEP)
    points = spline(times)
    flown = points[times <= reference.duration]
    radius, track = race.vehicle.outer_radius, race.track
    return (
        *_gate_faults(race, times, points),
        *_touched(track, flown, radius),
        *(f"touches the frame of gate {k}" for k, gate in enumerate(track.gates, 1) if _frame_touched(gate, flown, radius)),
        *(["goes below the floor"] if track.floor is not None and flown[:, 2].min() < track.floor - NEAR else []),
    )


def _gate_faults(race: Race, times: Floats, points: Floats) -> list[str]:
    found, now = [], -1.0
    for k, gate in enumerate(race.track.gates, 1):
        moments, forward, inside = _crossings(gate, times, points, race.vehicle.outer_radius - EDGE)
        good = inside & (forward | (gate.direction == "either")) & (moments > now)
        if not good.any():
            return [*found, f"does not pass gate {k}"]
        now = float(moments[good][0])
        wide = _crossings(gate, times, points, 0.0)[2]
        if gate.direction != "either" and (~forward & wide).any():
            found.append(f"crosses gate {k} the wrong way")
    return found


def _crossings(gate: Gate, times: Floats, points: Floats, size: float) -> tuple[Floats, NDArray[np.bool_], NDArray[np.bool_]]:
    """When a gate's plane is crossed, whether in its direction, and whether within its opening with a margin [m]."""
    normal, left, up = _axes(gate)
    offsets = points - np.array(gate.position)
    heights = offsets @ normal
    rows = np.flatnonzero((heights[:-1] < 0) != (heights[1:] < 0))
    shares = heights[rows] / (heights[rows] - heights[rows + 1])
    places = offsets[rows] + shares[:, None] * (offsets[rows + 1] - offsets[rows])
    flat = np.stack([places @ left, places @ up], axis=1)
    inside = _fits(gate, flat, size)
    forward = (heights[rows + 1] > heights[rows]) != (gate.direction == "backward")
    return times[rows] + shares * STEP, forward, inside


def _axes(gate: Gate) -> tuple[Floats, Floats, Floats]:
    """Normal, left and up of a gate, by turning one after the other."""
    yaw, pitch, roll = gate.yaw or 0.0, gate.pitch, gate.roll
    normal = np.array([math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), -math.sin(pitch)])
    level = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
    upright = np.cross(normal, level)
    return normal, math.cos(roll) * level + math.sin(roll) * upright, math.cos(roll) * upright - math.sin(roll) * level


def _outline(gate: Gate) -> Floats:
    """Points around an opening, closely spaced, shape (k, 2)."""
    if gate.radius:
        angles = np.linspace(0, 2 * math.pi, 400)
        return gate.radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    corners = _corners(gate)
    shares = np.linspace(0, 1, 200)[:, None]
    return np.vstack([one + shares * (other - one) for one, other in zip(corners, np.roll(corners, -1, axis=0), strict=True)])


def _corners(gate: Gate) -> Floats:
    if gate.corners:
        return np.array(gate.corners)
    width, height = (gate.side, gate.side) if gate.side else (gate.width, gate.height)
    return np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * np.array([width, height]) / 2


def _fits(gate: Gate, places: Floats, size: float) -> NDArray[np.bool_]:
    """Whether circles of a radius [m] around places (n, 2) fit into an opening: rays to the right leave it an odd number of times."""
    corners = _outline(gate) if gate.radius else _corners(gate)
    x, y = places[:, :1], places[:, 1:]
    one, other = corners.T[:, None], np.roll(corners, -1, axis=0).T[:, None]
    across = (one[1] > y) != (other[1] > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        ahead = one[0] + (y - one[1]) / (other[1] - one[1]) * (other[0] - one[0]) > x
    inside = (across & ahead).sum(axis=1) % 2 == 1
    return inside & (KDTree(_outline(gate)).query(places)[0] >= size)


def _frame_touched(gate: Gate, points: Floats, radius: float) -> bool:
    """Whether a ball comes into a frame, which is a cloud of points around the opening."""
    if gate.frame == 0:
        return False
    normal, left, up = _axes(gate)
    reach = float(np.linalg.norm(_outline(gate), axis=1).max()) + gate.frame
    near = points[np.linalg.norm(points - np.array(gate.position), axis=1) < reach + gate.depth + radius + 0.1]
    if not len(near):
        return False
    ticks = np.arange(-reach, reach + CLOUD, CLOUD)
    grid = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
    distances = KDTree(_outline(gate)).query(grid)[0]
    ring = grid[~_fits(gate, grid, 0.0) & (distances <= gate.frame)]
    layers = np.arange(-gate.depth / 2, gate.depth / 2 + CLOUD / 2, CLOUD)
    cloud = np.vstack([np.array(gate.position) + x * normal + ring[:, :1] * left + ring[:, 1:] * up for x in layers])
    return bool(KDTree(cloud).query(near)[0].min() < radius - NEAR)


def _touched(track: Track, points: Floats, radius: float) -> list[str]:
    """Which obstacles are touched."""
    found = []
    for k, pole in enumerate(track.poles, 1):
        beside = np.maximum(np.hypot(*(points[:, :2] - np.array(pole.position)).T) - pole.radius, 0.0)
        above = np.maximum(points[:, 2] - (math.inf if pole.top is None else pole.top), 0.0)
        if np.hypot(beside, above).min() < radius - NEAR:
            found.append(f"touches pole {k}")
    for k, sphere in enumerate(track.spheres, 1):
        if np.linalg.norm(points - np.array(sphere.position), axis=1).min() < sphere.radius + radius - NEAR:
            found.append(f"touches sphere {k}")
    for k, box in enumerate(track.boxes, 1):
        if np.linalg.norm(points - np.clip(points, box.low, box.high), axis=1).min() < radius - NEAR:
            found.append(f"touches box {k}")
    return found


def try_one(seed: int, dynamics: PlanDynamics = PlanDynamics.IDEAL) -> Outcome:
    """Plan one track and test the plan."""
    race, start = random_race(seed, dynamics), time.process_time()
    obstacles = len(race.track.poles) + len(race.track.spheres) + len(race.track.boxes)
    try:
        reference = plan(race, cache=False)
    except PlanningError as error:
        return Outcome(seed, len(race.track.gates), obstacles, None, str(error), (), time.process_time() - start)
    spent = time.process_time() - start
    return Outcome(seed, len(race.track.gates), obstacles, reference.duration, "", faults(race, reference), spent)


def table(outcomes: Sequence[Outcome]) -> str:
    """What became of all tracks, and each that was refused or is faulty."""
    planned = [outcome for outcome in outcomes if outcome.duration is not None]
    times = np.array([outcome.cpu_time for outcome in planned] or [math.nan])
    counts = len(outcomes), len(planned), len(outcomes) - len(planned), sum(bool(one.faults) for one in outcomes)
    lines = [
        f"{'tracks':>8} {'planned':>8} {'refused':>8} {'faulty':>8} {'CPU s median':>13} {'90 %':>6} {'most':>6}",
        "{:8} {:8} {:8} {:8} {:13.2f} {:6.2f} {:6.2f}".format(*counts, np.median(times), np.quantile(times, 0.9), times.max()),
    ]
    lines += [f"  {one.seed}: {one.refused}" for one in outcomes if one.refused]
    lines += [f"  {one.seed}: {'; '.join(one.faults)}" for one in outcomes if one.faults]
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Plan the tracks that are missing, and print the table of all."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--tracks", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--dynamics", choices=[choice.value for choice in PlanDynamics], default="ideal")
    parser.add_argument("--out", type=Path, default=Path("build/random-openings"))
    options = parser.parse_args(arguments)
    keys = {f"{options.dynamics} {seed}": seed for seed in range(options.first, options.first + options.tracks)}
    with Journal.opened(options.out, digest_code(Path(__file__))) as kept:
        for key, seed in keys.items():
            if key not in kept.done:
                kept.add(key, dataclasses.asdict(try_one(seed, PlanDynamics(options.dynamics))))
    print(table([Outcome(**kept.done[key]) for key in keys]))


if __name__ == "__main__":
    main()

"""A hall with everything that can stand on a track, and a reference through it in straight lines, made by hand."""

from __future__ import annotations

import math

import numpy as np

from fake_world import make_scenario
from hotlap.race.gate import Gate
from hotlap.race.obstacles import Box, Pole, Sphere
from hotlap.race.race import JudgeSettings
from hotlap.race.track import Track
from hotlap.reference.reference import Reference
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentClass, Segments

ROWS, REST, PERIOD = 2001, 200, 0.01

SQUARE = Gate(position=(6.0, 0.0, 2.0), yaw=0.0, side=1.6, frame=0.3)
TRIANGLE = Gate(position=(13.0, 1.0, 2.5), yaw=0.4, corners=((-1.2, -0.8), (1.2, -0.8), (0.0, 1.4)), frame=0.15)
TUNNEL = Gate(position=(20.0, 3.0, 3.0), yaw=0.2, width=1.6, height=1.2, depth=2.5, frame=0.1)
FLAT = Gate(position=(27.0, 4.0, 4.5), yaw=0.0, pitch=math.pi / 2, side=1.6)
BACKWARD = Gate(position=(30.0, 9.0, 2.5), yaw=-math.pi / 2, side=1.6, direction="backward", frame=0.3)
EITHER = Gate(position=(22.0, 12.0, 2.0), yaw=0.1, radius=0.8, direction="either", frame=0.2)
BALL = Gate(position=(14.0, 11.0, 2.5), radius=0.7)
UNCOUNTED = Gate(position=(10.0, 11.5, 3.0), counts=False)
POINT = Gate(position=(6.0, 9.0, 2.0))
TURNED = Gate(position=(0.0, 4.0, 2.0), yaw=-1.9)
GATES = (SQUARE, TRIANGLE, TUNNEL, FLAT, BACKWARD, EITHER, BALL, UNCOUNTED, POINT, TURNED)

HALL = Track(
    name="hall",
    start=(0.0, 0.0, 1.0),
    gates=GATES,
    laps=2,
    floor=0.0,
    ceiling=7.0,
    box=Box(low=(-6.0, -8.0, -0.1), high=(36.0, 16.0, 7.5)),
    poles=(Pole(position=(9.5, -1.5), radius=0.1, top=3.0, bottom=0.0), Pole(position=(17.0, 6.0), radius=0.4)),
    spheres=(Sphere(position=(25.0, 8.0, 2.0), radius=1.0),),
    boxes=(Box(low=(2.0, 5.5, 0.0), high=(5.0, 7.0, 2.5)),),
)


def make_hall(track: Track = HALL, judge: JudgeSettings | None = None) -> Scenario:
    """A scenario on a track, flown from corner to corner at one speed, level."""
    race = make_scenario().race
    race = type(race)(name=track.name, track=track, vehicle=race.vehicle, judge=judge or JudgeSettings(rule="closest"))
    corners = np.vstack([track.start, track.waypoints])
    lengths = np.append(0.0, np.linalg.norm(np.diff(corners, axis=0), axis=1).cumsum())
    duration = (ROWS - 1) * PERIOD
    times = lengths / lengths[-1] * duration
    along = np.minimum(PERIOD * np.arange(ROWS + REST), duration)
    position = np.stack([np.interp(along, times, column) for column in corners.T], axis=1)
    rows, zeros = ROWS + REST, np.zeros((ROWS + REST, 3))
    gate_times = times[1:][[point.counts for point in track.route]]
    velocity = np.gradient(position, PERIOD, axis=0)
    attitude, rotors = np.tile([1.0, 0.0, 0.0, 0.0], (rows, 1)), np.full((rows, 4), 2.4525)
    reference = Reference(position, attitude, velocity, zeros, np.full(rows, 9.81), rotors, gate_times=gate_times, duration=duration)
    return Scenario(race, reference, Segments(np.array([0.0, 2.5]), (SegmentClass.FLAT, SegmentClass.ASCENT), duration))


def scaled(track: Track, factor: float) -> Track:
    """The same track, all lengths times a factor."""
    sized = {"radius", "side", "width", "height", "depth", "frame", "top", "bottom", "position", "low", "high", "corners", "start"}

    def grow(value: object, key: str) -> object:
        if isinstance(value, dict):
            return {name: grow(part, name) for name, part in value.items()}
        if isinstance(value, (list, tuple)):
            return tuple(grow(part, key) for part in value)
        return value * factor if key in sized | {"floor", "ceiling"} and isinstance(value, (int, float)) else value

    return Track.model_validate({key: grow(value, key) for key, value in track.model_dump(exclude_none=True).items()})

"""What a track means: its length, its spacing and its turns, and what of it lies within an obstacle."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hotlap.feasibility.finding import Finding, Level, note_if
from hotlap.race.gate_plane import plane_of
from hotlap.race.solids import solids_of
from hotlap.race.track import Track

FAR = 300.0  # m, between two gates of no race: centimetres perhaps
NEAR = 0.05  # m, likewise: degrees perhaps
ANY = 1.0  # m, radius of gates with an orientation alone, which have no frame to lie within


def describe_track(track: Track) -> tuple[Finding, ...]:
    """Length, spacing and turns of a track."""
    points = np.vstack([track.start, track.waypoints])
    legs = np.diff(points, axis=0)
    lengths = np.linalg.norm(legs, axis=1)
    names = ["the start", *(point.name for point in track.route)]
    vast = bool(lengths.max() > FAR)
    straight = "in straight lines; gates are in metres" if vast else "in straight lines"
    end = "and an end beyond the last one" if track.end is not None else "the last one is the end"
    findings = [
        Finding(
            label="gates",
            value=str(len(track.counted)),
            remark=end if track.laps == 1 else f"in {track.laps} laps, {end}",
            figures={"gates": len(track.counted), "laps": track.laps},
        ),
        Finding("length", f"{lengths.sum():.0f} m", straight, note_if(vast), {"length_m": float(lengths.sum())}),
        _heights(track, points[:, 2]),
        _closest(lengths, names),
    ]
    if len(legs) > 1:
        cosines = (legs[1:] * legs[:-1]).sum(axis=1) / (lengths[1:] * lengths[:-1])
        sharp = int(cosines.argmin())
        angle = math.degrees(math.acos(float(np.clip(cosines[sharp], -1, 1))))
        figures = {"sharpest_turn_rad": math.radians(angle)}
        findings.append(Finding("sharpest turn", f"{angle:.0f} deg", f"at {names[sharp + 1]}", figures=figures))
    return (*findings, *_buried(track))


def _buried(track: Track) -> Iterator[Finding]:
    """Start, points and balls that lie within an obstacle or a frame; openings may be free beside what stands in them."""
    route = {point.key: point for point in reversed(track.route) if plane_of(point.gate, ANY) is None}
    points = ((point.name.removesuffix(" of lap 1"), point.gate.position, point.gate.radius or 0.0) for point in reversed(route.values()))
    for name, position, radius in (("the start", track.start, 0.0), *points):
        for solid in solids_of(track, ANY):
            if float(solid.measure(np.array([position]))[0][0]) + radius < 0:
                yield Finding("inside an obstacle", name, f"within {solid.name}: no vehicle gets there", Level.WARNING)


def _heights(track: Track, heights: NDArray[np.float64]) -> Finding:
    """Heights, with a note where they look like those of a frame whose z points down."""
    buried = track.floor is None and bool(heights.max() <= 0 and heights.min() < 0)
    remark = "" if track.floor is None else f"floor at {track.floor:g} m"
    if buried:
        remark = "none above 0: z is up here; in NED files it is down (x, y, z there is x, -y, -z here)"
    figures = {"lowest_m": float(heights.min()), "highest_m": float(heights.max())}
    return Finding("height", f"{heights.min():.1f} to {heights.max():.1f} m", remark, note_if(buried), figures)


def _closest(lengths: NDArray[np.float64], names: list[str]) -> Finding:
    """The shortest leg."""
    near = int(lengths.argmin())
    length, remark = float(lengths[near]), f"{names[near]} and {names[near + 1]}"
    if length < NEAR:
        remark += "; coordinates are in metres, not in degrees"
    value = f"{length:.2f} m" if length >= NEAR else f"{length:.1g} m"
    return Finding("closest points", value, remark, note_if(length < 1), {"closest_points_m": length})

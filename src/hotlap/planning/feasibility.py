"""What a file means: the figures behind a track or a quadrotor; those of a race are in `race_feasibility` and `plan_feasibility`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hotlap.files.descriptions import Description
from hotlap.planning.finding import Finding, Level, note_if, warning_if
from hotlap.planning.race_feasibility import describe_race, lag
from hotlap.race.flight_performance import FASTEST, hover_share, max_tilt, rate_damping, roll_acceleration, top_speed
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.track import Track

__all__ = ["Finding", "Level", "describe", "describe_quadrotor", "describe_race", "describe_track"]

FAR = 300.0  # m, between two gates of no race: centimetres perhaps
NEAR = 0.05  # m, likewise: degrees perhaps


def describe(description: Description, top_speed: float | None = None) -> tuple[Finding, ...]:
    """What a description means, in the order in which one would ask; nothing is planned or flown.

    Args:
        description: a track, a quadrotor or a race.
        top_speed: [m/s] of the race's plan where there is one; else a rough estimate stands in.
    """
    if isinstance(description, Track):
        return describe_track(description)
    if isinstance(description, Quadrotor):
        return describe_quadrotor(description)
    return describe_race(description, top_speed)


def describe_track(track: Track) -> tuple[Finding, ...]:
    """Length, spacing and turns of a track."""
    points = np.vstack([track.start, track.waypoints])
    legs = np.diff(points, axis=0)
    lengths = np.linalg.norm(legs, axis=1)
    names = ["the start", *(point.name for point in track.route)]
    vast = bool(lengths.max() > FAR)
    straight = "in straight lines; gates are in metres" if vast else "in straight lines"
    findings = [
        Finding("gates", str(len(track.counted)), "and an end beyond the last one" if track.end is not None else "the last one is the end"),
        Finding("length", f"{lengths.sum():.0f} m", straight, note_if(vast)),
        _heights(track, points[:, 2]),
        _closest(lengths, names),
    ]
    if len(legs) > 1:
        cosines = (legs[1:] * legs[:-1]).sum(axis=1) / (lengths[1:] * lengths[:-1])
        sharp = int(cosines.argmin())
        angle = math.degrees(math.acos(float(np.clip(cosines[sharp], -1, 1))))
        findings.append(Finding("sharpest turn", f"{angle:.0f} deg", f"at {names[sharp + 1]}"))
    return tuple(findings)


def _heights(track: Track, heights: NDArray[np.float64]) -> Finding:
    """Heights, with a note where they look like those of a frame whose z points down."""
    buried = track.floor is None and bool(heights.max() <= 0 and heights.min() < 0)
    remark = "" if track.floor is None else f"floor at {track.floor:g} m"
    if buried:
        remark = "none above 0: z is up here; in NED files it is down (x, y, z there is x, -y, -z here)"
    return Finding("height", f"{heights.min():.1f} to {heights.max():.1f} m", remark, note_if(buried))


def _closest(lengths: NDArray[np.float64], names: list[str]) -> Finding:
    """The shortest leg."""
    near = int(lengths.argmin())
    length, remark = float(lengths[near]), f"{names[near]} and {names[near + 1]}"
    if length < NEAR:
        remark += "; coordinates are in metres, not in degrees"
    return Finding("closest points", f"{length:.2f} m" if length >= NEAR else f"{length:.1g} m", remark, note_if(length < 1))


def describe_quadrotor(quadrotor: Quadrotor) -> tuple[Finding, ...]:
    """Thrust, speed and agility of a quadrotor."""
    ratio, fastest = quadrotor.thrust_to_weight, top_speed(quadrotor)
    weak = "too little for racing" if ratio < 1.5 else ""
    dragless = not any((*quadrotor.drag, *quadrotor.body_drag, quadrotor.rotor_drag))
    unlimited = "no drag is given" if dragless else f"its drag does not hold it below {FASTEST:g} m/s"
    return (
        Finding("thrust-to-weight", f"{ratio:.2f}", weak, note_if(ratio < 1.5)),
        Finding("hover throttle", f"{hover_share(quadrotor):.0%}", "of the largest thrust"),
        Finding("largest tilt", f"{math.degrees(max_tilt(quadrotor)):.0f} deg", "that keeps its height"),
        Finding("top speed", f"{fastest:.1f} m/s", "in level flight") if math.isfinite(fastest) else Finding("top speed", "-", unlimited),
        Finding("roll acceleration", f"{roll_acceleration(quadrotor):.0f} rad/s^2", "with all four rotors"),
        Finding("rate loop", f"{quadrotor.rate_gain[0] / (2 * math.pi):.1f} Hz", f"roll; settles in {3 / quadrotor.rate_gain[0]:.2f} s"),
        _damping(quadrotor),
        *_inertia(quadrotor),
        lag(quadrotor),
        Finding("dead time", f"{quadrotor.delay * 1e3:g} ms", "from command to rotors"),
    )


def _damping(quadrotor: Quadrotor) -> Finding:
    """Whether the rate loop oscillates behind its motors."""
    damping = rate_damping(quadrotor)
    if not math.isfinite(damping):
        return Finding("rate loop damping", "-", "the motors follow at once (motor_time 0): it cannot oscillate")
    slow = "the motors are slow for this rate_gain: it will oscillate"
    remark = slow if damping < 0.5 else "of the loop behind the slower motor time"
    return Finding("rate loop damping", f"{damping:.2f}", remark, warning_if(damping < 0.5))


def _inertia(quadrotor: Quadrotor) -> list[Finding]:
    """Moments of inertia that no body has, as far as they may be measured ones."""
    if quadrotor.excess_inertia <= 1e-9:
        return []
    remark = "by which the largest moment exceeds the sum of the other two, as of no body: a measuring error is taken for granted"
    return [Finding("inertia", f"{quadrotor.excess_inertia:.1%}", remark, Level.NOTE)]

"""What a file means: the figures behind a track, a quadrotor or a race, and what to expect of them before anything flies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from hotlap.files.descriptions import Description
from hotlap.race.flight_performance import (
    FASTEST,
    hover_share,
    max_tilt,
    rate_damping,
    roll_acceleration,
    rough_top_speed,
    steady_share,
    top_speed,
)
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import GateRule, Race
from hotlap.race.track import Track

SPENT = 0.95  # share of the thrust beyond which nothing is left to correct with
EXHAUSTED = 0.97  # the same for the steady part alone
FAR = 300.0  # m, between two gates of no race: centimetres perhaps
SAME_MASS = 0.005  # share of the mass that no scale tells
DESCRIBING = {"name", "provenance", "rate_limit"}  # keys of a quadrotor that a controller need not know


class Level(StrEnum):
    """How much a finding matters."""

    FACT = "fact"
    NOTE = "note"
    WARNING = "warning"


@dataclass(frozen=True)
class Finding:
    """One line about a description.

    Attributes:
        label: what it is about.
        value: the figure with its unit.
        remark: what it means, or "".
        level: how much it matters.
    """

    label: str
    value: str
    remark: str = ""
    level: Level = Level.FACT


def describe(description: Description, top_speed: float | None = None) -> tuple[Finding, ...]:
    """What a description means, in the order in which one would ask.

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
    names = ["start", *(point.key for point in track.route)]
    near = int(lengths.argmin())
    heights = points[:, 2]
    vast = bool(lengths.max() > FAR)
    findings = [
        Finding("gates", str(len(track.counted)), "and an end beyond the last one" if track.end is not None else "the last one is the end"),
        Finding("length", f"{lengths.sum():.0f} m", "in straight lines; gates are in metres" if vast else "in straight lines", _note(vast)),
        Finding("height", f"{heights.min():.1f} to {heights.max():.1f} m", "" if track.floor is None else f"floor at {track.floor:g} m"),
        Finding("closest points", f"{lengths[near]:.2f} m", f"{names[near]} and {names[near + 1]}", _note(lengths[near] < 1)),
    ]
    if len(legs) > 1:
        cosines = (legs[1:] * legs[:-1]).sum(axis=1) / (lengths[1:] * lengths[:-1])
        sharp = int(cosines.argmin())
        angle = math.degrees(math.acos(float(np.clip(cosines[sharp], -1, 1))))
        findings.append(Finding("sharpest turn", f"{angle:.0f} deg", f"at {names[sharp + 1]}"))
    return tuple(findings)


def describe_quadrotor(quadrotor: Quadrotor) -> tuple[Finding, ...]:
    """Thrust, speed and agility of a quadrotor."""
    ratio, fastest, damping = quadrotor.thrust_to_weight, top_speed(quadrotor), rate_damping(quadrotor)
    weak = "too little for racing" if ratio < 1.5 else ""
    dragless = not any((*quadrotor.drag, *quadrotor.body_drag, quadrotor.rotor_drag))
    unlimited = "no drag is given" if dragless else f"its drag does not hold it below {FASTEST:g} m/s"
    return (
        Finding("thrust-to-weight", f"{ratio:.2f}", weak, _note(ratio < 1.5)),
        Finding("hover throttle", f"{hover_share(quadrotor):.0%}", "of the largest thrust"),
        Finding("largest tilt", f"{math.degrees(max_tilt(quadrotor)):.0f} deg", "that keeps its height"),
        Finding("top speed", f"{fastest:.1f} m/s", "in level flight") if math.isfinite(fastest) else Finding("top speed", "-", unlimited),
        Finding("roll acceleration", f"{roll_acceleration(quadrotor):.0f} rad/s^2", "with all four rotors"),
        Finding("rate loop", f"{quadrotor.rate_gain[0] / (2 * math.pi):.1f} Hz", f"roll; settles in {3 / quadrotor.rate_gain[0]:.2f} s"),
        Finding(
            "rate loop damping",
            f"{damping:.2f}",
            "the motors are slow for this rate_gain: it will oscillate" if damping < 0.5 else "of the loop behind the slower motor time",
            _warning(damping < 0.5),
        ),
        Finding("dead time", f"{quadrotor.delay * 1e3:g} ms", "from command to rotors"),
    )


def describe_race(race: Race, top_speed: float | None = None) -> tuple[Finding, ...]:
    """Margins of a race: what the plan leaves to the controller, and what the controller does not know."""
    speed = rough_top_speed(race) if top_speed is None else top_speed
    planned, vehicle = race.planning_model, race.vehicle
    about = "" if top_speed is not None else "about "
    return (
        Finding("track", race.track.name, f"{len(race.track.counted)} gates"),
        Finding("vehicle", vehicle.name, f"thrust-to-weight {vehicle.thrust_to_weight:.2f}"),
        Finding("plan", planned.name, f"thrust-to-weight {planned.thrust_to_weight:.2f}, top speed {about}{speed:.0f} m/s"),
        _thrust(race),
        *_hover(race),
        *_drag(race),
        _knowledge(race),
        _latency(race, speed),
        *_mass(race),
        *_limits(race),
        _difficulty(race, speed),
    )


def thrust_share(race: Race) -> float:
    """Share of the vehicle's largest thrust per mass that the plan uses [-]."""
    return race.planning_model.max_acceleration / race.vehicle.max_acceleration


def unknown_latency(race: Race) -> float:
    """Dead time [s] that the controller does not make up for."""
    return race.vehicle.delay - (race.control_model.delay if race.controller.predict else 0.0)


def missing_mass(race: Race) -> float:
    """Share of its weight by which the vehicle is heavier than the control model [-]; negative where it is lighter."""
    return race.vehicle.mass / race.control_model.mass - 1


def mistaken(race: Race) -> tuple[str, ...]:
    """Keys of the vehicle that its controller takes for something else."""
    names = (name for name in type(race.vehicle).model_fields if name not in DESCRIBING)
    return tuple(name for name in names if getattr(race.vehicle, name) != getattr(race.control_model, name))


def _thrust(race: Race) -> Finding:
    share = thrust_share(race)
    late = "no tuner will help" if race.judge.rule is GateRule.CLOCK else "the drone will fall behind its clock"
    remark = f"of the vehicle's thrust: {late}" if share > SPENT else "of the vehicle's thrust; the rest is left to correct with"
    return Finding("plan uses", f"{share:.0%}", remark, _warning(share > SPENT))


def _hover(race: Race) -> list[Finding]:
    """Whether the plan may use enough thrust to hover."""
    ratio = race.planning_model.thrust_to_weight
    if ratio > 1:
        return []
    return [Finding("plan cannot hover", f"{ratio:.2f}", "thrust-to-weight that it may use; raise planning.thrust_share", Level.WARNING)]


def _drag(race: Race) -> list[Finding]:
    """Whether the vehicle can keep up with its plan for long."""
    share = steady_share(race)
    if share is None:
        return []
    remark = "of the vehicle's thrust, along the longest leg at the plan's steady speed"
    beyond = share > EXHAUSTED
    return [Finding("steady flight takes", f"{share:.0%}", f"{remark}: beyond the vehicle" if beyond else remark, _warning(beyond))]


def _knowledge(race: Race) -> Finding:
    unknown = mistaken(race)
    return Finding("controller's model", race.control_model.name, f"differs in {', '.join(unknown)}" if unknown else "equals the vehicle")


def _latency(race: Race, speed: float) -> Finding:
    latency = unknown_latency(race)
    if abs(latency) < 1e-9:
        return Finding("unknown latency", "0 ms", "the controller knows its dead time")
    far = abs(latency) * speed
    remark = f"{far:.2f} m at top speed, where {race.judge.distance:g} m miss a gate: compensate first (model.delay), tune second"
    return Finding("unknown latency", f"{latency * 1e3:g} ms", remark, Level.NOTE)


def _mass(race: Race) -> list[Finding]:
    """A wrong mass is a lasting error: the controller has no integrator."""
    missing = missing_mass(race)
    if abs(missing) < SAME_MASS:
        return []
    remark = f"{'heavier' if missing > 0 else 'lighter'} than the control model: a lasting error; weigh it, set model.mass, tune then"
    return [Finding("unknown mass", f"{abs(missing):.1%}", remark, Level.NOTE)]


def _limits(race: Race) -> list[Finding]:
    """Limits of the controller that are tighter than the plan."""
    findings = []
    wanted, allowed = race.planning_model.max_acceleration, race.controller.thrust[1]
    if wanted > allowed:
        remark = f"the plan uses {wanted:.1f}; raise controller.thrust"
        findings.append(Finding("thrust limit binds", f"{allowed:g} m/s^2", remark, Level.WARNING))
    for axis, rate, limit in zip(("roll", "pitch", "yaw"), race.planning_model.rate_limit, race.controller.rates, strict=True):
        if rate > limit:
            remark = f"the plan uses up to {rate:g}; raise controller.rates"
            findings.append(Finding(f"{axis} rate limit binds", f"{limit:g} rad/s", remark, Level.WARNING))
    asked = race.planning.thrust_share * race.control_model.max_acceleration
    if race.planning.quadrotor is None and wanted < 0.999 * asked:
        remark = f"planning.thrust_share asks for {asked:.1f}; raise controller.thrust for a faster plan"
        findings.append(Finding("thrust limit caps the plan", f"{wanted:.1f} m/s^2", remark, Level.NOTE))
    return findings or [Finding("controller limits", "wide enough", "for the plan")]


def _difficulty(race: Race, speed: float) -> Finding:
    """A rule of thumb from the built-in races: thrust that is spent, metres flown blind, and weight that it does not know of."""
    missing = missing_mass(race)
    blind = abs(unknown_latency(race)) * speed / race.judge.distance
    share, steady = thrust_share(race), steady_share(race) or 0.0
    if race.planning_model.thrust_to_weight <= 1:
        word, remark = "no plan", "the vehicle is too weak for a share of its thrust to carry it"
    elif steady > EXHAUSTED or (share > SPENT and race.judge.rule is GateRule.CLOCK):
        word, remark = "beyond the vehicle", "expect partial completion, whatever the tuner"
    elif blind > 0.4 or share > 0.85 or missing > 0.07:
        word, remark = "hard", "the default weights are likely to miss gates"
    elif blind > 0.15 or share > 0.7 or missing > 0.045:
        word, remark = "moderate", "some weights will miss gates"
    else:
        word, remark = "easy", "most weights near the default will do"
    return Finding("expected difficulty", word, f"{remark} (a rule of thumb)")


def _note(condition: bool) -> Level:
    return Level.NOTE if condition else Level.FACT


def _warning(condition: bool) -> Level:
    return Level.WARNING if condition else Level.FACT

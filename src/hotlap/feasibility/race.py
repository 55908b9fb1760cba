"""What a race means before it is planned: what its plan may use, what that leaves to the controller, and what that does not know."""

from __future__ import annotations

import numpy as np

from hotlap.core.counts import count
from hotlap.feasibility.finding import Finding, Level, warning_if
from hotlap.feasibility.quadrotor import lag
from hotlap.race.flight_performance import command_lag, rough_top_speed, steady_share
from hotlap.race.gate import Gate
from hotlap.race.race import GateRule, PlanDynamics, Race

SPENT = 0.95  # share of the thrust beyond which nothing is left to correct with
EXHAUSTED = 0.97  # the same for the steady part alone
SAME_MASS = 0.005  # share of the mass that no scale tells
DESCRIBING = {"name", "provenance", "rate_limit", "radius"}  # keys of a quadrotor that a controller need not know


def describe_race(race: Race, top_speed: float | None = None, *, planned: bool = True) -> tuple[Finding, ...]:
    """Margins of a race: what the plan leaves to the controller, and what the controller does not know.

    Args:
        race: as it was read.
        top_speed: [m/s] of what is flown where that is known; else a rough estimate stands in.
        planned: whether a plan is flown; False: a reference is, which the settings of the planner do not concern.
    """
    speed = rough_top_speed(race) if top_speed is None else top_speed
    vehicle, gates, ratio = race.vehicle, len(race.track.counted), race.vehicle.thrust_to_weight
    return (
        Finding("track", race.track.name, count(gates, "gate"), figures={"gates": gates}),
        Finding("vehicle", vehicle.name, f"thrust-to-weight {ratio:.2f}", figures={"thrust_to_weight": ratio}),
        *(_plan(race, speed, about=top_speed is None) if planned else ()),
        Finding("judged by", race.judge.rule, _rule(race), figures={"judge_distance_m": race.judge.distance}),
        *_crowded(race),
        *(_loose(race) if planned else ()),
        _knowledge(race),
        _latency(race, speed),
        lag(vehicle),
        *_mass(race),
        *(_limits(race) if planned else ()),
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


def beyond(race: Race) -> str:
    """Why no weights can fly the plan of a race, as far as figures alone show it; "" where they do not."""
    if race.planning_model.thrust_to_weight <= 1:
        return "no plan"
    steady = (steady_share(race) or 0.0) > EXHAUSTED
    return "beyond the vehicle" if steady or (thrust_share(race) > SPENT and race.judge.rule is GateRule.CLOCK) else ""


def loose_judge(race: Race) -> str:
    """Why the plan may miss a gate by what the judge lets pass; "" where it cannot.

    The plan passes within `planning.tolerance` of points, and of the centre of gates that have an orientation alone.
    """
    distance, tolerance = race.judge.distance, race.planning.tolerance
    if distance > tolerance or not any(_by_distance(race, gate) for gate in race.track.counted):
        return ""
    return f"the plan may pass a gate at {tolerance:g} m, where {distance:g} m count: raise judge.distance or lower planning.tolerance"


def _by_distance(race: Race, gate: Gate) -> bool:
    """Whether the judge's distance decides about a gate, and not its own opening."""
    return race.judge.rule is not GateRule.OPENING or not gate.shaped


def _plan(race: Race, speed: float, *, about: bool) -> list[Finding]:
    """What the planner may use."""
    planned = race.planning_model
    top = f"top speed {'about ' if about else ''}{speed:.0f} m/s"
    figures = {"plan_thrust_to_weight": planned.thrust_to_weight, "plan_top_speed_m_per_s": speed}
    plan = Finding("plan", planned.name, f"thrust-to-weight {planned.thrust_to_weight:.2f}, {top}", figures=figures)
    return [plan, _thrust(race), *_hover(race), *_drag(race)]


def _rule(race: Race) -> str:
    """What counts as passing a gate, in words."""
    judge, gates = race.judge, race.track.counted
    if judge.rule is GateRule.CLOCK:
        return f"within {judge.distance:g} m of each gate at the reference's time"
    if judge.rule is not GateRule.OPENING:
        return f"within {judge.distance:g} m of each gate"
    words = {
        "through their openings with all of the vehicle": [gate for gate in gates if gate.shaped and gate.oriented],
        "within their radius": [gate for gate in gates if gate.shaped and not gate.oriented],
        f"within {judge.distance:g} m": [gate for gate in gates if not gate.shaped],
    }
    told = [f"{len(some)} {how}" for how, some in words.items() if some]
    return f"gates in their order: {', '.join(told)}"


def _crowded(race: Race) -> list[Finding]:
    """Gates that are closer to each other than what counts as passing them proves."""
    places = {gate.position: f"gate {k + 1}" for k, gate in reversed(list(enumerate(race.track.counted))) if _by_distance(race, gate)}
    if len(places) < 2:
        return []
    points, names = np.array(list(places)), list(places.values())
    gaps = np.linalg.norm(points[:, None] - points[None], axis=2)
    gaps[np.diag_indices(len(points))] = np.inf
    i, j = (int(k) for k in np.unravel_index(gaps.argmin(), gaps.shape))
    gap, distance = float(gaps[i, j]), race.judge.distance
    if distance <= gap / 2:
        return []
    first, second = sorted((names[i], names[j]), key=lambda name: int(name.split()[1]))
    remark = f"from {first} to {second}, where {distance:g} m count: too near to be told apart; lower judge.distance, or give openings"
    return [Finding("gates are close", f"{gap:.2f} m", remark, Level.WARNING, {"closest_gates_m": gap})]


def _loose(race: Race) -> list[Finding]:
    """Whether the plan itself may miss what counts."""
    reason, distance = loose_judge(race), race.judge.distance
    figures = {"judge_distance_m": distance, "plan_tolerance_m": race.planning.tolerance}
    return [Finding("judge.distance", f"{distance:g} m", reason, Level.WARNING, figures)] if reason else []


def _thrust(race: Race) -> Finding:
    share = thrust_share(race)
    late = "no tuner will help" if race.judge.rule is GateRule.CLOCK else "the drone will fall behind its clock"
    remark = f"of the vehicle's thrust: {late}" if share > SPENT else "of the vehicle's thrust; the rest is left to correct with"
    return Finding("plan uses", f"{share:.0%}", remark, warning_if(share > SPENT), {"plan_thrust_share": share})


def _hover(race: Race) -> list[Finding]:
    """Whether the plan may use enough thrust to hover."""
    ratio = race.planning_model.thrust_to_weight
    if ratio > 1:
        return []
    remark = "thrust-to-weight that it may use; raise planning.thrust_share"
    return [Finding("plan cannot hover", f"{ratio:.2f}", remark, Level.WARNING, {"plan_thrust_to_weight": ratio})]


def _drag(race: Race) -> list[Finding]:
    """Whether the vehicle can keep up with its plan for long."""
    share = steady_share(race)
    if share is None:
        return []
    remark = "of the vehicle's thrust, along the longest leg at the plan's steady speed"
    beyond, figures = share > EXHAUSTED, {"steady_thrust_share": share}
    remark = f"{remark}: beyond the vehicle" if beyond else remark
    return [Finding("steady flight takes", f"{share:.0%}", remark, warning_if(beyond), figures)]


def _knowledge(race: Race) -> Finding:
    unknown = mistaken(race)
    return Finding("controller's model", race.control_model.name, f"differs in {', '.join(unknown)}" if unknown else "equals the vehicle")


def _latency(race: Race, speed: float) -> Finding:
    latency = unknown_latency(race)
    further = race.prediction - race.vehicle.delay
    if abs(latency) < 1e-9 and further < 1e-9:
        return Finding("unknown latency", "0 ms", "the controller knows its dead time", figures={"unknown_latency_s": 0.0})
    if latency < 1e-9 and 0 < further <= command_lag(race.vehicle) + 1e-9:
        remark = f"the controller knows its dead time, and predicts {further * 1e3:.0f} ms further, over part of the lag"
        return Finding("unknown latency", "0 ms", remark, figures={"unknown_latency_s": 0.0})
    far = abs(latency) * speed
    remark = f"{far:.2f} m at top speed{_room(race)}: compensate first (model.delay), tune second"
    figures = {"unknown_latency_s": latency, "unknown_distance_m": far}
    return Finding("unknown latency", f"{latency * 1e3:g} ms", remark, Level.NOTE, figures)


def _room(race: Race) -> str:
    """How far from a gate's middle a flight may be, where one distance says it for all."""
    if all(_by_distance(race, gate) for gate in race.track.counted):
        return f", where {race.judge.distance:g} m miss a gate"
    return ""


def _mass(race: Race) -> list[Finding]:
    """A wrong mass is a lasting error: the controller has no integrator."""
    missing = missing_mass(race)
    if abs(missing) < SAME_MASS:
        return []
    remark = f"{'heavier' if missing > 0 else 'lighter'} than the control model: a lasting error; weigh it, set model.mass, tune then"
    return [Finding("unknown mass", f"{abs(missing):.1%}", remark, Level.NOTE, {"unknown_mass": missing})]


def _limits(race: Race) -> list[Finding]:
    """Limits of the controller that are tighter than the plan."""
    findings = []
    wanted, allowed = race.planning_model.max_acceleration, race.controller.thrust[1]
    if wanted > allowed:
        remark = f"the plan uses {wanted:.1f}; raise controller.thrust"
        figures = {"thrust_limit_m_per_s2": allowed, "plan_thrust_m_per_s2": wanted}
        findings.append(Finding("thrust limit binds", f"{allowed:g} m/s^2", remark, Level.WARNING, figures))
    free = race.planning.dynamics is PlanDynamics.IDEAL  # else plans keep within controller.rates
    for axis, rate, limit in zip(("roll", "pitch", "yaw"), race.planning_model.rate_limit, race.controller.rates, strict=True):
        if free and rate > limit:
            remark = f"the plan uses up to {rate:g}; raise controller.rates"
            figures = {f"{axis}_rate_limit_rad_per_s": limit, f"plan_{axis}_rate_rad_per_s": rate}
            findings.append(Finding(f"{axis} rate limit binds", f"{limit:g} rad/s", remark, Level.WARNING, figures))
    asked = race.thrust_share * race.control_model.max_acceleration
    if race.planning.quadrotor is None and wanted < 0.999 * asked:
        remark = f"planning.thrust_share asks for {asked:.1f}, controller.thrust allows less"
        findings.append(Finding("thrust limit caps the plan", f"{wanted:.1f} m/s^2", remark, figures={"plan_thrust_m_per_s2": wanted}))
    return findings or [Finding("controller limits", "wide enough", "for the plan")]

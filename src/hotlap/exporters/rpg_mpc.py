"""mpc.yaml for rpg_mpc, with a list of weights for each segment, as the released code of AutoTune reads it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hotlap.exporters.flown_with import not_reproduced, plan_words
from hotlap.exporters.tuned import ExportedParameters, need_weights, read_tuned
from hotlap.race.controller_kind import kind_and_solver
from hotlap.race.race import SegmentSwitch
from hotlap.study.study import Study
from hotlap.system.text_files import replace

SUFFIXES = {"Q_pos_xy": "pos_xy", "Q_pos_z": "pos_z", "Q_attitude": "attitude", "Q_velocity": "velocity", "horizon": "horizon"}
LEAST_THRUST = 0.01  # m/s^2: rpg_mpc refuses limits that are not positive
RPG_NODES, RPG_SPACING = 20, 0.1  # of its generated solver: nodes, and s between them
SAID = {
    SegmentSwitch.TIME: "when the reference enters it, for the whole horizon",
    SegmentSwitch.NODE: "node by node, when the reference at the node is in it; the horizon itself when the reference enters it",
    SegmentSwitch.DISTANCE: "when the drone comes within {distance:g} m of the point at which the reference enters it",
}


def write(study: Study, path: Path) -> tuple[Path, ...]:
    """Write the file.

    Raises:
        InputError: what was tuned is no MPC.
    """
    tuned = read_tuned(study)
    need_weights(tuned, "rpg_mpc")
    replace(path, "\n".join([*_head(tuned), *_defaults(tuned), *_fixed(tuned), *_bounds(tuned), *_lists(tuned)]) + "\n")
    return (path,)


def number(value: float) -> str:
    """A number that YAML 1.1 takes for a float, bit for bit: `1e-05` would be a string."""
    text = repr(float(value))
    mantissa, exponent, power = text.partition("e")
    return text if not exponent or "." in mantissa else f"{mantissa}.0e{power}"


def _row(key: str, values: Sequence[float]) -> str:
    return f"{key}: [{', '.join(map(number, values))}]"


def _head(tuned: ExportedParameters) -> list[str]:
    """What the controller must be like for these numbers to mean what they meant here."""
    settings, race = tuned.controller, tuned.scenario.race
    segment_switch = SAID[settings.segment_switch].format(distance=settings.segment_switch_distance)
    ahead = race.prediction
    kind, solver = kind_and_solver(settings.law)
    plan, missing = plan_words(tuned), not_reproduced(tuned.scenario, own_model=False)
    inputs = "those of the reference" if settings.feed_forward else "hover"
    return [
        f"# Tuned by hotlap for {race.name}: parameters of rpg_mpc, a list entry for each segment.",
        f"# A segment takes over from the one before {segment_switch}.",
        f"# Tuned with {settings.nodes} nodes; reference inputs: {inputs}; thrust is per mass. The cost is a plain sum, as in ACADO.",
        f"# Tuned was {kind}, solved by {solver}, with a control step every {settings.period * 1e3:g} ms.",
        *([f"# Planned with {plan}."] if plan else []),
        f"# Before each control step the state is predicted by {ahead * 1e3:g} ms.",
        "# rpg_mpc as published reads neither Q_horizon nor the lists: it flies the first segment's weights on the horizon of its",
        f"# generated solver, {RPG_NODES} nodes {RPG_SPACING:g} s apart. The lists are read by the controller of mh_autotune.",
        *(["# The tuned controller had, and rpg_mpc has not:"] if missing else []),
        *(f"#   - {sentence}" for sentence in missing),
    ]


def _defaults(tuned: ExportedParameters) -> list[str]:
    """The first segment's, for a controller without lists."""
    first = dict(zip(tuned.scenario.space.names, tuned.values[tuned.scenario.segments.pieces[0].segment], strict=True))
    return [
        "",
        "# State costs of the first segment",
        *(f"Q_{SUFFIXES[name]}: {number(first[name])}" for name in SUFFIXES),
        "Q_perception: 0.0",
    ]


def _fixed(tuned: ExportedParameters) -> list[str]:
    """What was not tuned."""
    settings = tuned.controller
    roll, pitch, yaw = settings.rates
    least, most = tuned.scenario.planned_thrust
    keys = {
        "R_thrust": settings.input_weights[0],
        "R_pitchroll": settings.input_weights[1],
        "R_yaw": settings.input_weights[2],
        "state_cost_exponential": 0.0,
        "input_cost_exponential": 0.0,
        "max_bodyrate_xy": min(roll, pitch),
        "max_bodyrate_z": yaw,
        "min_thrust": max(least, LEAST_THRUST),
        "max_thrust": most,
    }
    camera = ["p_B_C: [0.0, 0.0, 0.0]", "q_B_C: [1.0, 0.0, 0.0, 0.0]", "print_info: false"]
    return ["", "# Input costs and limits: m/s^2, rad/s", *(f"{key}: {number(value)}" for key, value in keys.items()), *camera]


def _bounds(tuned: ExportedParameters) -> list[str]:
    """Within which it was tuned."""
    space = tuned.scenario.space
    rows = [_row(f"B_{SUFFIXES[name]}", (low, high)) for name, low, high in zip(space.names, space.low, space.high, strict=True)]
    return ["", "# Bounds", *rows]


def _lists(tuned: ExportedParameters) -> list[str]:
    """An entry for each piece of the reference, in the order flown; pieces that share a segment repeat its values."""
    pieces, names = tuned.scenario.segments.pieces, tuned.scenario.space.names
    said = [f"#   {i}: {piece.kind}, {piece.start:.2f} to {piece.end:.2f} s" for i, piece in enumerate(pieces)]
    rows = [_row(f"L_{SUFFIXES[name]}", [tuned.values[piece.segment, k] for piece in pieces]) for k, name in enumerate(names)]
    covered = f"# Horizon in units of {tuned.controller.horizon_unit:g} s: 4 covers {4 * tuned.controller.horizon_unit:g} s."
    return ["", "# Segments in the order flown", *said, covered, *rows]

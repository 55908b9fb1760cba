"""Weights for acados: W and W_e of every segment as JSON, and a piece of Python that sets them stage by stage."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path
from typing import Any

from hotlap.core.errors import InputError
from hotlap.exporters.flown_with import flown_with, not_reproduced
from hotlap.exporters.tuned import ExportedParameters, need_weights, read_tuned
from hotlap.race.race import ReferenceTime
from hotlap.study.study import Study
from hotlap.system.text_files import replace

STATE = ("p_x", "p_y", "p_z", "q_w", "q_x", "q_y", "q_z", "v_x", "v_y", "v_z")
INPUT = ("thrust_per_mass", "w_x", "w_y", "w_z")
CODE = "acados_weights.py"  # of this folder, written out as it is


def write(study: Study, path: Path) -> tuple[Path, ...]:
    """Write the weights, and beside them the code that sets them.

    Raises:
        InputError: what was tuned is no MPC, or the code would overwrite the weights.
    """
    if path.suffix == ".py":
        raise InputError(str(path), "", "is the name of the weights' JSON; the Python file is written beside it")
    tuned = read_tuned(study)
    need_weights(tuned, "acados")
    replace(path, json.dumps(weights(tuned), indent=2, allow_nan=False) + "\n")
    code = path.with_suffix(".py")
    replace(code, (files("hotlap.exporters") / CODE).read_text(encoding="utf-8"))
    return path, code


def weights(tuned: ExportedParameters) -> dict[str, Any]:
    """Everything about the cost that is flown, as plain values; weights are diagonals."""
    settings, race, reference = tuned.controller, tuned.scenario.race, tuned.scenario.reference
    lead = race.prediction if settings.reference_time is ReferenceTime.EXECUTION else 0.0
    pieces = tuned.scenario.segments.pieces
    least, most = tuned.scenario.planned_thrust
    points = reference.position_at(tuned.scenario.segments.starts).tolist()
    return {
        "race": race.name,
        "model": settings.kind,
        "nodes": settings.nodes,
        "state": STATE,
        "input": INPUT,
        "low": [least, *(-rate for rate in settings.rates)],
        "high": [most, *settings.rates],
        "input_reference": "reference" if settings.feed_forward else "hover",
        "control_period": settings.period,
        "prediction": race.prediction,
        "lead": lead,
        "segment_switch": settings.segment_switch,
        "distance": settings.segment_switch_distance,
        "period": reference.period,
        "segments": _segments(tuned),
        "pieces": [
            {"segment": piece.segment, "class": piece.kind, "start": piece.start, "end": piece.end, "point": point}
            for piece, point in zip(pieces, points, strict=True)
        ],
        "flown_with": flown_with(tuned.scenario),
        "not_reproduced": not_reproduced(tuned.scenario, own_model=True),
        "provenance": dict(tuned.saved.provenance),
    }


def _segments(tuned: ExportedParameters) -> list[dict[str, Any]]:
    """Horizon [s], node spacing [s] and diagonals of each segment; W_0 is that of every other stage."""
    thrust, tilt, yaw = tuned.controller.input_weights
    rows = []
    for values, spacing in zip(tuned.values.tolist(), tuned.spacings, strict=True):
        xy, z, attitude, velocity = values[:4]
        end = [xy, xy, z, *[attitude] * 4, *[velocity] * 3]
        whole = [*end, thrust, tilt, tilt, yaw]
        rows.append({"horizon": spacing * tuned.controller.nodes, "spacing": spacing, "W_0": whole, "W": whole, "W_e": end})
    return rows

"""What stands on a track, as plain JSON for the page: openings as lines in space, obstacles, box and ceiling."""

from __future__ import annotations

from typing import Any

import numpy as np

from hotlap.race.obstacles import Box
from hotlap.reference.scenario import Scenario
from hotlap.report.page.packing import pack
from hotlap.report.projection import box_of
from hotlap.report.structures import GateShape, structures_of


def dump_structures(scenario: Scenario) -> dict[str, Any]:
    """Gates that are more than points, points that do not count, obstacles, box and ceiling, and what they and the plan take up."""
    track, reference = scenario.race.track, scenario.reference
    known = structures_of(track, scenario.race.judge.distance)
    path = np.vstack([reference.position[: reference.planned_rows], track.gate_positions])
    bounds = None if known.plain else np.stack(known.surround(*box_of(path))).tolist()
    flown = [[i for i, gate in enumerate(known.gates) if gate.gate == shape.gate] for shape in known.distinct]
    return {
        "gate_shapes": [_gate(*both) for both in zip(known.distinct, flown, strict=True) if not both[0].bare],
        "points": pack(np.array([shape.centre for shape in known.points]).reshape(-1, 3)),
        "poles": [pole.model_dump() for pole in track.poles],
        "spheres": [sphere.model_dump() for sphere in track.spheres],
        "boxes": [_box(box) for box in track.boxes],
        "box": None if track.box is None else _box(track.box),
        "ceiling": track.ceiling,
        "bounds": bounds,
    }


def _gate(shape: GateShape, gates: list[int]) -> dict[str, Any]:
    """A gate with its lines relative to its centre, and which of those that have to be passed it is."""
    lines = {name: [pack(line - shape.centre) for line in getattr(shape, name)] for name in ("rims", "frames", "walls")}
    bottom, top = (shape.bounds[:, 2] - shape.centre[2]).tolist()
    return {
        "gates": gates,
        "centre": list(shape.gate.position),
        **lines,
        "normal": None if shape.normal is None else shape.normal.tolist(),
        "depth": 0.0 if shape.plane is None else shape.plane.depth,
        "reach": shape.reach,
        "bottom": bottom,
        "top": top,
    }


def _box(box: Box) -> dict[str, Any]:
    return {"low": list(box.low), "high": list(box.high)}

"""The plan cache: references on disk, found by the content of their problem and the code that planned them."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import platform
from importlib.metadata import version
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from hotlap.planning.problem import Problem
from hotlap.race.track import Track
from hotlap.reference.reference import Reference
from hotlap.system import sealed
from hotlap.system.disk_cache import digest_sources, folder

ARRAYS = ("position", "attitude", "velocity", "rates", "thrust", "rotor_thrusts", "gate_times")
SCALARS = ("duration", "cpu_time", "period")
SOURCES = (
    "hotlap.planning",
    "hotlap.dynamics",
    "hotlap.race.airframe",
    "hotlap.race.quadrotor",
    "hotlap.race.rate_loop",
    "hotlap.race.rotors",
    "hotlap.race.flight_performance",
    "hotlap.race.gate",
    "hotlap.race.gate_plane",
    "hotlap.race.obstacles",
    "hotlap.race.track",
    "hotlap.race.bodies",
    "hotlap.race.solids",
    "hotlap.reference.attitude",
    "hotlap.reference.encounters",
    "hotlap.reference.reference",
    "hotlap.reference.run_out",
)
MAKE_NO_PLANS = ("hotlap.planning.preparation",)
# What a plan uses of a quadrotor, and what one with full dynamics uses besides.
OF_QUADROTOR = {"mass", "inertia", "arm", "layout", "rotors", "rotor_thrust", "torque_ratio", "rate_limit", "gravity"}
OF_FULL = {"motor_time", "drag", "rotor_drag", "body_drag", "rate_gain", "torque_damping", "rate_loop"}


def key(problem: Problem) -> str:
    """Thirty-two hexadecimal digits that change whenever the plan could."""
    description = {field.name: getattr(problem, field.name) for field in dataclasses.fields(problem) if field.name != "track"}
    if not problem.full:
        del description["dynamics"], description["command_rates"]
    used = OF_QUADROTOR | OF_FULL if problem.full else OF_QUADROTOR
    description["quadrotor"] = problem.quadrotor.model_dump(mode="json", include=used)
    description["ramp"] = problem.ramp and problem.ramp.model_dump(mode="json")
    code = digest_sources(*SOURCES, without=MAKE_NO_PLANS)
    versions = [code, version("casadi"), version("numpy"), platform.machine()]
    text = json.dumps([description, versions], sort_keys=True, default=_plain)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _plain(value: Any) -> Any:
    """What JSON cannot say by itself: arrays, and data that consist of fields."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Track):
        return value.model_dump(mode="json", exclude={"name", "provenance"})
    return {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}


def load(key: str) -> Reference | None:
    """The plan of a key; None if it is not there or cannot be used."""
    path = _path(key)
    content = sealed.read(path)
    if content is None:
        return None
    try:
        with np.load(BytesIO(content), allow_pickle=False) as stored:
            fields: dict[str, Any] = {name: np.asarray(stored[name], dtype=np.float64) for name in ARRAYS}
            fields.update({name: float(stored[name]) for name in SCALARS})
        reference = Reference(**fields)
        if _is_sound(reference):
            return reference
    except Exception:  # noqa: BLE001, S110  what is no plan may fail in any way
        pass
    sealed.reject(path, "is no plan")
    return None


def save(key: str, reference: Reference) -> None:
    """Keep a plan, whole or not at all; a cache that cannot be written is no error."""
    content = BytesIO()
    fields: dict[str, Any] = {name: np.asarray(getattr(reference, name)) for name in (*ARRAYS, *SCALARS)}
    np.savez(content, **fields)
    sealed.write(_path(key), content.getvalue())


def _is_sound(reference: Reference) -> bool:
    """Whether a plan has the shapes and the finite numbers of one; what rotors give is not known in the run-out."""
    rows, times = len(reference.position), reference.gate_times
    shapes = {name: getattr(reference, name).shape for name in ARRAYS}
    wanted = {"position": (rows, 3), "attitude": (rows, 4), "velocity": (rows, 3), "rates": (rows, 3), "thrust": (rows,)}
    wanted |= {"rotor_thrusts": (rows, *shapes["rotor_thrusts"][1:2]), "gate_times": (times.size,)}
    if shapes != wanted or not times.size or not reference.period > 0 or not reference.cpu_time >= 0:
        return False
    finite = all(np.isfinite(values).all() for values in (reference.table, times, reference.duration, reference.cpu_time))
    return finite and 0 < reference.planned_rows <= rows and bool((np.diff(times, prepend=0.0) >= 0).all())


def _path(key: str) -> Path:
    return folder("plans") / f"{key}.npz"

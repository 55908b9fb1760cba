"""A flight as the columns of a file, to be changed and read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.testing import assert_allclose

from hotlap.reference.attitude import thrust_axis
from hotlap.reference.reference import Reference
from planning import small

Columns = dict[str, np.ndarray]

RACE = small.RACES["drag"]
P, Q, V, W = ("p_x", "p_y", "p_z"), ("q_w", "q_x", "q_y", "q_z"), ("v_x", "v_y", "v_z"), ("w_x", "w_y", "w_z")
U = ("u_1", "u_2", "u_3", "u_4")


def write(path: Path, columns: Columns, *, separator: str = ",", header: bool = True) -> Path:
    """Columns as a file."""
    lines = [separator.join(columns)] if header else []
    lines += [separator.join(map(repr, row)) for row in np.column_stack(list(columns.values())).tolist()]
    path.write_text("\n".join(lines) + "\n")
    return path


def some(whole: Columns, *groups: tuple[str, ...]) -> Columns:
    """Time, position and some of the other columns."""
    return {name: whole[name] for name in ("t", *P, *(name for group in groups for name in group))}


def changed(whole: Columns, names: tuple[str, ...], values: np.ndarray) -> Columns:
    """The columns with some of them replaced."""
    return {**whole, **dict(zip(names, values.T, strict=True))}


def stack(whole: Columns, names: tuple[str, ...]) -> np.ndarray:
    return np.column_stack([whole[name] for name in names])


def tilt(found: Reference, expected: Reference) -> np.ndarray:
    """Angles between the thrust axes of planned rows [deg]."""
    rows = expected.planned_rows
    cosines = (thrust_axis(found.attitude[:rows]) * thrust_axis(expected.attitude[:rows])).sum(axis=1)
    return np.degrees(np.arccos(np.clip(cosines, -1, 1)))


def assert_same_flight(found: Reference, expected: Reference, *, rates: float = 0.05, thrust: float = 0.1) -> None:
    """In the middle of the rows: where thrusts jump, differences cannot tell on which side of a row."""
    rows = expected.planned_rows
    assert_allclose(found.position[:rows], expected.position[:rows], atol=1e-6)
    assert np.median(tilt(found, expected)) < 0.1
    assert np.quantile(tilt(found, expected), 0.95) < 1.0
    turned = np.abs((found.attitude[:rows] * expected.attitude[:rows]).sum(axis=1))
    assert np.degrees(2 * np.arccos(min(np.median(turned), 1.0))) < 1.0
    assert np.median(np.abs(found.rates[:rows] - expected.rates[:rows])) < rates
    assert np.median(np.abs(found.thrust[:rows] - expected.thrust[:rows])) < thrust
    assert_allclose(found.gate_times, expected.gate_times, atol=0.02)

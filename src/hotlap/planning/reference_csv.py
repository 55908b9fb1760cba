"""References as CSV, the field's own format (rpg_time_optimal, AutoTune, agilicious, TOGT), in and out.

    t, p_x, p_y, p_z, q_w, q_x, q_y, q_z, v_x, v_y, v_z, w_x, w_y, w_z, u_1, u_2, u_3, u_4

Columns are found by name; an index in front and whatever stands behind is ignored. Conventions are those of `quadrotor.py`;
u_1 to u_4 are rotor thrusts [N], held from a row to the next. Rows need not be evenly spaced. Time and position are needed; what is
missing of the rest follows from them (`flatness`), and what is said of it is checked (`reference_checks`).

Thrust per mass is what a controller feeds forward, so it must fit the motion of the file, whose drone may have had another
mass than the race's planning model. Mass and drag are therefore fitted to the file's accelerations. Where the mass is not
the planning model's, thrusts are scaled from one to the other; where no mass fits, thrust follows from the accelerations.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hotlap.planning import flatness
from hotlap.planning.attitude import product, thrust_axis
from hotlap.planning.reference_checks import (
    axis_misfit,
    check_angles,
    check_axes,
    check_columns,
    check_times,
    drag_of,
    foreign_acceleration,
)
from hotlap.planning.reference_columns import GROUPS, WHOLE
from hotlap.planning.reference_frames import between, in_track_frame
from hotlap.planning.reference_table import (
    ACCELERATION,
    ATTITUDE,
    POSITION,
    RATES,
    THRUSTS,
    TIME,
    VELOCITY,
    YAW,
    Table,
    read_table,
    without_repeated,
)
from hotlap.planning.run_out import extend
from hotlap.planning.thrust_vectors import planned_thrust
from hotlap.race.race import PlanDynamics, Race
from hotlap.reference.reference import PERIOD, Reference, row_times
from hotlap.system.text_files import replace

Floats = NDArray[np.float64]

COLUMNS = tuple(name for group in WHOLE for name in GROUPS[group])
SAME_MASS = 0.01  # relative difference up to which a fitted mass is taken for the planning model's
SAME_DRAG = 0.01  # 1/s, likewise
WORST_FIT = 0.05  # of the median acceleration: what the fit may leave unexplained in half of the rows


@dataclass(frozen=True)
class ReadReference:
    """A reference from a file.

    Attributes:
        reference: every 10 ms, with its gate times and a run-out.
        notes: what was assumed about the file, one line each, with its name.
    """

    reference: Reference
    notes: tuple[str, ...]


def load_reference(path: str | Path, race: Race) -> Reference:
    """A reference from a CSV file, every 10 ms, with its gate times and a run-out.

    Time begins with the first row. The track's gates must be passed in order, as the race's judge demands.

    Args:
        path: the file.
        race: its track, vehicle, planning model and judge count.

    Raises:
        InputError: with the file, the line and column or the gate, and the reason.
    """
    return read_reference(path, race).reference


def read_reference(path: str | Path, race: Race) -> ReadReference:
    """The same, with what was assumed about the file.

    Args:
        path: the file.
        race: its track, vehicle, planning model and judge count.

    Raises:
        InputError: with the file, the line and column or the gate, and the reason.
    """
    table = without_repeated(read_table(Path(path)))
    check_times(table)
    table = _with_velocities(check_columns(_without_orphans(table)))
    table, gate_times = in_track_frame(table, race)
    table, reference = _complete(table, race, gate_times)
    return ReadReference(reference, tuple(f"{path}: {note}" for note in table.notes))


def save_reference(path: str | Path, reference: Reference) -> None:
    """Write the planned rows of a reference, and a last row at its duration; reading them gives the same rows bit for bit.

    Gate times are not in the file: reading finds them anew, as closest approaches.

    Raises:
        InputError: when the file cannot be written.
    """
    rows = reference.planned_rows
    columns = (reference.position, reference.attitude, reference.velocity, reference.rates, reference.rotor_thrusts)
    table = np.hstack([reference.times[:rows, None], *(column[:rows] for column in columns)])
    rest = reference.duration - table[-1, TIME]
    if rest > 1e-9:
        table = np.vstack([table, _continue(table, rest)])
    text = "".join(",".join(map(repr, row)) + "\n" for row in table.tolist())
    replace(path, ",".join(COLUMNS) + "\n" + text)


def _continue(table: Floats, rest: float) -> Floats:
    """The row that follows the last one after a rest of less than a period [s]."""
    row = table[-1].copy()
    acceleration = (table[-1, VELOCITY] - table[-2, VELOCITY]) / (table[-1, TIME] - table[-2, TIME])
    attitude = product(row[ATTITUDE], np.append(1.0, rest / 2 * row[RATES]))
    row[TIME] += rest
    row[POSITION] += rest * row[VELOCITY] + rest**2 / 2 * acceleration
    row[VELOCITY] += rest * acceleration
    row[ATTITUDE] = attitude / np.linalg.norm(attitude)
    return row


def _without_orphans(table: Table) -> Table:
    """The table with attitudes where it has their angles, and without what means nothing where there are no attitudes."""
    if table.has("attitude"):
        return table
    check_angles(table)
    if table.has("angles"):
        return table.with_attitudes(flatness.attitudes_of_angles(table.angles())).noted("attitudes are those of roll, pitch and yaw")
    for group in ("rates", "thrusts"):
        if table.has(group):
            table = table.without(group, f"{', '.join(GROUPS[group])} are left out: without attitudes they say nothing")
    return table


def _with_velocities(table: Table) -> Table:
    """The table with velocities."""
    if table.has("velocity"):
        return table
    values = table.values.copy()
    values[:, VELOCITY] = np.gradient(values[:, POSITION], values[:, TIME], axis=0)
    return table.with_values(values).noted("velocities follow from the positions")


def _complete(table: Table, race: Race, gate_times: Floats) -> tuple[Table, Reference]:
    """Resampled, with what follows from the rest and a run-out."""
    times = table.values[:, TIME] - table.values[0, TIME]
    values = _resample(times, table.values, row_times(float(times[-1])))
    fitted = _fit(table, race) if table.has("attitude") and table.has("thrusts") else None
    if fitted is not None and table.has("rates") and table.has("velocity"):
        mass, drag = fitted
        thrusts = np.maximum(values[:, THRUSTS], 0.0) * (race.planning_model.mass / mass)
        thrust = thrusts.sum(axis=1) / race.planning_model.mass
    else:
        table, values, thrust, drag = _derive(table, race, values, fitted)
        thrusts = flatness.rotor_thrusts(race.planning_model, thrust, values[:, RATES], PERIOD)
    reference = Reference(
        position=values[:, POSITION],
        attitude=values[:, ATTITUDE],
        velocity=values[:, VELOCITY],
        rates=values[:, RATES],
        thrust=thrust,
        rotor_thrusts=thrusts,
        gate_times=gate_times,
        duration=float(times[-1]),
    )
    return table, extend(reference, race.planning_model.gravity, drag)


def _derive(table: Table, race: Race, values: Floats, fitted: tuple[float, float] | None) -> tuple[Table, Floats, Floats, float]:
    """What follows from the rest: the table with notes, rows every 10 ms, thrust per mass and the drag [1/s] that goes with it."""
    values, gravity = values.copy(), race.planning_model.gravity
    if table.has("velocity"):
        (acceleration,) = flatness.slopes(values[:, VELOCITY], PERIOD)
    else:
        values[:, VELOCITY], acceleration = flatness.slopes(values[:, POSITION], PERIOD, times=2)
    foreign = foreign_acceleration(table) if table.has("acceleration") else ""
    table = table.without("acceleration", foreign) if foreign else table
    if table.has("acceleration"):
        acceleration = values[:, ACCELERATION]
    velocity, weight = values[:, VELOCITY], np.array([0.0, 0.0, gravity])
    if table.has("attitude"):
        attitude = values[:, ATTITUDE]
        drag = drag_of(attitude, velocity, acceleration + weight)
        known, fitted_vectors = planned_thrust(race, velocity, acceleration, attitude), acceleration + weight + drag * velocity
        vectors = min(known, fitted_vectors, key=lambda vectors: axis_misfit(attitude, vectors))
        check_axes(table.source, attitude, vectors)
    else:
        drag, vectors = race.planning_drag, planned_thrust(race, velocity, acceleration)
        table, values[:, ATTITUDE] = _attitudes(table, race, vectors, values[:, YAW])
    if not table.has("rates"):
        values[:, RATES] = flatness.rates_of(values[:, ATTITUDE], PERIOD)
        table = table.noted("body rates follow from the attitudes")
    if fitted is not None:
        mass, drag = fitted
        return table, values, np.maximum(values[:, THRUSTS], 0.0).sum(axis=1) / mass, drag
    unfit = "u_1 to u_4 do not explain the accelerations and are left out; " if table.has("thrusts") else ""
    table = table.noted(f"{unfit}thrusts follow from the accelerations")
    return table, values, flatness.along_axis(vectors, values[:, ATTITUDE]), drag


def _attitudes(table: Table, race: Race, vectors: Floats, yaw: Floats) -> tuple[Table, Floats]:
    """Attitudes along thrust vectors, with the yaw of the file where it has one."""
    source = "attitudes follow from the accelerations, gravity and the drag that the race plans with"
    if table.has("yaw"):
        return table.noted(f"{source}, and from the yaw"), flatness.attitudes_with_yaw(vectors, yaw)
    start = np.array(race.track.attitude)
    return table.noted(f"{source}; no yaw is given, so that the drone never turns about its own z axis"), flatness.attitudes_along(
        vectors, start
    )


def _fit(table: Table, race: Race) -> tuple[float, float] | None:
    """Mass [kg] and linear drag [1/s] of the drone that the file was made for; None where none explains the file's thrusts.

    Least squares over all rows of dv/dt + g = z_body sum(u) / m - d v; gravity is the planning model's. Where the race plans with all
    drags of its vehicle, these are tried first.
    """
    values, model = table.values, race.planning_model
    accelerations = np.diff(values[:, VELOCITY], axis=0) / np.diff(values[:, TIME])[:, None] + np.array([0, 0, model.gravity])
    axes, velocity = thrust_axis(values[:, ATTITUDE]), values[:, VELOCITY]
    pushes = (axes[1:] + axes[:-1]) / 2 * values[:-1, THRUSTS].sum(axis=1)[:, None]
    if race.planning.dynamics is PlanDynamics.FULL:
        weight, middle = np.array([0.0, 0.0, model.gravity]), (velocity[1:] + velocity[:-1]) / 2
        if _explained(planned_thrust(race, middle, accelerations - weight, values[:-1, ATTITUDE]), pushes / model.mass):
            return model.mass, race.planning_drag
    columns = np.stack([pushes.ravel(), -(velocity[1:] + velocity[:-1]).ravel() / 2], axis=1)
    inverse_mass, drag = np.linalg.lstsq(columns, accelerations.ravel(), rcond=None)[0]
    if not (inverse_mass > 0 and _explained(accelerations, (columns @ [inverse_mass, drag]).reshape(-1, 3))):
        return None
    same_mass, same_drag = abs(inverse_mass * model.mass - 1) < SAME_MASS, abs(drag - race.planning_drag) < SAME_DRAG
    return model.mass if same_mass else float(1 / inverse_mass), race.planning_drag if same_drag else max(float(drag), 0.0)


def _explained(accelerations: Floats, found: Floats) -> bool:
    """Whether half of the rows are explained well enough."""
    misfits = np.linalg.norm(accelerations - found, axis=1)
    return bool(np.median(misfits) < WORST_FIT * np.median(np.linalg.norm(accelerations, axis=1)))


def _resample(times: Floats, values: Floats, at: Floats) -> Floats:
    """Rows at other times: positions by cubics with the right velocities, thrusts held, the rest linearly."""
    rows = np.clip(np.searchsorted(times, at + 1e-9, side="right") - 1, 0, len(times) - 2)
    steps = (times[rows + 1] - times[rows])[:, None]
    share = np.clip((at - times[rows])[:, None] / steps, 0.0, 1.0)
    before, after = values[rows], values[rows + 1]
    result = before + share * (after - before)
    result[:, POSITION] = between(times, values[:, POSITION], values[:, VELOCITY], at)[0]
    norms = np.linalg.norm(result[:, ATTITUDE], axis=1, keepdims=True)
    result[:, ATTITUDE] /= np.where(np.abs(norms - 1) > 1e-12, norms, 1.0)
    result[:, THRUSTS] = np.where(share < 1.0, before, after)[:, THRUSTS]
    return result

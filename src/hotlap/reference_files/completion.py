"""Completion: a whole reference from what a file says: what is missing follows from the rest (`flatness`).

Thrust per mass is what a controller feeds forward, so it must fit the motion of the file, whose drone may have had another
mass than the race's planning model. Mass and drag are therefore fitted to the file's accelerations. Where the mass is not
the planning model's, thrusts are scaled from one to the other; where no mass fits, thrust follows from the accelerations.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hotlap.race.race import PlanDynamics, Race
from hotlap.reference.attitude import thrust_axis
from hotlap.reference.reference import PERIOD, Reference, row_times
from hotlap.reference.run_out import extend
from hotlap.reference_files import flatness
from hotlap.reference_files.checks import axis_misfit, check_angles, check_axes, drag_of, foreign_acceleration
from hotlap.reference_files.columns import GROUPS
from hotlap.reference_files.resampling import resample
from hotlap.reference_files.table import ACCELERATION, ATTITUDE, POSITION, RATES, THRUSTS, TIME, VELOCITY, YAW, Table
from hotlap.reference_files.thrust_vectors import planned_thrust

Floats = NDArray[np.float64]

SAME_MASS = 0.01  # relative difference up to which a fitted mass is taken for the planning model's
SAME_DRAG = 0.01  # 1/s, likewise
WORST_FIT = 0.05  # of the median acceleration: what the fit may leave unexplained in half of the rows


def without_orphans(table: Table) -> Table:
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


def with_velocities(table: Table) -> Table:
    """The table with velocities."""
    if table.has("velocity"):
        return table
    values = table.values.copy()
    values[:, VELOCITY] = np.gradient(values[:, POSITION], values[:, TIME], axis=0)
    return table.with_values(values).noted("velocities follow from the positions")


def complete(table: Table, race: Race, gate_times: Floats) -> tuple[Table, Reference]:
    """Rows every 10 ms with what follows from the rest and a run-out; and the table with notes on it.

    Args:
        table: with velocities, in the frame of the track.
        race: its track and planning model count.
        gate_times: shape (gates,) [s] at which the file passes the gates.
    """
    times = table.values[:, TIME] - table.values[0, TIME]
    values = resample(times, table.values, row_times(float(times[-1])))
    fitted = _fit(table, race) if table.has("attitude") and table.has("thrusts") else None
    if fitted is not None and table.has("rates") and table.has("velocity"):
        mass, drag = fitted
        thrusts = np.maximum(values[:, THRUSTS], 0.0) * (race.planning_model.mass / mass)
        thrust = thrusts.sum(axis=1) / race.planning_model.mass
        if race.planning_model.rotor_count != thrusts.shape[1]:
            thrusts = flatness.rotor_thrusts(race.planning_model, thrust, values[:, RATES], PERIOD)
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

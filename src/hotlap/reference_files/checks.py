"""Checks: whether the columns of a file belong to each other, and if not, what they look like.

Positions are taken as they are. Velocities have to be their derivative, rates have to belong to the attitudes, and the thrust axis of the
attitudes has to point where the accelerations need it. Differences are taken over 50 ms, so that rounded or measured values pass.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.race.schema import LARGEST
from hotlap.reference.attitude import CONJUGATE, continuous, rotate, thrust_axis, turn_rates
from hotlap.reference.reference import PERIOD
from hotlap.reference_files.columns import GROUPS
from hotlap.reference_files.table import ACCELERATION, ANGLES, ATTITUDE, LEAST_ROWS, POSITION, RATES, THRUSTS, TIME, VELOCITY, Table

Floats = NDArray[np.float64]

LONGEST = 1000.0  # s
COARSEST = 0.1  # s between rows
JUMP = 0.1  # m between a row and where the velocities of the row before lead
SPAN = 0.05  # s over which columns are compared
FOREIGN = 0.5  # relative difference from which columns do not belong to each other
LIKE = 0.25  # relative difference up to which something is taken for the cause
AT_REST, UNTURNED = 0.1, 0.2  # m/s and rad/s: differences that prove nothing
SMOOTHED = 10  # rows
MOST_YAW = 8 * math.pi  # rad: more than anyone turns about the vertical without counting in degrees
MIRRORED = np.array([1.0, -1.0, -1.0])
MIRRORED_TURN = np.array([1.0, 1.0, -1.0, -1.0])
LEAVE_OUT = "or leave these columns out: they follow from the"


def check_times(table: Table) -> None:
    """Refuse times that do not ascend, in steps that can be interpolated."""
    times = table.values[:, TIME]
    steps = np.diff(times)
    if steps.min() <= 0:
        row = int(np.argmax(steps <= 0)) + 1
        raise table.error(row, "t", f"{times[row]:g} s does not come after {times[row - 1]:g} s, the time of the row before")
    if times[-1] - times[0] > LONGEST:
        raise table.error(len(times) - 1, "t", f"lasts {times[-1] - times[0]:g} s, more than {LONGEST:g}; t is in seconds")
    if steps.max() > COARSEST:
        row = int(steps.argmax()) + 1
        raise table.error(row, "t", f"{steps.max():.3g} s after the row before: more than {COARSEST:g} s is too coarse to fly")
    if times[-1] - times[0] < LEAST_ROWS * PERIOD:
        raise table.error(len(times) - 1, "t", f"lasts {times[-1] - times[0]:.3g} s only; t is in seconds")


def check_columns(table: Table) -> Table:
    """Refuse columns that do not belong to each other; quaternions are brought to norm 1, without sign jumps.

    Raises:
        InputError: naming the columns, their frame and unit, and what they look like.
    """
    values = table.values
    far = np.abs(values[:, POSITION]).max(axis=1) > LARGEST
    if far.any():
        raise table.error(int(far.argmax()), "p_x", f"lies more than {LARGEST:g} m away; positions are in metres")
    if table.has("attitude"):
        table = table.with_values(_with_unit_attitudes(table))
    if table.has("thrusts"):
        _check_thrusts(table)
    if table.has("velocity"):
        _check_velocities(table)
    return _check_rates(table) if table.has("attitude") and table.has("rates") else table


def check_angles(table: Table) -> None:
    """Refuse roll, pitch and yaw that are in degrees, although their names do not say so."""
    for place, name in enumerate(GROUPS["angles"], ANGLES.start):
        sizes = np.nan_to_num(np.abs(table.values[:, place]))
        if sizes.max() > MOST_YAW:
            row = int(sizes.argmax())
            reason = (
                f"{table.values[row, place]:g} rad is many turns; angles are in radians: call the column {name}_deg if they are degrees"
            )
            raise table.error(row, name, reason)


def _with_unit_attitudes(table: Table) -> Floats:
    """Values with quaternions of norm 1."""
    values, attitude = table.values.copy(), table.values[:, ATTITUDE]
    norms = np.linalg.norm(attitude, axis=1)
    odd = np.abs(norms - 1) > 0.1
    if odd.any():
        row = int(odd.argmax())
        raise table.error(row, "q_w", f"a quaternion (w, x, y, z) has norm 1, this one {norms[row]:.3g}")
    values[:, ATTITUDE] = continuous(np.where(np.abs(norms - 1)[:, None] > 1e-12, attitude / norms[:, None], attitude))
    return values


def _check_thrusts(table: Table) -> None:
    """Refuse thrusts that pull."""
    thrusts = table.values[:, THRUSTS]
    negative = thrusts.min(axis=1) < -0.01 * thrusts.max()
    if negative.any():
        row = int(negative.argmax())
        column = GROUPS["thrusts"][int(thrusts[row].argmin())]
        raise table.error(row, column, f"a rotor's thrust of {thrusts[row].min():.3g} N is negative")


def _check_velocities(table: Table) -> None:
    """Refuse velocities that are not the derivative of the positions."""
    values, times = table.values, table.values[:, TIME]
    position, velocity = values[:, POSITION], values[:, VELOCITY]
    stride = _stride(times)
    spans = (times[stride:] - times[:-stride])[:, None]
    wanted, given = (position[stride:] - position[:-stride]) / spans, _means(times, velocity, stride)
    misfit = _misfit(given, wanted, AT_REST)
    if misfit > FOREIGN:
        looks = _looks(given, wanted, AT_REST, _velocity_guesses(table, stride))
        reason = f"velocities in the world frame in m/s, the derivative of p_x, p_y, p_z; these {looks or _off(misfit)}"
        raise InputError(table.source, "v_x, v_y, v_z", f"are {reason}; correct them, {LEAVE_OUT} positions")
    steps = np.diff(times)[:, None]
    jumps = np.linalg.norm(np.diff(position, axis=0) - steps * (velocity[1:] + velocity[:-1]) / 2, axis=1)
    if jumps.max() > JUMP:
        row = int(np.argmax(jumps > JUMP)) + 1
        raise table.error(row, "p_x", f"lies {jumps[row - 1]:.2g} m from where the velocity leads (v_x, v_y, v_z are in the world frame)")


def _velocity_guesses(table: Table, stride: int) -> Iterator[tuple[str, Floats]]:
    """What velocities may be instead, as words and the velocities that they would be then."""
    times, velocity = table.values[:, TIME], table.values[:, VELOCITY]
    given = _means(times, velocity, stride)
    yield "look like km/h", given / 3.6
    yield "look like mm/s", given / 1e3
    yield "look like cm/s", given / 1e2
    yield "look as if y and z had the other sign (z down)", given * MIRRORED
    if table.has("attitude"):
        yield "look as if they were in the body frame", _means(times, rotate(table.values[:, ATTITUDE], velocity), stride)


def _check_rates(table: Table) -> Table:
    """Refuse body rates that do not belong to the attitudes; leave them out where they do but for the turn about the thrust axis."""
    times, attitude, rates = table.values[:, TIME], table.values[:, ATTITUDE], table.values[:, RATES]
    stride = _stride(times)
    wanted, given = turn_rates_over(times, attitude, stride), _means(times, rates, stride)
    misfit, errors = _misfit(given, wanted, UNTURNED), given - wanted
    across, about = _size(errors[:, :2]), _size(errors[:, 2:])
    if _misfit(given[:, :2], wanted[:, :2], UNTURNED) <= FOREIGN:
        if misfit <= LIKE or about < 3 * across:
            return table
        return table.without("rates", "w_z does not belong to the attitudes: w_x, w_y, w_z are left out")
    looks = _looks(given, wanted, UNTURNED, _rate_guesses(table, stride))
    reason = f"body rates in rad/s (x forward, y left, z up), as the attitudes q turn; these {looks or _off(misfit)}"
    raise InputError(table.source, "w_x, w_y, w_z", f"are {reason}; correct them, {LEAVE_OUT} attitudes")


def _rate_guesses(table: Table, stride: int) -> Iterator[tuple[str, Floats]]:
    """What rates may be instead, as words and the body rates that they would be then."""
    times, attitude, rates = table.values[:, TIME], table.values[:, ATTITUDE], table.values[:, RATES]
    frames: Mapping[str, Floats] = {
        "": rates,
        "in the world frame": rotate(attitude * CONJUGATE, rates),
        "of a body with z down": rates * MIRRORED,
        "of the opposite sign": -rates,
    }
    for unit, factor in (("", 1.0), ("in degrees per second", math.pi / 180)):
        for frame, turned in frames.items():
            if unit or frame:
                yield f"look like rates {' '.join(filter(None, (unit, frame)))}", factor * _means(times, turned, stride)


def check_axes(source: str, attitude: Floats, vectors: Floats) -> None:
    """Refuse attitudes whose thrust axis does not point where the accelerations need it.

    Args:
        source: the file, for messages.
        attitude: shape (rows, 4), every 10 ms.
        vectors: shape (rows, 3) [m/s^2] (world) that the rotors have to give.

    Raises:
        InputError: naming the columns, their frame, and what they look like.
    """
    misfit = axis_misfit(attitude, vectors)
    if misfit <= LIKE:
        return
    guesses = {
        "look as if they were in the order x, y, z, w": np.roll(attitude, 1, axis=1),
        "look as if they were from world to body": attitude * CONJUGATE,
        "look as if y and z had the other sign (z down)": attitude * MIRRORED_TURN,
    }
    fits = {words: axis_misfit(guess, vectors) for words, guess in guesses.items()}
    best = min(fits, key=fits.__getitem__)
    looks = best if fits[best] < min(LIKE, misfit / 2) else f"do not explain the accelerations of v_x, v_y, v_z ({100 * misfit:.0f} % off)"
    reason = f"quaternions (w, x, y, z) from body to world, z up, whose z axis is that of the thrust; these {looks}"
    raise InputError(source, "q_w, q_x, q_y, q_z", f"are {reason}; correct them, {LEAVE_OUT} accelerations")


def drag_of(attitude: Floats, velocity: Floats, weight: Floats) -> float:
    """Linear drag [1/s] that lets attitudes explain a motion best: least squares across the thrust axis.

    Args:
        attitude: shape (rows, 4).
        velocity: shape (rows, 3) [m/s] (world).
        weight: shape (rows, 3) [m/s^2] (world) accelerations and gravity, which thrust and drag make together.
    """
    needed, speed = _across(attitude, weight), _across(attitude, velocity)
    squares = float((speed**2).sum())
    return max(-float((needed * speed).sum()) / squares, 0.0) if squares > 1e-9 else 0.0


def axis_misfit(attitude: Floats, vectors: Floats) -> float:
    """Share of thrust vectors that lies across the thrust axis, or all of one that points the other way; the worst tenth apart.

    Means over 100 ms are compared, so that measured values pass.
    """
    kernel = np.full(SMOOTHED, 1 / SMOOTHED)
    axes, needed = (np.stack([np.convolve(one, kernel, "valid") for one in rows.T], axis=1) for rows in (thrust_axis(attitude), vectors))
    axes = axes / np.maximum(np.linalg.norm(axes, axis=1, keepdims=True), 1e-9)
    along, squares = (needed * axes).sum(axis=1), (needed**2).sum(axis=1)
    across = np.sort(np.where(along < 0, squares, squares - along**2))
    return math.sqrt(across[: max(1, int(0.9 * len(across)))].mean() / max(float(squares.mean()), 1e-9))


def _across(attitude: Floats, vectors: Floats) -> Floats:
    """What of vectors lies across the thrust axis, shape (rows, 3)."""
    axis = thrust_axis(attitude)
    return vectors - axis * (vectors * axis).sum(axis=1, keepdims=True)


def foreign_acceleration(table: Table) -> str:
    """Why accelerations are not the derivative of the velocities; "" where they are."""
    times, velocity, acceleration = table.values[:, TIME], table.values[:, VELOCITY], table.values[:, ACCELERATION]
    stride = _stride(times)
    wanted = (velocity[stride:] - velocity[:-stride]) / (times[stride:] - times[:-stride])[:, None]
    given = _means(times, acceleration, stride)
    return "" if _misfit(given, wanted, AT_REST) <= FOREIGN else "a_x, a_y, a_z are not the derivative of the velocities: left out"


def turn_rates_over(times: Floats, attitude: Floats, stride: int) -> Floats:
    """Mean body rates from each row to that so many rows later, shape (rows - stride, 3) [rad/s]: means of those from row to row."""
    rates = turn_rates(attitude, np.diff(times))
    turned = np.vstack([np.zeros(3), np.cumsum(rates * np.diff(times)[:, None], axis=0)])
    return (turned[stride:] - turned[:-stride]) / (times[stride:] - times[:-stride])[:, None]


def _stride(times: Floats) -> int:
    """So many rows are about `SPAN`."""
    return min(max(1, round(SPAN / float(np.median(np.diff(times))))), len(times) // 2)


def _means(times: Floats, values: Floats, stride: int) -> Floats:
    """Means over time from each row to that so many rows later, shape (rows - stride, ...)."""
    steps = np.diff(times)[:, None]
    summed = np.vstack([np.zeros(values.shape[1]), np.cumsum(steps * (values[1:] + values[:-1]) / 2, axis=0)])
    return (summed[stride:] - summed[:-stride]) / (times[stride:] - times[:-stride])[:, None]


def _misfit(given: Floats, wanted: Floats, least: float) -> float:
    """Relative root mean square difference; 0 where it is less than `least` in units."""
    error = _size(given - wanted)
    return 0.0 if error < least else error / max(_size(wanted), least)


def _size(values: Floats) -> float:
    """Root mean square of rows, the worst hundredth of them apart: more would take away all turns of a flight that turns seldom."""
    squares = np.sort((values**2).sum(axis=1))
    return math.sqrt(squares[: max(1, int(0.99 * len(squares)))].mean())


def _looks(given: Floats, wanted: Floats, least: float, guesses: Iterator[tuple[str, Floats]]) -> str:
    """What columns look like, in words; "" where nothing fits."""
    if not np.abs(given).max() > 1e-9:
        return "are all zero"
    fits = {words: _misfit(guess, wanted, least) for words, guess in guesses}
    best = min(fits, key=fits.__getitem__)
    return best if fits[best] < LIKE else ""


def _off(misfit: float) -> str:
    return f"do not fit ({100 * misfit:.0f} % off)" if misfit < 100 else "do not fit at all"

"""References as CSV, the field's own format (rpg_time_optimal, AutoTune, agilicious), in and out.

    t, p_x, p_y, p_z, q_w, q_x, q_y, q_z, v_x, v_y, v_z, w_x, w_y, w_z, u_1, u_2, u_3, u_4

Columns are found by name; an index in front and whatever stands behind is ignored. Conventions are those of `quadrotor.py`;
u_1 to u_4 are rotor thrusts [N], held from a row to the next. Rows need not be evenly spaced.

Thrust per mass is what a controller feeds forward, so it must fit the motion of the file, whose drone may have had another
mass than the race's planning model. Mass and drag are therefore fitted to the file's accelerations. Where the mass is not
the planning model's, thrusts are scaled from one to the other; where no mass fits, the file is refused.
"""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.files.error_messages import show
from hotlap.planning.attitude import continuous, product, thrust_axis
from hotlap.planning.passages import MissedGateError, find_passages
from hotlap.planning.run_out import extend
from hotlap.race.race import Race
from hotlap.race.track import REACH
from hotlap.reference.reference import PERIOD, Reference, row_times
from hotlap.system.text_files import replace

Floats = NDArray[np.float64]

COLUMNS = (
    "t", "p_x", "p_y", "p_z", "q_w", "q_x", "q_y", "q_z", "v_x", "v_y", "v_z", "w_x", "w_y", "w_z", "u_1", "u_2", "u_3", "u_4",
)  # fmt: skip
TIME, POSITION, ATTITUDE, VELOCITY, RATES, THRUSTS = 0, slice(1, 4), slice(4, 8), slice(8, 11), slice(11, 14), slice(14, 18)

MAX_BYTES = 20_000_000  # the largest known, with the columns of complementary progress, takes half
LEAST_ROWS = 10
LONGEST = 1000.0  # s
COARSEST = 0.1  # s between rows
JUMP = 0.1  # m between a row and where the velocities of the row before lead
SAME_MASS = 0.01  # relative difference up to which a fitted mass is taken for the planning model's
SAME_DRAG = 0.01  # 1/s, likewise
WORST_FIT = 0.05  # of the median acceleration: what the fit may leave unexplained in half of the rows


@dataclass(frozen=True)
class _Table:
    """The columns of a file.

    Attributes:
        source: the file, for messages.
        values: shape (rows, 18), in the order of `COLUMNS`.
        lines: shape (rows,) line of the file that each row stands in.
    """

    source: str
    values: Floats
    lines: NDArray[np.int64]

    def error(self, row: int, column: str, reason: str) -> InputError:
        """The fault of one value, or of a whole row where the column is ""."""
        return _fault(self.source, int(self.lines[row]), column, reason)


def load_reference(path: str | Path, race: Race) -> Reference:
    """A reference from a CSV file, every 10 ms, with its gate times and a run-out.

    Time begins with the first row. The track's gates must be passed in order, as closely as the race's judge demands.

    Args:
        path: the file.
        race: its track, planning model and judge count.

    Raises:
        InputError: with the file, the line and column or the gate, and the reason.
    """
    table = _read(Path(path))
    _check_times(table)
    _check_motion(table, race)
    return _reference(table, race)


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


def _read(path: Path) -> _Table:
    """The columns of a file, every value a finite number."""
    reader = csv.reader(io.StringIO(_text(path), newline=""))
    numbers: list[list[float]] = []
    lines: list[int] = []
    try:
        places = _places(str(path), next(reader, []))
        rows = [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]
    except csv.Error as error:
        raise InputError(str(path), f"line {reader.line_num}", f"is no CSV: {error}") from None
    for line, cells in rows:
        last = line == rows[-1][0]
        numbers.append([_number(str(path), line, name, cells, places[name], last) for name in COLUMNS])
        lines.append(line)
    if len(numbers) < LEAST_ROWS:
        raise InputError(str(path), "", f"has {len(numbers)} rows; a flight takes at least {LEAST_ROWS}")
    values = np.array(numbers)
    _mend_last_thrusts(values)
    return _Table(str(path), values, np.array(lines))


def _text(path: Path) -> str:
    """What stands in a file."""
    source = str(path)
    try:
        if not path.exists():
            raise InputError(source, "", "there is no such file")
        if not path.is_file():
            raise InputError(source, "", "is a folder, not a file" if path.is_dir() else "is not a file of text")
        if path.stat().st_size > MAX_BYTES:
            raise InputError(source, "", f"is larger than {MAX_BYTES / 1e6:g} MB: this is no reference")
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(source, "", f"is not UTF-8 text (byte {error.start + 1})") from None
    except OSError as error:
        raise InputError(source, "", f"cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        raise InputError(source, "", f"is no usable path: {error}") from None


def _places(source: str, header: list[str]) -> dict[str, int]:
    """Where each column stands."""
    names = [name.strip().removeprefix("#").strip() for name in header]
    if not any(names):
        raise InputError(source, "line 1", "is empty; it must be a header that names the columns")
    missing = [name for name in COLUMNS if name not in names]
    if len(missing) == len(COLUMNS):
        raise InputError(source, "line 1", f"is no header of a reference; it must have the columns {','.join(COLUMNS)}")
    if missing:
        raise InputError(source, missing[0], f"this column is missing; needed: {','.join(COLUMNS)}")
    twice = [name for name in COLUMNS if names.count(name) > 1]
    if twice:
        raise InputError(source, twice[0], "this column stands there twice")
    return {name: names.index(name) for name in COLUMNS}


def _number(source: str, line: int, column: str, cells: list[str], place: int, last: bool) -> float:
    """One value; a thrust in the last row need not be there, for nothing follows it."""
    cell = cells[place].strip() if place < len(cells) else ""
    try:
        value = float(cell)
    except ValueError:
        value = np.nan
    if np.isfinite(value) or (last and column.startswith("u_")):
        return value
    if place >= len(cells):
        raise _fault(source, line, column, f"is missing: the line has only {len(cells)} values")
    raise _fault(source, line, column, f"must be a finite number, not {show(cell)}")


def _mend_last_thrusts(values: Floats) -> None:
    """Robustness the last thrusts but one where the last ones are unlike any before: they are often zeros or NaN."""
    before, last = values[:-1, THRUSTS], values[-1, THRUSTS]
    like = np.all(last >= 0) and np.all(last <= 1.001 * before.max()) and last.sum() >= 0.999 * before.sum(axis=1).min()
    if not like:
        values[-1, THRUSTS] = values[-2, THRUSTS]


def _check_times(table: _Table) -> None:
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


def _check_motion(table: _Table, race: Race) -> None:
    """Refuse what is no flight, or none of this track; bring quaternions to norm 1."""
    values = table.values
    position, velocity, attitude, thrusts = values[:, POSITION], values[:, VELOCITY], values[:, ATTITUDE], values[:, THRUSTS]
    far = np.abs(position).max(axis=1) > REACH
    if far.any():
        raise table.error(int(far.argmax()), "p_x", f"lies more than {REACH:g} m away; positions are in metres")
    norms = np.linalg.norm(attitude, axis=1)
    odd = np.abs(norms - 1) > 0.1
    if odd.any():
        row = int(odd.argmax())
        raise table.error(row, "q_w", f"a quaternion (w, x, y, z) has norm 1, this one {norms[row]:.3g}")
    values[:, ATTITUDE] = continuous(np.where(np.abs(norms - 1)[:, None] > 1e-12, attitude / norms[:, None], attitude))
    negative = thrusts.min(axis=1) < -0.01 * thrusts.max()
    if negative.any():
        row = int(negative.argmax())
        raise table.error(row, COLUMNS[14 + int(thrusts[row].argmin())], f"a rotor's thrust of {thrusts[row].min():.3g} N is negative")
    steps = np.diff(values[:, TIME])[:, None]
    jumps = np.linalg.norm(np.diff(position, axis=0) - steps * (velocity[1:] + velocity[:-1]) / 2, axis=1)
    if jumps.max() > JUMP:
        row = int(np.argmax(jumps > JUMP)) + 1
        raise table.error(row, "p_x", f"lies {jumps[row - 1]:.2g} m from where the velocity leads (v_x, v_y, v_z are in the world frame)")
    away = float(np.linalg.norm(position[0] - np.array(race.track.start)))
    if away > race.judge.distance:
        raise table.error(0, "p_x", f"begins {away:.2f} m away from the start of {race.track.name}; at most {race.judge.distance:g} m")


def _reference(table: _Table, race: Race) -> Reference:
    """Resampled, with gate times and run-out."""
    mass, drag = _fit(table, race)
    times = table.values[:, TIME] - table.values[0, TIME]
    duration = float(times[-1])
    values = _resample(times, table.values, row_times(duration))
    thrusts = np.maximum(values[:, THRUSTS], 0.0) * (race.planning_model.mass / mass)
    reference = Reference(
        position=values[:, POSITION],
        attitude=values[:, ATTITUDE],
        velocity=values[:, VELOCITY],
        rates=values[:, RATES],
        thrust=thrusts.sum(axis=1) / race.planning_model.mass,
        rotor_thrusts=thrusts,
        gate_times=_gate_times(table, times, race),
        duration=duration,
    )
    return extend(reference, race.planning_model.gravity, drag)


def _gate_times(table: _Table, times: Floats, race: Race) -> Floats:
    """When the file passes the gates of the track, shape (gates,) [s]."""
    position, velocity = table.values[:, POSITION], table.values[:, VELOCITY]
    try:
        return find_passages(times, position, velocity, race.track.gate_positions, race.judge.distance)
    except MissedGateError as error:
        raise InputError(table.source, f"gate {error.gate}", error.reason) from None


def _fit(table: _Table, race: Race) -> tuple[float, float]:
    """Mass [kg] and linear drag [1/s] of the drone that the file was made for.

    Least squares over all rows of dv/dt + g = z_body sum(u) / m - d v; gravity is the planning model's.
    """
    values = table.values
    accelerations = np.diff(values[:, VELOCITY], axis=0) / np.diff(values[:, TIME])[:, None] + np.array([0, 0, race.planning_model.gravity])
    axes, velocity = thrust_axis(values[:, ATTITUDE]), values[:, VELOCITY]
    pushes = (axes[1:] + axes[:-1]) / 2 * values[:-1, THRUSTS].sum(axis=1)[:, None]
    columns = np.stack([pushes.ravel(), -(velocity[1:] + velocity[:-1]).ravel() / 2], axis=1)
    inverse_mass, drag = np.linalg.lstsq(columns, accelerations.ravel(), rcond=None)[0]
    misfits = np.linalg.norm(accelerations - (columns @ [inverse_mass, drag]).reshape(-1, 3), axis=1)
    share = np.median(misfits) / np.median(np.linalg.norm(accelerations, axis=1))
    if not (inverse_mass > 0 and share < WORST_FIT):
        reason = f"thrusts and attitudes do not explain the accelerations of v_x, v_y, v_z ({100 * share:.0f} % off; world z up, u in N)"
        raise InputError(table.source, "u_1 to u_4", reason)
    same_mass, same_drag = abs(inverse_mass * race.planning_model.mass - 1) < SAME_MASS, abs(drag - race.planning_drag) < SAME_DRAG
    return race.planning_model.mass if same_mass else float(1 / inverse_mass), race.planning_drag if same_drag else max(float(drag), 0.0)


def _resample(times: Floats, values: Floats, at: Floats) -> Floats:
    """Rows at other times, shape (at, 18): positions by cubics with the right velocities, thrusts held, the rest linearly."""
    rows = np.clip(np.searchsorted(times, at + 1e-9, side="right") - 1, 0, len(times) - 2)
    steps = (times[rows + 1] - times[rows])[:, None]
    share = np.clip((at - times[rows])[:, None] / steps, 0.0, 1.0)
    before, after = values[rows], values[rows + 1]
    result = before + share * (after - before)
    p0, p1, v0, v1 = before[:, POSITION], after[:, POSITION], before[:, VELOCITY] * steps, after[:, VELOCITY] * steps
    result[:, POSITION] = p0 + share * v0 + share**2 * (3 * (p1 - p0) - 2 * v0 - v1) + share**3 * (2 * (p0 - p1) + v0 + v1)
    norms = np.linalg.norm(result[:, ATTITUDE], axis=1, keepdims=True)
    result[:, ATTITUDE] /= np.where(np.abs(norms - 1) > 1e-12, norms, 1.0)
    result[:, THRUSTS] = np.where(share < 1.0, before, after)[:, THRUSTS]
    return result


def _fault(source: str, line: int, column: str, reason: str) -> InputError:
    """The fault of one value of a file."""
    return InputError(source, f"line {line}" + (f", {column}" if column else ""), reason)

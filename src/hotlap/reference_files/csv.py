"""References as CSV, the field's own format (rpg_time_optimal, AutoTune, agilicious, TOGT), in and out.

    t, p_x, p_y, p_z, q_w, q_x, q_y, q_z, v_x, v_y, v_z, w_x, w_y, w_z, u_1, u_2, u_3, u_4

Columns are found by name; an index in front and whatever stands behind is ignored. Conventions are those of `quadrotor.py`;
u_1 to u_4 are rotor thrusts [N], held from a row to the next. Rows need not be evenly spaced. Time and position are needed; what is
missing of the rest follows from them (`completion`), and what is said of it is checked (`checks`).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hotlap.race.race import Race
from hotlap.reference.attitude import product
from hotlap.reference.reference import Reference
from hotlap.reference_files.checks import check_columns, check_times
from hotlap.reference_files.columns import GROUPS, WHOLE
from hotlap.reference_files.completion import complete, with_velocities, without_orphans
from hotlap.reference_files.frames import in_track_frame
from hotlap.reference_files.table import ATTITUDE, POSITION, RATES, TIME, VELOCITY, read_table, without_repeated
from hotlap.system.text_files import replace

Floats = NDArray[np.float64]

ROTORS = 4  # that the format has columns for
COLUMNS = tuple(name for group in WHOLE for name in GROUPS[group])


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
    table = with_velocities(check_columns(without_orphans(table)))
    table, gate_times = in_track_frame(table, race)
    table, reference = complete(table, race, gate_times)
    return ReadReference(reference, tuple(f"{path}: {note}" for note in table.notes))


def save_reference(path: str | Path, reference: Reference) -> None:
    """Write the planned rows of a reference, and a last row at its duration; reading them gives the same rows bit for bit.

    Gate times are not in the file: reading finds them anew, as closest approaches. Thrusts of other than four rotors have no columns in the
    format: reading finds them from the motion.

    Raises:
        InputError: when the file cannot be written.
    """
    rows = reference.planned_rows
    of_four = reference.rotor_thrusts.shape[1] == ROTORS
    columns = (reference.position, reference.attitude, reference.velocity, reference.rates, reference.rotor_thrusts)[: 4 + of_four]
    table = np.hstack([reference.times[:rows, None], *(column[:rows] for column in columns)])
    rest = reference.duration - table[-1, TIME]
    if rest > 1e-9:
        table = np.vstack([table, _continue(table, rest)])
    text = "".join(",".join(map(repr, row)) + "\n" for row in table.tolist())
    replace(path, ",".join(COLUMNS if of_four else COLUMNS[:-ROTORS]) + "\n" + text)


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

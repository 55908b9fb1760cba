"""References survive CSV, and what is no reference is refused with its place."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.core.errors import InputError
from hotlap.race.race import Race
from hotlap.reference.reference import Reference
from hotlap.reference.run_out import extend
from hotlap.reference_files import table as reference_table
from hotlap.reference_files.csv import COLUMNS, load_reference, save_reference
from planning import small

Table = dict[str, list[str]]

RACE = small.RACES["drag"]


@pytest.fixture
def path(reference, tmp_path) -> Path:
    """Its file."""
    save_reference(tmp_path / "flight.csv", reference)
    return tmp_path / "flight.csv"


def edit(path: Path, change: Callable[[Table], object]) -> None:
    """Change the columns of a file."""
    with path.open() as file:
        header, *rows = list(csv.reader(file))
    table = dict(zip(header, map(list, zip(*rows, strict=True)), strict=True))
    change(table)
    with path.open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([list(table), *zip(*table.values(), strict=True)])


def scale(table: Table, columns: str, factor: float) -> None:
    """Multiply columns whose names begin alike."""
    for name in table:
        if name.startswith(columns):
            table[name] = [repr(factor * float(cell)) for cell in table[name]]


def with_mass(mass: float) -> Race:
    """The race with a planning model of another mass and the same thrust per mass."""
    share = mass / RACE.planning_model.mass
    low, high = RACE.planning_model.rotor_thrust
    planned = RACE.planning_model.model_copy(update={"mass": mass, "rotor_thrust": (share * low, share * high)})
    return RACE.model_copy(update={"planning": RACE.planning.model_copy(update={"quadrotor": planned})})


def assert_same_rows(found: Reference, expected: Reference) -> None:
    for name in ("position", "attitude", "velocity", "rates", "thrust", "rotor_thrusts"):
        assert_allclose(getattr(found, name), getattr(expected, name), rtol=1e-12, atol=1e-12, err_msg=name)


def test_what_was_saved_is_read_back(path, reference):
    found = load_reference(path, RACE)
    assert_same_rows(found, reference)
    assert found.duration == pytest.approx(reference.duration, abs=1e-12)
    assert found.cpu_time == 0


def test_gate_times_are_found_anew_where_the_plan_has_them(path, reference):
    found = load_reference(path, RACE)
    assert_allclose(found.gate_times, reference.gate_times, atol=0.02)
    distances = np.linalg.norm(found.position_at(found.gate_times) - RACE.track.gate_positions, axis=1)
    assert distances.max() <= RACE.planning.tolerance + 0.01


def test_planned_rows_are_written_from_time_zero_in_full_precision(path, reference):
    values = np.genfromtxt(path, delimiter=",", skip_header=1)
    rows = reference.planned_rows
    assert path.read_text().splitlines()[0] == ",".join(COLUMNS)
    assert (values.shape, values[0, 0], values[-1, 0]) == ((rows + 1, 18), 0.0, pytest.approx(reference.duration))
    assert_array_equal(values[:rows, 1:4], reference.position[:rows])
    assert_array_equal(values[:rows, 14:], reference.rotor_thrusts[:rows])


def test_the_row_at_the_duration_goes_on_from_the_one_before(path, reference):
    last = np.genfromtxt(path, delimiter=",", skip_header=1)[-1]
    assert_allclose(last[1:4], reference.position_at(np.array([reference.duration]))[0], atol=1e-3)
    assert np.linalg.norm(last[4:8]) == pytest.approx(1.0)


def test_a_reference_that_ends_on_a_row_gets_no_further_one_and_keeps_its_last_thrusts(reference, tmp_path):
    thrusts = reference.rotor_thrusts[: reference.planned_rows].sum(axis=1)
    last = 100 + int(np.abs(np.diff(thrusts[99:])).argmax())  # just after a switch
    race = small.make_race([tuple(reference.position[last].tolist())])
    whole = extend(replace(reference, duration=0.01 * last), race.planning_model.gravity, race.planning_drag)
    save_reference(tmp_path / "flight.csv", whole)
    assert len((tmp_path / "flight.csv").read_text().splitlines()) == 2 + last
    assert_same_rows(load_reference(tmp_path / "flight.csv", race), whole)


def test_an_index_in_front_more_columns_behind_and_another_order_change_nothing(path, reference):
    def rearrange(table):
        turned = dict(reversed(list(table.items())))
        table.clear()
        table.update({"": [str(k) for k in range(len(turned["t"]))], **turned, "mu_0": ["rubbish"] * len(turned["t"])})

    edit(path, rearrange)
    assert_same_rows(load_reference(path, RACE), reference)


@pytest.mark.parametrize("cell", ["0.0", "nan", "", "-1e-33", "1e9", "1e308", "rubbish"])
def test_thrusts_of_the_last_row_need_not_be_there(path, reference, cell):
    edit(path, lambda table: [table[f"u_{rotor}"].__setitem__(-1, cell) for rotor in (1, 2, 3, 4)])
    assert_same_rows(load_reference(path, RACE), reference)


@pytest.mark.parametrize("ending", ["\r\n", "\n\n", "\n"])
def test_line_endings_blank_lines_and_a_byte_order_mark_do_not_matter(path, reference, ending):
    text = path.read_text()
    path.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", ending).replace(",", ", ").encode())
    assert_same_rows(load_reference(path, RACE), reference)


def test_time_may_begin_anywhere(path, reference):
    edit(path, lambda table: table.update(t=[repr(100.0 + float(cell)) for cell in table["t"]]))
    assert_allclose(load_reference(path, RACE).position, reference.position, atol=1e-6)


def test_signs_of_quaternions_do_not_matter(path, reference):
    def flip(table):
        for name in ("q_w", "q_x", "q_y", "q_z"):
            table[name] = [repr((-1) ** (k // 7) * float(cell)) for k, cell in enumerate(table[name])]

    edit(path, flip)
    assert_same_rows(load_reference(path, RACE), reference)


def test_uneven_rows_are_resampled_to_the_same_flight(path, reference):
    def thin_out(table):
        kept = sorted({0, *np.cumsum(np.random.default_rng(0).integers(1, 4, size=1000)).tolist()})
        kept = [k for k in kept if k < len(table["t"]) - 1] + [len(table["t"]) - 1]
        for name, cells in table.items():
            table[name] = [cells[k] for k in kept]

    edit(path, thin_out)
    found, rows = load_reference(path, RACE), reference.planned_rows
    assert found.planned_rows == rows
    assert_allclose(found.position[:rows], reference.position[:rows], atol=2e-3)
    assert_allclose(found.velocity[:rows], reference.velocity[:rows], atol=0.05)
    assert_allclose(np.abs((found.attitude[:rows] * reference.attitude[:rows]).sum(axis=1)), 1.0, atol=2e-3)
    assert_allclose(np.linalg.norm(found.attitude, axis=1), 1.0, atol=1e-9)
    assert_allclose(found.gate_times, reference.gate_times, atol=0.02)


def test_another_mass_of_the_file_is_found_and_leaves_thrust_per_mass_as_it_is(path, reference):
    for mass in (0.5, 2.0):
        found = load_reference(path, with_mass(mass))
        assert_allclose(found.thrust, reference.thrust, rtol=2e-3)
        rows = found.planned_rows
        assert_allclose(found.rotor_thrusts[:rows], mass * reference.rotor_thrusts[:rows], rtol=2e-3)


def test_the_run_out_goes_on_with_the_drag_of_the_file_not_of_the_race(path, reference):
    other = RACE.model_copy(update={"planning": RACE.planning.model_copy(update={"v_max": 10.0})})
    assert_allclose(load_reference(path, other).position, reference.position, atol=0.01)


def fault(path: Path, race: Race = RACE) -> str:
    """The message for a file, without its path."""
    with pytest.raises(InputError) as caught:
        load_reference(path, race)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    return message.removeprefix(f"{path}: ")


def put(row: int, **cells: str) -> Callable[[Table], object]:
    """Change single cells of a row."""
    return lambda table: [table[name].__setitem__(row, cell) for name, cell in cells.items()]


EDITS = {
    "a column is missing": (lambda table: table.pop("v_y"), "v_y: this column is missing; needed: t,p_x,p_y,p_z;"),
    "not a number": (put(3, w_y="x7"), 'line 5, w_y: must be a finite number, not "x7"'),
    "NaN": (put(3, p_z="nan"), 'line 5, p_z: must be a finite number, not "nan"'),
    "infinity": (put(3, u_2="inf"), 'line 5, u_2: must be a finite number, not "inf"'),
    "a number that overflows": (put(3, v_x="1e200"), 'line 5, v_x: must be a finite number, not "1e200"'),
    "NaN in the last row": (put(-1, q_x="nan"), "q_x: must be a finite number"),
    "no quaternion": (put(3, q_w="0.1", q_x="0", q_y="0", q_z="0"), "line 5, q_w: a quaternion (w, x, y, z) has norm 1, this one 0.1"),
    "time stands still": (put(3, t="0.02"), "line 5, t: 0.02 s stands in line 4 already, with other values"),
    "time goes back": (put(3, t="0.01"), "line 5, t: 0.01 s does not come after 0.02 s"),
    "milliseconds": (lambda table: scale(table, "t", 1000.0), "lasts 4292.82 s, more than 1000; t is in seconds"),
    "hardly any time": (lambda table: scale(table, "t", 1e-3), "t is in seconds"),
    "a gap": (put(-1, t="9.0"), "s is too coarse to fly"),
    "far away": (put(3, p_y="1e6"), "line 5, p_x: lies more than 100000 m away; positions are in metres"),
    "a jump": (put(40, p_y="50"), "line 42, p_x: lies"),
    "negative thrust": (put(3, u_3="-3"), "line 5, u_3: a rotor's thrust of -3 N is negative"),
    "too short": (lambda table: table.update({name: cells[:5] for name, cells in table.items()}), "has 5 rows; a flight takes at least 10"),
}


@pytest.mark.parametrize(("change", "message"), EDITS.values(), ids=EDITS)
def test_a_faulty_value_is_refused_with_its_line_and_column(path, change, message):
    edit(path, change)
    assert message in fault(path)


CONTENTS = {
    "empty": (b"", "line 1: is empty; it must be a header that names the columns"),
    "numbers only": (b"0,1,2\n3,4,5\n", "line 1: is no header, and 3 columns could be anything; name them in the first line"),
    "TOML": (b'name = "circle"\n', "line 1: is no header of a reference"),
    "a header further down": (b"# of ours\n\nfoo,bar\n1,2\n", "line 3: is no header of a reference"),
    "header only": ((",".join(COLUMNS) + "\n").encode(), "has 0 rows; a flight takes at least 10"),
    "a column twice": (("t," + ",".join(COLUMNS) + "\n").encode(), "t: this column stands there twice"),
    "a short line": ((",".join(COLUMNS) + "\n0.0,1.0\n").encode(), "line 2, p_y: is missing: the line has only 2 values"),
    "binary": (b"\x89PNG\r\n\x1a\n\xff\xfe", "is not UTF-8 text (byte 1)"),
    "endless numbers without a header": (
        b",".join([b"1e300"] * 8) + b"\n" + b",".join([b"-1e200"] * 8) + b"\n",
        "line 1, t: must be a finite number, not ",
    ),
    "an endless field": ((",".join(COLUMNS) + "\n" + "1" * 200_000).encode(), "line 2: is no CSV: field larger than field limit"),
}


@pytest.mark.parametrize(("content", "message"), CONTENTS.values(), ids=CONTENTS)
def test_what_is_no_reference_is_refused(tmp_path, content, message):
    path = tmp_path / "flight.csv"
    path.write_bytes(content)
    assert fault(path).startswith(message)


def test_a_file_that_is_not_there_a_folder_and_a_huge_file_are_refused(tmp_path, monkeypatch, path):
    assert fault(tmp_path / "nothing.csv") == "there is no such file"
    assert fault(tmp_path) == "is a folder, not a file"
    monkeypatch.setattr(reference_table, "MAX_BYTES", 1000)
    assert fault(path) == "is larger than 0.001 MB: this is no reference"


def test_another_tracks_reference_is_refused_at_its_start(path):
    away = RACE.model_copy(update={"track": RACE.track.model_copy(update={"start": (0.0, 3.0, 0.5)})})
    assert fault(path, away) == "line 2, p_x: begins 3.00 m away from the start of small; at most 1.3 m (judge.distance)"


def test_a_gate_that_is_passed_too_far_away_is_named(path):
    gates = [gate.position for gate in RACE.track.gates]
    moved = small.make_race([gates[0], (gates[1][0], gates[1][1], gates[1][2] + 3.0), *gates[2:]])
    assert fault(path, moved).startswith("gate 2: is passed at 3.")


def test_gates_in_another_order_are_refused(path):
    gates = [gate.position for gate in RACE.track.gates]
    assert fault(path, small.make_race([gates[1], gates[0]])) == "gate 2: is not passed after gate 1, only before it"


def test_a_place_that_cannot_be_written_is_named(reference, tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        save_reference(tmp_path / "nowhere" / "flight.csv", reference)

"""However a file is written, its columns are understood."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.core.errors import InputError
from hotlap.reference_files.csv import read_reference
from hotlap.reference_files.table import read_table

from .flights import RACE, Columns, Q, U, V, W, assert_same_flight, some, write


def text_with(whole: Columns, change: Callable[[str], str], *, header: bool = True) -> str:
    """The file as text, changed."""
    names, rows = ",".join(whole), np.column_stack(list(whole.values())).tolist()
    return change("\n".join([names] * header + [",".join(map(repr, row)) for row in rows]) + "\n")


FORMS: dict[str, tuple[Callable[[str], str], bool, str]] = {
    "semicolons": (lambda text: text.replace(",", ";"), True, ""),
    "tabs": (lambda text: text.replace(",", "\t"), True, ""),
    "spaces": (lambda text: text.replace(",", "  "), True, ""),
    "decimal commas": (lambda text: text.replace(",", ";").replace(".", ","), True, "decimal commas are read as points"),
    "comments": (lambda text: "# made by hand\n" + text.replace("\n", "\n% a remark\n", 3), True, ""),
    "a header that is a comment": (lambda text: "# " + text.replace(",", " "), True, ""),
    "no header": (lambda text: text, False, "it has no header; its 18 columns are read as t, p_x, p_y"),
    "no header but an index": (
        lambda text: "\n".join(f"{k},{line}" for k, line in enumerate(text.splitlines())),
        False,
        "it has no header; its 19 columns are read as an index, t, p_x",
    ),
    "other names": (lambda text: text.replace("t,p_x,p_y,p_z", "time,x,y,z", 1).replace("v_x", "vel_x", 1).replace("q_w", "qw"), True, ""),
    "units in brackets": (lambda text: text.replace("t,p_x", "t [s],p_x [m]", 1), True, ""),
    "quotation marks": (lambda text: text.replace("t,p_x", '"t","p_x"', 1), True, ""),
}


@pytest.mark.parametrize(("change", "header", "note"), FORMS.values(), ids=FORMS)
def test_the_form_of_a_file_changes_nothing(whole, reference, tmp_path, change, header, note):
    path = tmp_path / "form.csv"
    path.write_text(text_with(whole, change, header=header))
    read = read_reference(path, RACE)
    assert_allclose(read.reference.table, reference.table, atol=1e-9)
    assert len(read.notes) == bool(note)
    assert all(note in said for said in read.notes)


def test_decimal_commas_may_begin_behind_a_row_of_whole_numbers(tmp_path):
    path = tmp_path / "flight.csv"
    path.write_text("t;p_x;p_y;p_z\n0;0;0;1\n" + "".join(f"0,0{k};0;0;1\n" for k in range(1, 10)))
    table = read_table(path)
    assert_allclose(table.values[:, 0], 0.01 * np.arange(10))
    assert table.notes == ("decimal commas are read as points",)


@pytest.mark.parametrize(("groups", "names"), [((V,), "v_z"), ((Q,), "q_z"), ((Q, V), "v_z"), ((), "p_z")])
def test_without_a_header_the_number_of_columns_says_what_they_are(whole, reference, tmp_path, groups, names):
    read = read_reference(write(tmp_path / "bare.csv", some(whole, *groups), header=False), RACE)
    assert f", {names}" in read.notes[0]
    assert_same_flight(read.reference, reference)


def test_units_that_names_tell_are_turned_into_si_units_and_that_is_said(whole, reference, tmp_path):
    columns = {**whole, **{name: np.degrees(whole[name]) for name in W}, "t": 1e3 * whole["t"]}
    renamed = {**{f"{name} [deg/s]" if name in W else "t_ms" if name == "t" else name: values for name, values in columns.items()}}
    read = read_reference(write(tmp_path / "units.csv", renamed), RACE)
    assert_allclose(read.reference.table, reference.table, atol=1e-9)
    assert [note.partition(": ")[2] for note in read.notes] == ["t, w_x, w_y, w_z: read in ms, deg/s"]


@pytest.mark.parametrize(("unit", "said"), [("ft", "m, cm, mm"), ("deg", "m, cm, mm"), ("s", "m, cm, mm")])
def test_a_unit_that_nobody_knows_or_that_measures_something_else_is_refused(whole, tmp_path, unit, said):
    renamed = {(f"p_x [{unit}]" if name == "p_x" else name): values for name, values in whole.items()}
    with pytest.raises(InputError, match=rf"p_x \[{unit}\]: the unit {unit} is not known; p_x is in {said}"):
        read_reference(write(tmp_path / "units.csv", renamed), RACE)


def test_rows_that_are_there_twice_are_dropped_and_that_is_said(whole, reference, tmp_path):
    rows = np.sort(np.append(np.arange(len(whole["t"])), [20, 50]))
    read = read_reference(write(tmp_path / "twice.csv", {name: values[rows] for name, values in whole.items()}), RACE)
    assert_allclose(read.reference.table, reference.table, atol=1e-9)
    assert [note.partition(": ")[2] for note in read.notes] == ["2 rows that are there twice were dropped"]


def test_of_two_rows_that_differ_in_thrust_alone_the_later_one_holds(whole, reference, tmp_path):
    rows = np.sort(np.append(np.arange(len(whole["t"])), [50]))
    columns = {name: values[rows] for name, values in whole.items()}
    for name in U:
        columns[name] = np.where(np.arange(len(rows)) == 50, columns[name][49], columns[name])  # as it was until then
    found = read_reference(write(tmp_path / "twice.csv", columns), RACE).reference
    assert_allclose(found.thrust, reference.thrust, atol=1e-9)

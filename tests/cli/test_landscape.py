"""`hotlap landscape`, with real flights."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from hotlap.cli import main
from hotlap.planning.preparation import prepare
from hotlap.reference_files.csv import save_reference

SMALL = ["landscape", "circle-34", "--points", "4", "--flights", "2"]


def test_a_map_has_a_row_for_each_y_and_a_column_for_each_x(tmp_path, capsys):
    assert main([*SMALL, "--json", "--out", str(tmp_path / "map.png")]) == 0
    document = json.loads(capsys.readouterr().out)
    grid = np.array(document["completion"])
    assert grid.shape == (4, 4)
    assert ((grid >= 0) & (grid <= 1)).all()
    assert grid[0].mean() < grid[-1].mean()  # a short horizon flies nothing here
    assert (document["x_values"][0], document["x_values"][-1]) == pytest.approx((1, 1000))
    assert (document["y_values"][0], document["y_values"][-1]) == pytest.approx((1, 7))
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")


def test_the_other_parameters_are_held(capsys):
    maps = []
    for guess in ("default", "learned"):
        assert main([*SMALL, "--first-guess", guess, "--json"]) == 0
        maps.append(json.loads(capsys.readouterr().out)["completion"])
    assert maps[0] != maps[1]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--x", "Q_pos"], "--x: there is no parameter named 'Q_pos' (did you mean Q_pos_z?)"),
        (["--points", "1"], "--points: must be from 2 to 500, not 1"),
        (["--flights", "0"], "--flights: must be from 1 to 100, not 0"),
        (["--out", "map.bmp"], "map.bmp: must end with .png, .svg, .pdf"),
    ],
)
def test_what_cannot_be_mapped_is_said(arguments, complaint, capsys):
    assert main([*SMALL, *arguments]) == 2
    assert capsys.readouterr().err.splitlines()[-1].startswith(f"hotlap: {complaint}")


def test_a_reference_is_flown_in_place_of_the_plan(tmp_path, capsys):
    scenario = prepare("circle-34")
    kept = "t", "p_x", "p_y", "p_z", "v_x", "v_y", "v_z"
    save_reference(tmp_path / "plan.csv", scenario.reference)
    with (tmp_path / "plan.csv").open() as file:
        rows = [[row[name] for name in kept] for row in csv.DictReader(file)]
    (tmp_path / "less.csv").write_text("\n".join(map(",".join, [list(kept), *rows])))
    assert main([*SMALL, "--json"]) == 0
    planned = json.loads(capsys.readouterr().out)["completion"]
    assert main([*SMALL, "--reference", str(tmp_path / "less.csv"), "--json"]) == 0
    out, err = capsys.readouterr()
    document = json.loads(out)
    assert len(document["notes"]) == 3
    assert all(f"note: {note}\n" in err for note in document["notes"])
    assert np.abs(np.array(document["completion"]) - planned).max() < 0.3
    assert main([*SMALL, "--reference", "nowhere.csv"]) == 2
    assert capsys.readouterr().err == "hotlap: nowhere.csv: there is no such file\n"

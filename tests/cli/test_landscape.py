"""`hotlap landscape`, with real flights."""

from __future__ import annotations

import json

import numpy as np
import pytest

from hotlap.cli import main

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

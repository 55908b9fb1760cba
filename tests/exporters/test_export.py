"""What is written for other programs is what was tuned, and comes back from their files as it was."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from exporters.studies import VALUES, alternating, saved, tune
from flight.scenarios import make_scenario
from hotlap.core.errors import InputError, UnknownNameError
from hotlap.exporters import FORMATS, export
from hotlap.exporters.flown_with import flown_with
from hotlap.files.descriptions import load_parameters, save_parameters
from hotlap.files.parameters_file import SavedParameters
from hotlap.race.controllers import ControllerKind
from hotlap.reference.scenario import Scenario


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    with tune(tmp_path_factory.mktemp("study")) as opened:
        yield opened


def same(mine: SavedParameters, theirs: SavedParameters) -> bool:
    return mine.to_table() == theirs.to_table()


def remarked(scenario: Scenario) -> SavedParameters:
    return replace(saved(scenario), flown_with=flown_with(scenario))


@pytest.mark.check
@pytest.mark.parametrize("name", FORMATS)
def test_every_format_writes_its_own_file_into_the_folder_and_nothing_else(tmp_path, name):
    with tune(tmp_path) as opened:
        before = {path.name for path in tmp_path.iterdir()}
        files = export(opened, name)
    assert files[0] == tmp_path / FORMATS[name].file
    assert {path.name for path in tmp_path.iterdir()} == before | {path.name for path in files}


def test_toml_comes_back(study, tmp_path):
    (path,) = export(study, "toml", tmp_path / "mine.toml")
    assert same(load_parameters(path), remarked(study.configuration.scenario))


def test_json_comes_back_with_the_keys_of_the_parameters_file(study, tmp_path):
    (path,) = export(study, "json", tmp_path / "mine.json")
    assert same(SavedParameters.from_table(json.loads(path.read_text()), "mine.json"), remarked(study.configuration.scenario))


@pytest.mark.parametrize("segments", [None, alternating()], ids=["pieces", "shared"])
def test_csv_has_a_row_for_each_segment_bit_for_bit(tmp_path, segments):
    scenario = make_scenario() if segments is None else replace(make_scenario(), segments=segments)
    with tune(tmp_path / "study", scenario) as opened:
        (path,) = export(opened, "csv", tmp_path / "mine.csv")
    rows = list(csv.DictReader(path.read_text().splitlines()))
    np.testing.assert_array_equal([[float(row[name]) for name in scenario.space.names] for row in rows], VALUES)
    pieces = scenario.segments.pieces
    starts = [[piece.start for piece in pieces if piece.segment == i] for i in range(2)]
    assert [[float(start) for start in row["start"].split()] for row in rows] == starts
    assert [row["class"] for row in rows] == list(scenario.segments.segment_classes)


def test_an_unknown_format_is_refused_with_those_there_are(study):
    with pytest.raises(UnknownNameError, match="available: acados, agilicious, csv"):
        export(study, "xml")


@pytest.mark.parametrize("name", [name for name, chosen in FORMATS.items() if chosen.finished])
def test_a_study_that_has_not_ended_has_no_parameters_yet(tmp_path, name):
    with tune(tmp_path, save=False) as opened, pytest.raises(InputError, match="has not ended"):
        export(opened, name)


@pytest.mark.parametrize("name", ["rpg_mpc", "acados"])
def test_gains_are_not_sold_as_weights(tmp_path, name):
    race = make_scenario().race.with_controller(ControllerKind.GEOMETRIC)
    scenario = replace(make_scenario(), race=race)
    gains = SavedParameters(race.name, scenario.space.names, scenario.segments, scenario.space.first_guess(2))
    save_parameters(tmp_path / "parameters.toml", gains)
    with tune(tmp_path, scenario, fly=False, save=False) as opened:
        with pytest.raises(InputError, match="takes the weights of an MPC; tuned was the geometric controller"):
            export(opened, name)
        assert export(opened, "csv")

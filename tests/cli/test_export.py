"""`hotlap export`."""

from __future__ import annotations

import json

import pytest

from hotlap.exporters import FORMATS

TUNE = ("tune", "straight.toml", "--out", "study", "--validation", "20")


@pytest.mark.check
@pytest.mark.usefixtures("faked")
def test_a_tuned_study_is_written_in_every_format(hotlap, here):
    assert hotlap(*TUNE).code == 0
    for name in FORMATS:
        ran = hotlap("export", "study", "--format", name, "--out", f"out.{name}", "--json")
        assert (ran.code, ran.err) == (0, "")
        assert (ran.document["format"], ran.document["files"][0]) == (name, f"out.{name}")
        assert all((here / file).is_file() for file in ran.document["files"])
    assert hotlap("fly", "straight.toml", "--parameters", "out.toml", "--flights", "4").code == 0
    assert json.loads((here / "out.json").read_text())["race"] == "straight"


@pytest.mark.check
@pytest.mark.usefixtures("faked")
def test_it_says_what_was_written_and_what_it_is_for(hotlap):
    hotlap(*TUNE)
    ran = hotlap("export", "study", "--format", "optuna")
    assert ran.out == "wrote study/optuna.db: optuna-dashboard sqlite:///study/optuna.db\n"


@pytest.mark.usefixtures("faked")
def test_a_race_of_ones_own_is_not_called_by_a_name_that_flies_nothing(hotlap):
    hotlap(*TUNE)
    ran = hotlap("export", "study", "--format", "toml", "--out", "my file.toml")
    assert ran.out == "wrote my file.toml: hotlap fly RACE --parameters 'my file.toml'\n"


@pytest.mark.usefixtures("faked")
def test_parameters_that_were_not_confirmed_are_written_with_a_note(hotlap):
    assert hotlap(*TUNE, "--budget", "1", "--first-guess", "default").code == 1
    ran = hotlap("export", "study", "--format", "csv")
    assert ran.code == 0
    assert "were not confirmed" in ran.err


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("nowhere", "--format", "csv"), "nowhere: holds no study"),
        ((".", "--format", "xml"), "--format: there is no format named 'xml'; available: acados, agilicious, csv"),
        ((".",), "--format: is missing"),
        ((".", "--format", "csv", "--out", "missing/file.csv"), "missing/file.csv: cannot be written: there is no folder missing"),
    ],
)
def test_bad_input_is_one_line(hotlap, arguments, message):
    ran = hotlap("export", *arguments)
    assert (ran.code, ran.out, ran.err.count("\n")) == (2, "", 1)
    assert message in ran.err

"""What a page tells its reader to do works, and prints what the page says."""

from __future__ import annotations

import re

import pytest

from docs.pages import DOCS, program
from hotlap.worlds.betaflight import built
from hotlap.worlds.simulator import SimulatorError

transcript = program("transcript")
PAGES = ["index.md", "tutorial.md"]


try:
    built.firmware()
    MISSING = ""
except SimulatorError as error:
    MISSING = str(error)


@pytest.mark.check
@pytest.mark.parametrize("page", PAGES)
def test_a_page_can_be_followed_from_an_empty_folder(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (DOCS / page).read_text(encoding="utf-8")
    commands = 0
    for command, printed in transcript.perform(text):
        commands += 1
        assert transcript.outline(printed) == transcript.outline(command.printed), " ".join(command.words)
    assert commands


@pytest.mark.check
@pytest.mark.skipif(bool(MISSING), reason=MISSING or "the firmware is there")
def test_an_unknown_drone_is_identified_and_then_flies_its_laps(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shares = []
    for command, printed in transcript.perform((DOCS / "whole_circle.md").read_text(encoding="utf-8")):
        assert transcript.outline(printed) == transcript.outline(command.printed), " ".join(command.words)
        if "betaflight" in command.words:
            shares.append(float(re.search(r"all gates in +([\d.]+) %", printed)[1]))
    before, after = shares
    assert before < 30
    assert after > 90


def test_other_words_are_noticed_and_other_digits_are_not():
    assert transcript.outline("holds in  99 % of 200 flights [97, 100]\n") == transcript.outline("holds in 8.5 % of 50 flights [0, 1]")
    assert transcript.outline("confirmed in 3 flights") != transcript.outline("NOT confirmed in 3 flights")


def test_a_command_that_fails_is_noticed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(transcript.CommandError, match="exit status 2"):
        list(transcript.perform("```console\n$ hotlap check nowhere.toml\n```\n"))


@pytest.mark.parametrize("page", PAGES)
def test_what_check_says_fits_the_column_of_a_page(page):
    text = (DOCS / page).read_text(encoding="utf-8")
    checks = re.findall(r"^\$ hotlap check .*?(?=^\$|^```)", text, re.DOTALL | re.MULTILINE)
    assert checks or page != "tutorial.md"
    assert max((len(line) for check in checks for line in check.splitlines()), default=0) <= transcript.COLUMNS

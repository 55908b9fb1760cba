"""`hotlap compare`: tables and pictures of runs that are flown once."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cli import fake_hotlap
from hotlap.api import compared
from hotlap.files.descriptions import Kind, load_race, names

BOTH = "random_search,metropolis_hastings"
ASKED = f"compare straight.toml --tuners {BOTH} --seeds 3 --budget 40 --jobs 1 --out c".split()


@pytest.fixture(autouse=True)
def _faked(faked):
    pass


def test_it_prints_a_row_for_each_tuner_and_writes_the_table(hotlap, here):
    ran = hotlap(*ASKED)
    assert ran.code == 0
    assert ran.out.count("random_search:paper") == 3
    assert "confirmed %" in ran.out
    assert "6 of 6 runs" in ran.err
    assert (here / "c" / "table.md").read_text(encoding="utf-8").count("| metropolis_hastings:tied |") == 3
    assert len((here / "c" / "runs.jsonl").read_text(encoding="utf-8").splitlines()) == 6


def test_it_writes_a_page_that_needs_nothing_else(hotlap, here):
    ran = hotlap(*ASKED)
    assert "c/comparison.html\n" in ran.out
    page = (here / "c" / "comparison.html").read_text(encoding="utf-8")
    assert page.count("<td>random_search:paper</td>") + page.count(">random_search:paper</th>") == 3
    assert not re.search(r"(src|href)=\"(?!runs\.jsonl)", page)
    assert f"<code>hotlap {' '.join(ASKED)}</code>" in page
    assert hotlap(*ASKED, "--json").document["page"] == "c/comparison.html"


def test_the_document_has_what_is_promised(hotlap):
    document = hotlap(*ASKED, "--json").document
    assert {"races", "tuners", "budget", "rows", "overall"} <= set(document)
    row = document["rows"][0]
    promised = "race tuner runs success_rate validated_rate flights_median flights_quartiles completion_median lap_time_median"
    assert set(promised.split()) <= set(row)
    assert 0 <= row["success_rate"] <= 1
    assert row["runs"] == 3
    (pair,) = document["paired"]
    assert (pair["tuner"], pair["pairs"]) == (document["overall"][0]["tuner"], 3)
    assert set(pair["validated"]) == {"pairs", "value", "low", "high", "p"}


def test_one_tuner_alone_is_compared_with_nobody(hotlap):
    ran = hotlap(*ASKED, "--tuners", "random_search", "--json")
    assert ran.document["paired"] == []
    assert "against" not in hotlap(*ASKED, "--tuners", "random_search").out


def test_the_same_command_flies_nothing_and_more_seeds_fly_what_is_missing(hotlap):
    first = hotlap(*ASKED, "--json")
    again = hotlap(*ASKED, "--json")
    assert again.document == first.document
    assert "6 of 6 runs are there already" in again.err
    more = hotlap(*ASKED, "--seeds", "4", "--json")
    assert "6 of 8 runs are there already" in more.err
    assert [row["runs"] for row in more.document["rows"]] == [4, 4]


def test_another_rule_for_segments_is_another_comparison(hotlap):
    first = hotlap(*ASKED, "--json")
    other = hotlap(*ASKED, "--segments", "none", "--json")
    assert "are there already" not in other.err
    assert [row["runs"] for row in other.document["rows"]] == [3, 3]
    assert "6 of 6 runs are there already" in hotlap(*ASKED, "--segments", "none").err
    assert hotlap(*ASKED, "--segments", "paper", "--json").document == first.document


@pytest.mark.check
def test_another_reference_is_another_comparison_and_belongs_to_one_race(hotlap, here):
    planned = hotlap(*ASKED, "--json").document
    (here / "slow.csv").write_text("t,p_x,p_y,p_z\n" + "\n".join(f"{k / 100},{k / 100},0,1" for k in range(1001)))
    ran = hotlap(*ASKED, "--reference", "slow.csv", "--json")
    assert "reading slow.csv ...\n" in ran.err
    assert "note: slow.csv: velocities follow from the positions\n" in ran.err
    assert "are there already" not in ran.err
    assert ran.document["rows"] != planned["rows"]
    (here / "other.toml").write_text((here / "straight.toml").read_text().replace('name = "straight"', 'name = "other"', 1))
    refused = hotlap("compare", "straight.toml", "other.toml", *ASKED[2:], "--reference", "slow.csv")
    assert (refused.code, refused.err) == (2, "hotlap: --reference: belongs to one race; 2 are asked for\n")


def test_budgets_of_some_tuners(hotlap):
    asked = [*ASKED, "--budget", "30,metropolis_hastings=50", "--json"]
    assert hotlap(*asked).document["budget"] == {"random_search:paper": 30, "metropolis_hastings:tied": 50}


@pytest.mark.filterwarnings("default::hotlap.core.renamed.RenamedWarning")
def test_a_budget_by_a_tuners_name_of_before_counts(hotlap):
    asked = [
        "straight.toml",
        "--out",
        "kept",
        "--seeds",
        "1",
        "--tuners",
        "random_search,gate_gp",
        "--budget",
        "30,gatewise=20",
        "--jobs",
        "1",
        "--json",
    ]
    ran = hotlap("compare", *asked)
    assert ran.document["budget"] == {"random_search:paper": 30, "gate_gp:default": 20}


@pytest.mark.filterwarnings("default::hotlap.core.renamed.RenamedWarning")
def test_a_name_of_before_that_is_given_twice_is_said_once(hotlap):
    ran = hotlap("compare", "straight.toml", "--tuners", "gatewise", "--budget", "20,gatewise=15", "--seeds", "0", "--out", "kept")
    assert ran.err.count("gatewise is now called gate_gp") == 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--tuners", "annealing"], "there is no tuner named 'annealing'"),
        (["--budget", "many"], "--budget: must be like 200,cma_es=1000, not 'many'"),
        (["--budget", "200,mh=3"], "there is no tuner named 'mh'"),
        (["--budget", "0"], "--budget: must be from 1"),
        (["--seeds", "0"], "--seeds: must be from 1 to 100000, not 0"),
        (["--jobs", "-1"], "--jobs: must not be negative"),
        (["--out", "straight.toml"], "straight.toml: is a file, not the folder of a comparison"),
        (["--races", "lunar"], "--races: there is no set of races named 'lunar'"),
        (["--on", "mars"], "there is no world named 'mars'"),
    ],
)
def test_bad_input_is_one_line(hotlap, options, message):
    ran = hotlap(*ASKED, *options)
    assert ran.code == 2
    assert message in ran.err.splitlines()[-1]
    assert ran.out == ""


def test_races_that_a_table_could_not_tell_apart_are_refused(hotlap, here):
    race = (here / "straight.toml").read_text(encoding="utf-8")
    (here / "again.toml").write_text(race, encoding="utf-8")
    ran = hotlap("compare", "straight.toml", "again.toml", *ASKED[2:])
    assert ran.code == 2
    assert ran.err.splitlines()[-1].startswith("hotlap: straight.toml: name: 'straight' is the name of another race too")
    twice = hotlap("compare", "straight.toml", "straight.toml", *ASKED[2:], "--json")
    assert twice.document["races"] == ["straight"]


QUICKLY = ["--tuners", "random_search", "--seeds", "1", "--budget", "2", "--validation", "1", "--jobs", "1", "--json", "--out", "c"]


@pytest.fixture
def everywhere(monkeypatch, here):
    """Every race is the one that the fake world can fly, under its own name."""
    race = load_race(here / "straight.toml")
    monkeypatch.setattr(compared, "load", lambda name, _: race.model_copy(update={"name": str(name).removesuffix(".toml")}))


@pytest.mark.usefixtures("everywhere")
def test_patterns_and_sets_stand_for_races(hotlap):
    assert hotlap("compare", "circle-*", "drop-20", *QUICKLY).document["races"] == ["circle-20", "circle-34", "drop-20"]
    airsim = hotlap("compare", "circle-34", "--races", "airsim", *QUICKLY).document["races"]
    assert airsim[0] == "circle-34"
    assert len(airsim) == 1 + sum(name.startswith("airsim-") for name in names(Kind.RACE))
    assert hotlap("compare", "--races", "airsim", *QUICKLY).document["races"] == airsim[1:]
    assert hotlap("compare", "airsim", *QUICKLY).document["races"] == airsim[1:]


def test_a_pattern_that_matches_no_race_is_one_line(hotlap):
    ran = hotlap("compare", "circle-34", "circel-*", "--out", "c")
    assert (ran.code, ran.out) == (2, "")
    assert ran.err == "hotlap: circel-*: matches no built-in race; hotlap races lists them\n"


@pytest.mark.usefixtures("everywhere")
def test_the_command_on_the_page_does_the_same_again(hotlap, here):
    hotlap("compare", "straight.toml", "circle-*", "--races", "airsim", *QUICKLY)
    page = (here / "c" / "comparison.html").read_text(encoding="utf-8")
    assert "<code>hotlap compare straight.toml 'circle-*' airsim --tuners" in page


@pytest.mark.check
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_what_was_finished_outlives_a_kill(environment, here, number):
    command = [sys.executable, str(Path(fake_hotlap.__file__)), *ASKED, "--seeds", "30", "--tuners", "random_search"]
    slowly = {**environment, "FAKE_PAUSE": "0.05"}
    with subprocess.Popen(command, env=slowly, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        file, until = here / "c" / "runs.jsonl", time.monotonic() + 60
        while (not file.exists() or file.stat().st_size < 100) and time.monotonic() < until:
            time.sleep(0.02)
        os.kill(process.pid, number)
        _, said = process.communicate()
    whole = file.read_text(encoding="utf-8").rpartition("\n")[0].splitlines()
    assert all(json.loads(line) for line in whole)
    assert len(whole) >= 1
    if number == signal.SIGINT:
        assert process.returncode == 130
        assert "go on with: hotlap compare straight.toml" in said

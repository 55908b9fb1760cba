"""`--hold`: conditions of one's own, flown after a tuning, with given parameters, and for the results of a comparison."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np
import pytest

from cli import fake_hotlap
from cli.fake_hotlap import Loud
from fake_world import make_scenario
from hotlap import worlds
from hotlap.analysis.diagnosis import Diagnosis
from hotlap.api.flying import fly
from hotlap.api.tuning import tune
from hotlap.feasibility.causes import FailureCause
from hotlap.race.conditions import DEFAULT_CONDITIONS
from hotlap.study.study import Study

TUNE = ("tune", "straight.toml", "--seed", "1", "--validation", "20", "--out", "mine")
ASKED = "mass=+-20%, wind=3, noise=x2"
NAMES = ["20 % lighter", "20 % heavier", "steady push of 3 m/s^2 as of wind", "twice the noise"]
TRUE = make_scenario().race.vehicle.mass
LOST = 1e3  # times the parameters: nobody passes a gate


@dataclass
class Weighed(Loud):
    """A world in which no drone can fly that is more than 5 % too heavy, or in a steady wind."""

    takes_vehicle_parameters: bool = True

    def fly(self, scenario, parameters, seeds, *, vehicle_parameters=None, log=()):
        lost = np.full(len(seeds), scenario.race.noise.steady_wind > 0)
        if vehicle_parameters is not None:
            lost |= vehicle_parameters[:, 0] > 1.05 * TRUE
        return super().fly(scenario, np.where(lost[:, None, None], LOST * parameters, parameters), seeds, log=log)


@pytest.fixture(autouse=True)
def weighed(faked, monkeypatch):  # noqa: ARG001  first all the others
    monkeypatch.setattr(worlds, "build", lambda *_: Weighed(name="fake"))


def rates(rows) -> dict[str, float]:
    return {row["change"]: row["rate"] for row in rows}


def test_tune_flies_what_is_asked_for_first_and_says_whether_all_of_it_is_held(hotlap, here):
    ran = hotlap(*TUNE, "--hold", ASKED)
    assert ran.code == 0
    lines = ran.out.splitlines()
    rows = lines[lines.index("will it hold?") + 1 :]
    assert [row.strip().partition("  ")[0] for row in rows[:5]] == ["as tuned", *NAMES]
    assert "  2 of 4 conditions NOT held in 95 % of the flights: 20 % heavier, steady push of 3 m/s^2 as of wind" in rows
    assert f"--hold '{ASKED}'" in (here / "mine" / "report.html").read_text(encoding="utf-8"), "the command that does it again"
    document = hotlap(*TUNE, "--hold", ASKED, "--json").document
    assert [row["change"] for row in document["robustness"] if row["asked"]] == NAMES
    assert rates(document["robustness"])["20 % heavier"] == 0.0
    others = [condition.name for condition in DEFAULT_CONDITIONS if condition.name not in NAMES]
    assert [row["change"] for row in document["robustness"][5:]] == others
    assert document["holds"] is False
    assert hotlap(*TUNE, "--hold", "mass=-20%", "--json").document["holds"] is True


def test_what_to_try_is_one_list_in_the_terminal_in_json_and_on_the_page(hotlap, here, monkeypatch):
    blind = Diagnosis(FailureCause.UNKNOWN_FORCE, "it sinks", "set controller.offset_free = true")
    monkeypatch.setattr("hotlap.analysis.robustness.diagnose", lambda *_, **__: (blind,))
    lines = hotlap(*TUNE, "--hold", ASKED).out.splitlines()
    told = "set controller.offset_free = true (20 % heavier; steady push of 3 m/s^2 as of wind; 10 % heavier; 15 % less thrust)"
    assert lines[lines.index("why flights fail:") + 1 :][:3] == [
        "  20 % heavier, steady push of 3 m/s^2 as of wind, 10 % heavier, 15 % less thrust: unknown force: it sinks",
        "what to try:",
        f"  {told}",
    ]
    assert sum("offset_free" in line for line in lines) == 1
    assert hotlap(*TUNE, "--hold", ASKED, "--json").document["advice"] == [told]
    page = (here / "mine" / "report.html").read_text(encoding="utf-8")
    assert document_of(page)["advice"] == [told]
    assert f"<li>{told}</li>" in page, "also without JavaScript"


def document_of(page: str) -> dict:
    """What the script of a page reads."""
    (line,) = [line for line in page.splitlines() if 'id="study-data"' in line]
    return json.loads(line.partition('type="application/json">')[2].partition("</script>")[0])


def test_nobody_who_asks_for_nothing_reads_about_it(hotlap):
    assert "held in" not in hotlap(*TUNE).out
    document = hotlap(*TUNE, "--json").document
    assert document["holds"] is None
    assert not any(row["asked"] for row in document["robustness"])
    assert [row["change"] for row in document["robustness"]] == ["as tuned", *(condition.name for condition in DEFAULT_CONDITIONS)]


def test_a_study_remembers_what_was_asked_for_and_its_page_shows_it_again(hotlap, here):
    hotlap(*TUNE, "--hold", "wind=3")
    page = here / "mine" / "report.html"
    page.unlink()
    assert hotlap("report", "mine").code == 0
    shown = document_of(page.read_text(encoding="utf-8"))["robustness"]
    assert [row["change"] for row in shown if row["asked"]] == ["steady push of 3 m/s^2 as of wind"]
    again = hotlap(*TUNE, "--json").document
    assert [row["change"] for row in again["robustness"] if row["asked"]] == ["steady push of 3 m/s^2 as of wind"], (
        "gone on with without a word of it"
    )
    assert "--hold wind=3" in page.read_text(encoding="utf-8"), "the command that does it again"
    hotlap(*TUNE, "--hold", "gusts=1")
    with Study.read(here / "mine") as study:
        assert study.hold == "gusts=1"


def test_in_python_it_is_an_argument_of_the_call(here):
    tuned = tune(here / "straight.toml", seed=1, validation=20, out=here / "mine", hold="mass=-20%")
    assert [row.change for row in tuned.robustness if row.asked] == ["20 % lighter"]
    assert tuned.holds is True
    assert fly(here / "straight.toml", hold="mass=+20%", flights=5).holds is False


def test_what_is_asked_for_is_flown_without_a_validation_too(hotlap):
    asked = ("--validation", "0", "--json")
    assert hotlap(*TUNE, *asked).document["robustness"] == []
    assert hotlap(*TUNE[:-1], "other", *asked, "--hold", "wind=3").document["holds"] is False


def test_fly_adds_what_is_asked_for_and_nothing_else(hotlap):
    plain = hotlap("fly", "straight.toml", "--flights", "40", "--json").document
    assert (plain["robustness"], plain["holds"]) == ([], None)
    held = hotlap("fly", "straight.toml", "--flights", "40", "--json", "--hold", ASKED).document
    assert held["flights"] == plain["flights"]
    assert [row["change"] for row in held["robustness"]] == ["as tuned", *NAMES]
    assert {row["flights"] for row in held["robustness"]} == {40}
    complete = np.mean([flight["completion"] == 1 for flight in plain["flights"]])
    assert rates(held["robustness"])["as tuned"] == pytest.approx(complete)
    words = hotlap("fly", "straight.toml", "--flights", "40", "--hold", "wind=3 & mass=+10%").out
    assert "will it hold?\n  as tuned " in words
    assert "1 of 1 condition NOT held in 95 % of the flights: steady push of 3 m/s^2 as of wind and 10 % heavier\n" in words


def test_compare_has_a_table_of_what_each_tuner_holds(hotlap, here):
    few = ("--seeds", "2", "--budget", "40", "--jobs", "1", "--out", "c")
    asked = ("compare", "straight.toml", "--tuners", "random_search,metropolis_hastings", *few)
    plain = hotlap(*asked, "--json").document
    ran = hotlap(*asked, "--hold", ASKED)
    assert "race" in ran.out.partition("will it hold?\n")[2].splitlines()[0]
    assert ran.out.count("20 % heavier %") == 2, "race by race, and over all"
    assert "steady push of 3 m/s^2 as of wind %" in (here / "c" / "table.md").read_text(encoding="utf-8")
    assert "Will it hold?" in (here / "c" / "comparison.html").read_text(encoding="utf-8")
    document = hotlap(*asked, "--hold", ASKED, "--json").document
    for row, before in zip(document["rows"], plain["rows"], strict=True):
        assert [held["change"] for held in row["held"]] == ["as tuned", *NAMES]
        assert rates(row["held"])["20 % heavier"] == 0.0
        assert (row["flights_median"], before["held"]) == (before["flights_median"], []), "the runs are the same"
    assert "are there already" in hotlap(*asked, "--hold", ASKED).err


@pytest.mark.parametrize("command", [("tune",), ("fly",), ("compare", "--out", "c")])
@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("mass=10%", "'mass=10%': less or more? It must be like mass=+10%, -10% or +-10%"),
        ("thurst=-10%", "'thurst=-10%': there is no quantity 'thurst' (did you mean thrust?); available: mass, thrust, delay, drag, "),
        ("delay=-20ms", "'delay=-20ms': box has 0 ms, and dead time must stay between 0 and 250 ms"),
    ],
)
def test_what_cannot_be_flown_is_refused_on_one_line_before_anything_is_flown(hotlap, command, text, reason, here):
    name, *more = command
    ran = hotlap(name, "straight.toml", *more, "--hold", text)
    assert (ran.code, ran.out) == (2, "")
    assert ran.err.startswith(f"hotlap: --hold: {reason}")
    assert ran.err.count("\n") == 1
    assert not (here / "runs").exists()


def test_a_world_that_flies_the_vehicle_that_it_has_holds_nothing(hotlap, monkeypatch):
    monkeypatch.setattr(worlds, "build", fake_hotlap.build)
    ran = hotlap("tune", "straight.toml", "--hold", "mass=+10%")
    assert (ran.code, ran.err) == (2, "hotlap: --hold: fake flies the vehicle that it has\n")


@pytest.mark.parametrize("command", ["tune", "fly", "compare"])
def test_help_shows_what_may_be_asked_for(hotlap, command):
    ran = hotlap(command, "--help")
    assert ran.code == 0
    assert "mass=+-10%, thrust=-20%, delay=+20ms" in " ".join(ran.out.split())

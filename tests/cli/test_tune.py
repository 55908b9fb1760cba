"""`hotlap tune`, end to end in a world that takes no time."""

from __future__ import annotations

import re
import shlex
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from fake_world import make_scenario
from first_guess.small import DEFAULT, GOOD, make_race, make_set
from hotlap.cli import main
from hotlap.core.version import __version__
from hotlap.files.descriptions import load_parameters, save
from hotlap.first_guess.training_set import write_training_set
from hotlap.study.database import FILE
from hotlap.study.study import Study

PROGRAM = [sys.executable, str(Path(__file__).parent / "fake_hotlap.py")]
EASY = ("tune", "straight.toml", "--seed", "1", "--validation", "50")
HARD = ("tune", "straight.toml", "--goal", "mean_error<0.01", "--budget", "30", "--validation", "20")
KEYS = {
    "race",
    "tuner",
    "seed",
    "flights",
    "search_flights",
    "completion",
    "confirmed",
    "validation",
    "lap_time",
    "cost",
    "wall_time",
    "study",
}

pytestmark = pytest.mark.usefixtures("faked")


def content(folder: Path) -> list:
    """All that a run decides, as SQLite has it."""
    connection = sqlite3.connect(folder / FILE)
    flights = connection.execute("SELECT * FROM flight ORDER BY stream, number").fetchall()
    entries = connection.execute("SELECT * FROM entry WHERE key != 'wall_time' ORDER BY key").fetchall()
    connection.close()
    return [flights, entries]


def test_a_confirmed_goal_is_success_and_says_everything(hotlap, here):
    ran = hotlap(*EASY)
    assert ran.code == 0
    (folder,) = (here / "runs").iterdir()
    study = folder.relative_to(here)
    assert ran.out.startswith("straight: completion=1 confirmed\n")
    assert re.search(r"holds in +\S+ % of 50 flights \[\d+, \d+\]\n", ran.out)
    for line in (
        f"study           {study}\n",
        f"parameters      {study}/parameters.toml\n",
        f"report          {study}/report.html\n",
    ):
        assert line in ran.out
    assert ran.out.endswith(f"fly it again: hotlap fly straight.toml --parameters {study}\n")
    assert ran.err.splitlines()[:2] == ["planning straight ...", "compiling the flight core (once, about half a minute) ..."]
    assert re.fullmatch(r"\d+ of 200 flights, best so far: completion 100 %, cost \S+, confirmed, \S+ flights/s", ran.err.splitlines()[-2])
    assert ran.err.splitlines()[-1] == "writing the report ..."


def test_json_is_one_document_with_the_keys_that_are_relied_on(hotlap):
    ran = hotlap(*EASY, "--out", "mine", "--json")
    assert ran.code == 0
    assert set(ran.document) >= KEYS
    assert set(ran.document["validation"]) == {"flights", "successes", "rate", "low", "high"}
    assert 0 < ran.document["validation"]["low"] < ran.document["validation"]["rate"] <= 1
    assert (ran.document["race"], ran.document["study"], ran.document["goal"], ran.document["confirmed"]) == (
        "straight",
        "mine",
        "completion=1",
        True,
    )


def test_a_goal_that_is_not_confirmed_is_exit_1_and_the_best_is_kept(hotlap, here):
    ran = hotlap(*HARD, "--out", "mine")
    assert ran.code == 1
    assert ran.out.startswith("straight: mean_error<0.01 NOT confirmed in 30 flights; the most reliable of what was found is kept\n")
    with Study.read(here / "mine") as study:
        assert study.result is not None
        best = study.result.best
    np.testing.assert_array_equal(load_parameters(here / "mine").values, best.parameters)
    ran = hotlap(*HARD, "--out", "mine", "--json")
    assert (ran.code, ran.document["confirmed"], ran.document["flights"]) == (1, False, 30)


@pytest.mark.check
def test_after_a_failure_with_a_reference_the_advice_is_about_that_reference(hotlap, here):
    rows = [f"{k / 100},{20 * min(k / 100, 0.5) ** 2 + 20 * max(k / 100 - 0.5, 0)},0,1" for k in range(101)]  # 40 m/s^2 to 20 m/s
    (here / "fast.csv").write_text("t,p_x,p_y,p_z\n" + "\n".join(rows))
    ran = hotlap(*HARD, "--out", "mine", "--reference", "fast.csv", "--validation", "0")
    assert ran.code == 1
    assert "of the vehicle's thrust: no tuner will help; fly it slower\n" in ran.out
    assert ran.out.endswith("what may be in the way: hotlap check straight.toml --reference fast.csv\n")
    document = hotlap(*HARD, "--out", "mine", "--reference", "fast.csv", "--validation", "0", "--json").document
    assert "no tuner will help" in document["advice"][0]
    assert document["notes"][0] == "fast.csv: velocities follow from the positions"
    cut = hotlap(*HARD, "--out", "cut", "--segments", "none")
    assert cut.out.endswith("what may be in the way: hotlap check straight.toml --segments none\n")
    plain = hotlap(*HARD, "--out", "plain")
    assert "no tuner will help" not in plain.out
    assert plain.out.endswith("what may be in the way: hotlap check straight.toml\n")


def test_no_goal_is_nothing_to_fail_at(hotlap):
    ran = hotlap("tune", "straight.toml", "--goal", "none", "--budget", "20")
    assert ran.code == 0
    assert ran.out.startswith("straight: budget of 20 flights spent, no goal was set\n")


def test_parameters_say_where_they_come_from(hotlap, here):
    hotlap(*EASY, "--out", "mine")
    provenance = load_parameters(here / "mine").provenance
    assert provenance["hotlap"] == __version__
    assert re.fullmatch("[0-9a-f]{16}", str(provenance["study"]))
    assert (provenance["tuner"], provenance["goal"], provenance["seed"]) == ("gate_gp:default", "completion=1", 1)
    assert (provenance["confirmed"], provenance["validation_flights"]) == (True, 50)
    assert provenance["validated_low"] <= provenance["validated_rate"] <= provenance["validated_high"]


def test_a_finished_study_says_the_same_again(hotlap):
    first, again = (hotlap(*EASY, "--out", "mine", "--json") for _ in range(2))
    assert {**first.document, "wall_time": 0} == {**again.document, "wall_time": 0}
    assert "mine: going on after" in again.err


def test_no_validation(hotlap):
    ran = hotlap("tune", "straight.toml", "--validation", "0", "--json")
    assert ran.document["validation"] is None
    assert "validat" not in ran.err


@pytest.mark.parametrize(
    ("change", "key"),
    [
        (("--seed", "2"), "seed"),
        (("--tuner", "random_search"), "tuner.name"),
        (("--goal", "none"), "goal"),
        (("--batch", "1"), "batch"),
        (("--validation", "60"), "validation"),
    ],
)
def test_another_configuration_is_refused_and_nothing_changes(hotlap, here, change, key):
    hotlap(*EASY, "--out", "mine")
    before = content(here / "mine")
    ran = hotlap(*EASY, *change, "--out", "mine")
    assert (ran.code, ran.out) == (2, "")
    assert ran.err.splitlines()[-1].startswith(f"hotlap: mine: {key}: this study has ")
    assert content(here / "mine") == before


def test_a_larger_budget_goes_on(hotlap):
    assert hotlap(*HARD, "--out", "mine").code == 1
    ran = hotlap(*HARD, "--budget", "60", "--out", "mine", "--json")
    assert ran.document["flights"] == 60
    assert hotlap(*HARD, "--out", "mine").err.endswith("may be given more, not 30\n")


def test_a_first_guess_is_where_the_search_begins(hotlap, here):
    hotlap(*EASY, "--out", "first")
    hotlap(*EASY, "--goal", "none", "--budget", "1", "--first-guess", "first", "--out", "second")
    with Study.read(here / "second") as study:
        np.testing.assert_array_equal(study.flights().parameters[0], load_parameters(here / "first").values)


def first_flown(folder):
    with Study.read(folder) as study:
        return study.flights().parameters[0]


@pytest.mark.parametrize("name", ["learned", "paper", "default"])
def test_a_first_guess_has_a_name(hotlap, here, name):
    hotlap("tune", "straight.toml", "--goal", "none", "--budget", "1", "--first-guess", name, "--out", "named")
    np.testing.assert_allclose(first_flown(here / "named"), [GOOD if name == "paper" else DEFAULT] * 2, rtol=1e-9)


def test_a_first_guess_is_learnt_from_a_file(hotlap, here):
    (here / "mine.json").write_text(write_training_set(make_set(make_race("a", "080"))), encoding="utf-8")
    ran = hotlap("tune", "straight.toml", "--goal", "none", "--budget", "1", "--first-guess", "mine.json", "--out", "mine", "--json")
    np.testing.assert_array_equal(first_flown(here / "mine"), [GOOD] * 2)
    assert ran.document["first_guess"] == "mine.json"


def test_what_was_learnt_about_another_controller_is_no_guess(hotlap, here):
    foreign = make_set(make_race("a", "080"), names=("a", "b", "c", "d", "e"))
    (here / "foreign.json").write_text(write_training_set(foreign), encoding="utf-8")
    ran = hotlap("tune", "straight.toml", "--first-guess", "foreign.json", "--goal", "none", "--budget", "1", "--out", "other")
    assert "note: nothing was learnt about the controller mpc; the first guess is its default" in ran.err.splitlines()
    np.testing.assert_array_equal(first_flown(here / "other"), [DEFAULT] * 2)


def test_a_race_that_cannot_be_planned_is_exit_1(hotlap, monkeypatch):
    from hotlap.core.errors import PlanningError  # noqa: PLC0415

    def fail(*_, **__):
        raise PlanningError("straight", "gate 3", "the gate lies below the floor")

    monkeypatch.setattr("hotlap.planning.preparation.plan", fail)
    ran = hotlap(*EASY, "--json")
    assert ran.code == 1
    assert ran.document["error"]["reason"] == "no plan for straight, gate 3: the gate lies below the floor"
    assert ran.err.endswith("hotlap: no plan for straight, gate 3: the gate lies below the floor\n")


def test_one_file_is_written_to_look_at(hotlap, here):
    ran = hotlap(*EASY, "--out", "mine", "--json")
    assert "pictures" not in ran.document
    assert {path.name for path in (here / "mine").iterdir()} - {"study.lock"} == {FILE, "parameters.toml", "report.html"}


def test_a_bar_on_a_terminal_and_words_stay_off_standard_output(hotlap, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    ran = hotlap(*EASY, "--json")
    assert ran.code == 0
    assert ran.document["confirmed"]
    assert "confirmed" in ran.err
    assert "\x1b[" in ran.err


def start(arguments, environment, pause="0.02"):
    return subprocess.Popen(
        [*PROGRAM, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**environment, "FAKE_PAUSE": pause},
    )


def wait_for_flights(process, count):
    assert process.stderr is not None
    seen = []
    while seen.count("flying\n") < count:
        line = process.stderr.readline()
        assert line, seen
        seen.append(line)


@pytest.mark.check
def test_killed_in_the_middle_the_same_command_ends_as_if_never_stopped(hotlap, here, environment):
    command = (*HARD, "--out", "mine", "--json")
    for flights in (2, 5, 9):
        process = start(command, environment)
        wait_for_flights(process, flights)
        process.kill()
        assert process.communicate()[0] == ""
        assert process.returncode == -signal.SIGKILL
    process = start(command, environment, "0")
    out, err = process.communicate()
    assert process.returncode == 1, err
    whole = hotlap(*HARD, "--out", "whole", "--json")
    assert content(here / "mine") == content(here / "whole")
    assert (here / "mine" / "parameters.toml").read_bytes() == (here / "whole" / "parameters.toml").read_bytes()
    ours, theirs = ({**ran, "wall_time": 0} for ran in (type(whole)(1, out, err).document, whole.document))
    paths = dict.fromkeys(("study", "parameters", "report"))
    assert {**ours, **paths} == {**theirs, **paths}


@pytest.mark.check
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_stopped_it_says_how_to_go_on_and_going_on_ends_as_if_never_stopped(here, environment, capsys, number, code):
    process = start(HARD, environment)
    wait_for_flights(process, 4)
    process.send_signal(number)
    out, err = process.communicate()
    assert (process.returncode, out) == (code, "")
    last = [line for line in err.splitlines() if line != "flying"]
    assert len(last) == 1, err
    said, _, command = last[0].partition("go on with: ")
    assert said == "hotlap: interrupted; nothing is lost; "
    program, *arguments = shlex.split(command)
    assert (program, arguments[: len(HARD)], arguments[-2]) == ("hotlap", list(HARD), "--out")
    assert main(arguments) == 1
    assert "going on after" in capsys.readouterr().err
    assert main([*HARD, "--out", "whole"]) == 1
    assert content(here / arguments[-1]) == content(here / "whole")


def test_a_study_that_was_stopped_before_anything_was_in_it_is_begun(hotlap, here):
    (here / "mine").mkdir()
    (here / "mine" / FILE).touch()
    assert hotlap("tune", "straight.toml", "--seed", "1", "--out", "mine").code == 0


def test_an_interrupted_study_has_no_parameters_yet_and_says_so(hotlap, environment):
    process = start((*HARD, "--out", "mine"), environment)
    wait_for_flights(process, 3)
    process.kill()
    process.communicate()
    ran = hotlap("fly", "straight.toml", "--parameters", "mine")
    assert ran.code == 2
    assert "hotlap: mine: holds a study that has not ended" in ran.err


def test_two_at_once_on_one_study_are_refused(hotlap, here, environment):
    process = start((*HARD, "--out", "mine"), environment, "0.2")
    wait_for_flights(process, 1)
    ran = hotlap(*HARD, "--out", "mine")
    process.kill()
    process.communicate()
    assert (ran.code, ran.out) == (2, "")
    assert f"process {process.pid} is working on this study" in ran.err
    assert here.exists()


def test_names_that_a_shell_would_take_apart_come_back_whole(hotlap, here):
    save(here / "my race.toml", make_scenario().race)
    ran = hotlap("tune", "my race.toml", "--seed", "1", "--out", "my study")
    assert ran.out.endswith("fly it again: hotlap fly 'my race.toml' --parameters 'my study'\n")


@pytest.mark.parametrize(("rule", "count"), [("none", 1), ("equal_time", 2)])
def test_a_race_is_tuned_and_flown_by_the_rule_that_is_asked_for(hotlap, here, rule, count):
    ran = hotlap(*EASY, "--segments", rule, "--out", "mine")
    assert ran.out.endswith(f"fly it again: hotlap fly straight.toml --parameters mine --segments {rule}\n")
    assert len(load_parameters(here / "mine").values) == count
    flown = hotlap(*shlex.split(ran.out.splitlines()[-1].partition("hotlap ")[2]), "--flights", "5")
    assert (flown.code, "note: mine" in flown.err) == (0, False), flown.err
    other = hotlap(*EASY, "--out", "mine")
    assert other.code == 2
    assert "mine: segments." in other.err
    assert hotlap(*EASY, "--segments", rule, "--out", "mine").code == 0


def test_parameters_of_another_rule_are_refused_or_remarked_upon(hotlap):
    hotlap(*EASY, "--segments", "equal_time", "--out", "halves")
    hotlap(*EASY, "--segments", "none", "--out", "whole")
    assert "tuned for segments flat, flat, used for flat, ascent" in hotlap("fly", "straight.toml", "--parameters", "halves").err
    ran = hotlap("fly", "straight.toml", "--parameters", "whole")
    assert ran.code == 2
    assert "there are 1, tuned for straight; straight has 2, and parameters belong to the segments of one reference, cut by" in ran.err


def test_a_tuner_may_have_something_to_say(hotlap):
    ran = hotlap("tune", "straight.toml", "--tuner", "safe_bayesian", "--goal", "none", "--budget", "12", "--json")
    assert "of 12 flights below the floor" in ran.document["remark"]
    assert hotlap(*EASY, "--json").document["remark"] == ""


@pytest.mark.parametrize("command", [("tune", "straight.toml"), ("compare", "straight.toml", "--out", "c")])
def test_a_world_that_flies_what_it_has_cannot_be_randomised(hotlap, command):
    ran = hotlap(*command, "--randomise", "0.1")
    assert ran.code == 2
    assert ran.err.splitlines()[-1] == "hotlap: --randomise: fake flies the vehicle that it has"

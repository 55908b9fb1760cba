"""Bad input: one line that says where, what and why; exit 2; nothing on standard output."""

from __future__ import annotations

import subprocess
import sys

import pytest

from fake_world import make_scenario
from hotlap.core.printable import printable
from hotlap.files.descriptions import save_parameters
from hotlap.files.parameters_file import SavedParameters
from written_parameters import parameters, segment

PARAMETERS, SECOND = parameters(segment("flat", "0.0", "2.5")), segment("flat", "2.5", "5.0")

FILES = {
    "broken.toml": "name = [",
    "typo.toml": 'track = "circle"\nvehicle = "hummingbird"\n[noise]\nthrsut = 0.1\n',
    "unknown.toml": 'track = "cirlce"\nvehicle = "hummingbird"\n',
    "negative.toml": 'base = "hummingbird"\nmass = -1\n',
    "nothing.toml": "",
    "binary.toml": b"\xff\xfe\0\1",
    "one-segment.toml": PARAMETERS,
    "names.toml": (PARAMETERS + SECOND).replace("horizon", "patience"),
    "bounds.toml": (PARAMETERS + SECOND).replace("Q_attitude = 50", "Q_attitude = 5000"),
    "gap.toml": PARAMETERS + SECOND.replace("start = 2.5", "start = 3.5"),
    "reference.csv": "t,p_x\n0,0\n",
    "a file\nof two lines.toml": "name = [",
    "planing.toml": 'track = "circle"\nvehicle = "hummingbird"\n[planing]\nv_max = 10\n',
    "milliseconds.toml": 'base = "hummingbird"\ndelay = 45\n',
    "motors.toml": 'base = "hummingbird"\nmotor_time = [25, 35]\n',
    "within.toml": 'track = "circle"\nvehicle = { base = "hummingbird", delay = 45 }\n',
    "percent.toml": 'track = "circle"\nvehicle = "hummingbird"\nplanning = { thrust_share = 70 }\n',
    "degrees.toml": "start = [0, 0, 1]\ngates = [{ position = [5, 0, 1], yaw = 90 }]\n",
    "degrees-a-second.toml": 'base = "hummingbird"\nrate_limit = [600, 600, 200]\n',
    "controller.toml": 'track = "circle"\nvehicle = "hummingbird"\ncontroller = { rates = [600, 600, 200] }\n',
    "outside.toml": 'track = "circle"\nvehicle = "hummingbird"\nv_max = 10\n',
    "arm.toml": 'track = "circle"\nvehicle = "hummingbird"\narm = 0.2\n',
    "far.toml": 'track = "gatse.toml"\nvehicle = "hummingbird"\n',
    "gates.toml": "start = [0, 0, 1]\ngates = [[5, 0, 1]]\n",
    "gates.yaml": "gates:\n  - 1\n",
    "learnt.json": '{"races": []}',
}

CASES = {
    "tnue circle-34": "there is no command named 'tnue' (did you mean tune?); available: bench, cache, check",
    "--json races": "--json: is no option of hotlap; options of a command follow its name",
    "--nonsense": "--nonsense: is no option of hotlap",
    "bench circle-34": "circle-34: is one argument too many; see hotlap bench --help",
    "tune": "RACE: is missing; see hotlap tune --help",
    "new track": "NAME: is missing",
    "new": "KIND, NAME: is missing",
    "tune circle-34 --bugdet 5": "--bugdet: is no option of hotlap tune (did you mean --budget?)",
    "tune circle-34 --bud 5": "--bud: is no option of hotlap tune",
    "tune circle-34 -x": "-x: is no option of hotlap tune",
    "tune circle-34 --budget": "--budget: needs a value",
    "tune circle-34 --budget many": "--budget: must be a whole number, not 'many'",
    "tune circle-34 --budget 1.5": "--budget: must be a whole number, not '1.5'",
    "tune circle-34 --budget 0": "--budget: must be from 1 to",
    "tune circle-34 --seed -1": "--seed: must be from 0 to",
    "tune circle-34 --batch 0": "--batch: must be from 1",
    "tune circle-34 --confirm -1": "--confirm: must be from 0",
    "tune circle-34 --samples -1": "--samples: must be from 0",
    "tune circle-34 --randomise 0.95": "--randomise: must be from 0 to 0.9",
    "tune circle-34 --randomise -0.1": "--randomise: must be a fraction",
    "tune circle-34 --validation -1": "--validation: must be from 0",
    "tune circle-34 --json=yes": "--json: ignored explicit argument 'yes'",
    "tune circle-34 --goal fast": "--goal: 'fast' is no goal; write completion=1",
    "tune circle-34 --goal completion=7": "--goal: a completion is a fraction above 0 and at most 1, not 7",
    "tune circle-34 --goal mean_error=1": "--goal: mean_error= makes no sense",
    "tune circle-34 --tuner anealing": "--tuner: there is no tuner named 'anealing'",
    "tune circle-34 --tuner random_search:papr": "--tuner: there is no preset of random_search named 'papr' (did you mean paper?)",
    "tune circle-34 --on mars": "--on: there is no world named 'mars'; available: built-in",
    "tune cirlce-34": "there is no race named 'cirlce-34' (did you mean circle-34?); available: ",
    "tune missing.toml": "missing.toml: there is no such file",
    "tune broken.toml": "broken.toml: is not valid TOML: ",
    "tune typo.toml": "typo.toml: noise.thrsut: ",
    "tune unknown.toml": "unknown.toml: track: there is no track named 'cirlce' (did you mean circle?)",
    "tune straight.toml --out straight.toml": "straight.toml: is a file, not the folder of a study",
    "tune straight.toml --out straight.toml/below": "straight.toml/below: cannot be used as the folder of a study",
    "tune straight.toml --reference missing.csv": "missing.csv: there is no such file",
    "tune straight.toml --reference .": ".: is a folder, not a file",
    "tune straight.toml --reference reference.csv": "reference.csv: ",
    "tune straight.toml --first-guess missing.toml": "missing.toml: there is no such file",
    "tune straight.toml --first-guess missing.json": "missing.json: there is no such file",
    "tune straight.toml --first-guess lerned": "--first-guess: there is no first guess named 'lerned' (did you mean learned?); available: ",
    "fly straight.toml --first-guess missing.json": "missing.json: there is no such file",
    "compare straight.toml --out c --first-guess lerned": "--first-guess: there is no first guess named 'lerned' (did you mean learned?)",
    "learn straight.toml": "--out: is missing",
    "learn missing.toml --out l": "missing.toml: there is no such file",
    "learn straight.toml --out straight.toml": "straight.toml: is a file, not the folder of what is learnt",
    "learn straight.toml --out l --jobs -1": "--jobs: must not be negative, not -1",
    "tune straight.toml --first-guess broken.toml": "broken.toml: is not valid TOML",
    "tune straight.toml --first-guess one-segment.toml": "one-segment.toml: segment: there are 1, tuned for straight; straight has 2",
    "fly straight.toml --parameters missing": "missing: there is no such file",
    "fly straight.toml --parameters one-segment.toml": "one-segment.toml: segment: there are 1",
    "fly straight.toml --parameters names.toml": "names.toml: names: are Q_pos_xy, Q_pos_z, Q_attitude, Q_velocity, patience; the",
    "fly straight.toml --parameters bounds.toml": "bounds.toml: segment[0].Q_attitude: 5000 is not within [1, 100]",
    "fly straight.toml --parameters gap.toml": "gap.toml: segment[1].start: must be 2.5",
    "fly straight.toml --parameters cache": "cache/parameters.toml: there is no such file",
    "fly straight.toml --flights 0": "--flights: must be from 1 to 100000, not 0",
    "fly straight.toml --seed 99999999999": "--seed: must be from 0 to 2147483647",
    "fly straight.toml --log nowhere/log.csv": "nowhere/log.csv: cannot be written: there is no folder nowhere",
    "plan straight.toml --out .": ".: is a folder, not a file to write",
    "plan straight.toml --out nowhere/plan.csv": "nowhere/plan.csv: cannot be written: there is no folder nowhere",
    "plan straight.toml --picture plan.txt": "plan.txt: must end with .png, .svg, .pdf",
    "plan straight.toml --segments papre": "--segments: there is no segmentation rule named 'papre' (did you mean paper?); available: ",
    "tune straight.toml --segments 1m": "--segments: there is no segmentation rule named '1m'; available: equal_time, none, ",
    "fly straight.toml --segments=": "--segments: there is no segmentation rule named ''",
    "compare straight.toml --out c --segments all": "--segments: there is no segmentation rule named 'all'",
    "plan straight.toml --out=": "--out: must be a path, not ''",
    "check missing.toml": "missing.toml: there is no such file",
    "check negative.toml": "negative.toml: mass: ",
    "check nothing.toml": "nothing.toml: is neither a race",
    "check binary.toml": "binary.toml: is not UTF-8 text",
    "check hummingbrid": "there is no race, track or quadrotor named 'hummingbrid' (did you mean hummingbird?)",
    "check ./": ".: is a folder, not a file",
    "check a file\nof two lines.toml": "a file\\nof two lines.toml: is not valid TOML",
    "new boat mine": "KIND: there is no kind of file named 'boat'; available: quadrotor, race, track",
    "new race mine --track nowhere": "there is no track named 'nowhere'",
    "new race mine --vehicle straight.toml": "straight.toml: describes a race, not a quadrotor",
    "new track mine --track circle": "--track: is of a race, not of a track",
    "tune negative.toml --budget 5": "negative.toml: describes a quadrotor, not a race; a race names its track and its vehicle",
    "new track straight": "straight.toml: exists already and is left as it is",
    "new track nowhere/mine": "nowhere/mine.toml: cannot be written",
    "new track .toml": "NAME: must be a name",
    "new track ": "NAME: must be a name",
    "check planing.toml": "planing.toml: planing: there is no such key (did you mean planning?)",
    "check milliseconds.toml": "milliseconds.toml: delay: must be at most 0.25, not 45 (in seconds: 0.045?)",
    "check motors.toml": "motors.toml: motor_time: 35 s is no motor; motor_time is in seconds (did you mean [0.025, 0.035]?)",
    "check within.toml": "within.toml: vehicle.delay: must be at most 0.25, not 45 (in seconds: 0.045?)",
    "check percent.toml": "percent.toml: planning.thrust_share: must be at most 1, not 70 (as a fraction: 0.7?)",
    "check degrees.toml": "degrees.toml: gates[0].yaw: 90 rad is more than a full turn; angles are in radians (did you mean 1.571?)",
    "check degrees-a-second.toml": "degrees-a-second.toml: rate_limit: 600 rad/s is no body rate of a drone (in radians a second: [10",
    "tune controller.toml": "controller.toml: controller.rates: 600 rad/s is no body rate of a drone (in radians a second: [10.47, 10.47,",
    "check outside.toml": "outside.toml: v_max: there is no such key (it belongs into planning); available: ",
    "check arm.toml": "arm.toml: arm: there is no such key (it belongs into vehicle or model); available: ",
    "check far.toml": "far.toml: track: there is no file gatse.toml (did you mean gates.toml?)",
    "tune typos.toml": "typos.toml: there is no such file (did you mean typo.toml?)",
    "tune circle-34.toml": "circle-34.toml: there is no such file (circle-34 is built in: leave the ending away)",
    "tune circle-34 --randomise 30": "--randomise: must be a fraction from 0 to 1, not '30' (did you mean 0.3?)",
    "tune circle-34 --randomise 30%": "--randomise: must be a fraction from 0 to 1, not '30%' (did you mean 0.3?)",
    "tune reference.csv": "reference.csv: is a table of numbers, no TOML: a reference is given beside its race, with --reference",
    "check reference.csv": "reference.csv: is a table of numbers, no TOML: a reference is given beside its race, with --reference",
    "tune missing.csv": "missing.csv: there is no such file",
    "tune gates.yaml": "gates.yaml: is a file of another program: hotlap import reads it",
    "tune learnt.json": "learnt.json: is JSON, no TOML: what was learnt is given beside a race, with --first-guess",
    "tune one-segment.toml": "one-segment.toml: holds tuned parameters: give the race that they are for, and this file with --parameters",
    "check one-segment.toml": "one-segment.toml: holds tuned parameters: give the race that they are for",
    "tune cache": "cache: is a folder, not a file",
    "tune study": "study: is the folder of a study, not a file: give the race, and this folder with --parameters",
    "fly straight.toml --parameters typo.toml": "typo.toml: describes a race, and holds no parameters",
    "fly straight.toml --parameters reference.csv": "reference.csv: is a table of numbers, no TOML",
    "fly straight.toml --reference typo.toml": "typo.toml: is TOML, and no reference",
}


def test_who_mistypes_a_goal_is_told_of_the_fastest_plan_where_it_can_be_asked_for(hotlap):
    assert hotlap("tune", "straight.toml", "--goal", "laptime").err.endswith("or none; lap_time looks for the fastest plan\n")
    assert "lap_time" not in hotlap("compare", "straight.toml", "--out", "c", "--goal", "fast").err


@pytest.fixture
def mistakes(here):
    for name, content in FILES.items():
        (here / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    (here / "cache").mkdir()
    (here / "study").mkdir()
    (here / "study" / "parameters.toml").write_text(PARAMETERS)


@pytest.mark.usefixtures("faked", "mistakes")
@pytest.mark.parametrize("as_json", [False, True], ids=["text", "json"])
@pytest.mark.parametrize("line", CASES)
def test_bad_input_is_one_clear_line(hotlap, line, as_json):
    if as_json and line.startswith("-"):
        pytest.skip("no command")
    words = line.split(" ", 1) if "\n" in line else line.split(" ")  # the name of a file may have blanks in it
    ran = hotlap(*words, *(["--json"] if as_json else []))
    assert ran.code == 2, ran
    if "--json" not in words and not as_json:
        assert ran.out == ""
    else:
        told = ran.document["error"]
        parts = (told["file"] or told["option"] or "", told["key"] or "", told["reason"])
        assert printable(": ".join(part for part in parts if part)) == ran.err.splitlines()[-1].removeprefix("hotlap: ")
        assert told["status"] == 2
    last = ran.err.splitlines()[-1]
    assert last.startswith(f"hotlap: {CASES[line]}"), ran.err
    assert all(said.endswith(" ...") for said in ran.err.splitlines()[:-1]), ran.err  # what it was at
    assert "Traceback" not in ran.err


@pytest.mark.usefixtures("mistakes")
def test_an_error_as_json_names_file_key_and_reason(hotlap):
    ran = hotlap("check", "milliseconds.toml", "--json")
    reason = "must be at most 0.25, not 45 (in seconds: 0.045?)"
    assert ran.document == {"error": {"file": "milliseconds.toml", "option": None, "key": "delay", "reason": reason, "status": 2}}
    told = hotlap("tune", "circle-34", "--segments", "papre", "--json").document["error"]
    assert (told["file"], told["option"]) == (None, "--segments")
    assert hotlap("check", "hummingbrid", "--json").document["error"]["available"]


@pytest.mark.parametrize("line", ["tnue circle-34", "tune circle-34 --budget many", "check missing.toml", "new boat mine"])
def test_the_same_from_a_shell(here, environment, line):
    ran = subprocess.run(
        [sys.executable, "-m", "hotlap", *line.split()], capture_output=True, text=True, check=False, cwd=here, env=environment
    )
    assert (ran.returncode, ran.stdout) == (2, "")
    assert ran.stderr.startswith(f"hotlap: {CASES[line]}")
    assert ran.stderr.count("\n") == 1


def test_an_argument_that_is_no_text_is_one_line_too(here, environment):
    ran = subprocess.run(
        [sys.executable, "-m", "hotlap", "check", b"\xff.toml"], capture_output=True, check=False, cwd=here, env=environment
    )
    assert (ran.returncode, ran.stdout) == (2, b"")
    assert ran.stderr == b"hotlap: \\udcff.toml: there is no such file\n"


@pytest.mark.usefixtures("faked", "mistakes")
def test_bad_input_leaves_no_folder_behind(hotlap, here):
    before = sorted(here.rglob("*"))
    for line in ("tune straight.toml --goal fast", "tune straight.toml --first-guess one-segment.toml", "tune straight.toml --on mars"):
        assert hotlap(*line.split()).code == 2
    assert sorted(here.rglob("*")) == before


@pytest.mark.usefixtures("faked")
def test_parameters_of_a_race_with_the_same_segments_are_flown_with_a_note(hotlap, here):
    scenario = make_scenario()
    saved = SavedParameters("another", scenario.space.names, scenario.segments, scenario.space.first_guess(2))
    save_parameters(here / "other.toml", saved)
    ran = hotlap("fly", "straight.toml", "--parameters", "other.toml", "--flights", "3")
    assert ran.code == 0
    assert "note: other.toml: tuned for another, used for straight\n" in ran.err

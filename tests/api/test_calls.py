"""One call for each command: it does the same, says nothing, and returns what can be looked at."""

from __future__ import annotations

import json
import sys
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

import hotlap
from cli.fake_hotlap import MODULES, Loud
from hotlap.api import first_flights, tuned
from hotlap.api.asked import command_line
from hotlap.api.first_flights import Doom
from hotlap.api.given import hold_text
from hotlap.cli import main
from hotlap.cli.output import finite
from hotlap.cli.words import as_command
from hotlap.core.errors import InputError, UnknownNameError
from hotlap.files.descriptions import load_parameters, load_race
from hotlap.race.hold import parse_hold
from hotlap.race.schema import Described
from hotlap.study.study import Study

SLOTS = ("tuned", "planned", "flown", "compared", "exported")
COMPARED = {"tuners": "random_search", "seeds": 2, "budget": 12, "validation": 5, "jobs": 1}
COMMANDS = {
    "tuned": ["tune", "straight.toml", "--seed", "1", "--validation", "20", "--out", "line"],
    "planned": ["plan", "straight.toml", "--out", "plan.csv"],
    "flown": ["fly", "straight.toml", "--flights", "5", "--seed", "3"],
    "compared": ["compare", "straight.toml", "--tuners", "random_search", "--seeds", "2", "--budget", "12"]
    + ["--validation", "5", "--jobs", "1", "--out", "c"],
    "exported": ["export", "mine", "--format", "json"],
}


@pytest.fixture
def results(here, capsys):
    """Of each call; nothing was printed."""
    assert here.is_dir()
    found = {
        "tuned": hotlap.tune("straight.toml", seed=1, validation=20, out="mine"),
        "planned": hotlap.plan("straight.toml", out="plan.csv"),
        "flown": hotlap.fly("straight.toml", flights=5, seed=3),
        "compared": hotlap.compare("straight.toml", out="c", **COMPARED),
        "exported": hotlap.export("mine", "json"),
    }
    assert tuple(capsys.readouterr()) == ("", "")
    return found


def as_printed(document):
    return json.loads(json.dumps(finite(document)))


def test_a_result_has_the_document_that_the_command_prints(results, capsys):
    for name, command in COMMANDS.items():
        assert main([*command, "--json"]) == 0
        printed, mine = json.loads(capsys.readouterr().out), as_printed(results[name].to_dict())
        differing = {key for key in {**printed, **mine} if printed.get(key) != mine.get(key)}
        assert differing <= {"wall_time", "study", "parameters", "report"}, name


def handed_out(one, depth=2):
    """All that a result hands out, and what that hands out in turn."""
    for name in () if isinstance(one, Described) else dir(one):
        if name.startswith("_") or callable(value := getattr(one, name)):
            continue
        if isinstance(value, tuple | list) or type(value).__module__.startswith("hotlap."):
            yield f"{type(one).__name__}.{name}", value
            yield from handed_out(value, depth - 1) if depth else ()


def test_a_result_is_one_or_two_lines_and_a_table_in_notebooks(results):
    for result in results.values():
        text = repr(result)
        assert text.startswith(f"<{type(result).__name__} ")
        assert len(text) < 400
        assert text.count("\n") <= 1
        assert result._repr_html_().startswith("<table>")
        assert len(result._repr_html_()) < 400
    assert "completion=1 confirmed" in repr(results["tuned"])
    assert '<a href="mine/report.html">' in results["tuned"]._repr_html_()


def test_all_that_a_result_hands_out_is_short_too(results):
    for result in [*results.values(), hotlap.check("straight.toml"), hotlap.load_race("straight.toml"), hotlap.Study("mine")]:
        long = {name: len(repr(value)) for name, value in handed_out(result) if len(repr(value)) >= 400}
        assert not long
        tables = {name: value._repr_html_() for name, value in handed_out(result) if hasattr(value, "_repr_html_")}
        assert not {name for name, table in tables.items() if len(table) >= 400}


def test_a_short_form_stays_short_in_a_deep_folder(here):
    out = here / "/".join(["a-folder-with-a-long-name"] * 9)
    tuned = hotlap.tune("straight.toml", seed=1, validation=20, out=out)
    study = hotlap.Study(out)
    for one in (tuned, study):
        assert len(repr(one)) < 400
        assert len(one._repr_html_()) < 400
    study.close()
    assert "closed" in repr(study)


def test_lists_of_results_are_frames(results):
    held = hotlap.fly("straight.toml", flights=5, seed=3)
    frames = {
        "runs": results["compared"].runs,
        "tuners on races": results["compared"].by_race,
        "tuners": results["compared"].overall,
        "flights": held.flights,
        "scores": held.scores,
        "reference": results["planned"].reference,
        "study": hotlap.Study("mine"),
        "ledger": hotlap.Study("mine").flights(),
    }
    pytest.importorskip("pandas")
    for name, value in frames.items():
        frame = value.to_frame()
        assert len(frame) == len(value.records()) > 0, name
        assert not frame.columns.duplicated().any()
    assert frames["study"].to_frame()["parameters"][0].shape == results["tuned"].values.shape


def test_what_stands_in_a_table_is_no_markup(here):
    race = load_race("straight.toml").model_copy(update={"name": "<b>"})
    assert here.is_dir()
    assert "&lt;b&gt;" in hotlap.plan(race)._repr_html_()


def test_a_result_is_a_frame_where_there_is_pandas_and_says_so_where_there_is_none(results, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    for result in results.values():
        with pytest.raises(InputError, match="needs pandas: pip install pandas"):
            result.to_frame()
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=lambda rows: rows))
    frames = {name: result.to_frame() for name, result in results.items()}
    with Study.read("mine") as study:
        assert [row["seed"] for row in frames["tuned"]] == study.flights().seeds.tolist()
    assert len(frames["flown"]) == 5
    assert [row["seed"] for row in frames["compared"]] == [0, 1]
    assert frames["planned"][-1]["t"] == pytest.approx(results["planned"].reference.duration)
    assert frames["exported"][0]["file"] == "mine/parameters.json"


def test_a_result_can_be_drawn(results, monkeypatch):
    monkeypatch.setitem(MODULES, "hotlap.report.comparison", None)
    monkeypatch.delitem(sys.modules, "hotlap.report.comparison")
    assert all(isinstance(results[name].plot(), Figure) for name in ("tuned", "planned", "compared"))


def test_a_tuning_can_be_exported_as_its_study_can(here):
    assert here.is_dir()
    tuned = hotlap.tune("straight.toml", seed=1, validation=20, out="mine")
    exported = tuned.export("json", out="out.json")
    assert [file.name for file in exported.files] == ["out.json"]
    assert exported.rows() == hotlap.export("mine", "json", out="out.json").rows()


@pytest.mark.parametrize("hold", ["mass=+-10%, wind=3", ["mass=+-10%", "wind=3"], {"mass": "+-10%", "wind": 3}])
def test_conditions_are_a_text_a_list_or_a_dict(hold):
    assert hold_text(hold) == "mass=+-10%, wind=3"
    assert len(parse_hold(hold_text(hold))) == 3


def test_paths_are_where_the_files_are(results):
    tuned, compared = results["tuned"], results["compared"]
    files = [tuned.parameters, tuned.report, compared.table, compared.page, *results["exported"].files]
    assert all(file.is_file() for file in files)
    np.testing.assert_array_equal(load_parameters(tuned.folder).values, tuned.values)


def test_the_same_call_goes_on(here):
    assert here.is_dir()
    asked = {"goal": "mean_error<0.01", "validation": 5, "out": "mine"}
    first, more = (hotlap.tune("straight.toml", budget=budget, **asked) for budget in (10, 20))
    assert (first.result.flights, more.result.flights, more.confirmed) == (10, 20, False)


def test_a_race_may_be_a_name_a_path_or_a_race(here):
    path = here / "straight.toml"
    flown = [hotlap.fly(race, flights=4).scores.cost.tolist() for race in ("straight.toml", path, load_race(path))]
    assert flown[0] == flown[1] == flown[2]
    assert hotlap.tune(load_race(path), validation=0, out="mine").again == ""
    with Study.read("mine") as study:
        assert study.command == ""


def test_parameters_may_be_numbers(results):
    values = results["tuned"].values
    from_file, given = (hotlap.fly("straight.toml", parameters=what, flights=6).scores.cost for what in ("mine", values))
    np.testing.assert_array_equal(from_file, given)
    same = hotlap.fly("straight.toml", parameters=values[0], flights=6).parameters
    np.testing.assert_array_equal(same, [values[0]] * 2)
    with pytest.raises(InputError, match=r"^parameters: must have shape \(2, 5\) or \(5,\), not \(3,\)"):
        hotlap.fly("straight.toml", parameters=values[0, :3])


@pytest.mark.parametrize(
    ("call", "given", "said"),
    [
        (hotlap.tune, {"budget": 0}, "budget: must be from 1 to"),
        (hotlap.tune, {"budget": "many"}, "budget: must be a whole number, not 'many'"),
        (hotlap.tune, {"budget": 20.5}, "budget: must be a whole number, not 20.5"),
        (hotlap.tune, {"budget": True}, "budget: must be a whole number, not True"),
        (hotlap.tune, {"goal": 1}, "goal: must be text, not 1"),
        (hotlap.tune, {"reliability": None}, "reliability: must be a number, not None"),
        (hotlap.tune, {"out": 3}, "out: must be text, a path or None, not 3"),
        (hotlap.tune, {"hold": {"mas": "+5%"}}, "hold: 'mas=+5%': there is no quantity 'mas' (did you mean mass?)"),
        (hotlap.fly, {"hold": 3}, "hold: must be text, a list or a dict, not 3"),
        (hotlap.fly, {"parameters": hotlap}, "parameters: must be text, a path, an array or None, not a module"),
        (hotlap.tune, {"goal": "fast"}, "goal: 'fast' is no goal; write completion=1"),
        (hotlap.tune, {"goal": "lap_time", "samples": 3}, "samples: has no meaning for the goal lap_time, which looks for a plan"),
        (hotlap.tune, {"goal": "lap_time", "validation": 0}, "validation: must not be 0 for the goal lap_time"),
        (hotlap.tune, {"goal": "lap_time", "hold": "mas=+5%"}, "hold: "),
        (hotlap.tune, {"tuner": "anealing"}, "tuner: there is no tuner named 'anealing'"),
        (hotlap.tune, {"on": "mars"}, "on: there is no world named 'mars'"),
        (hotlap.tune, {"randomise": 0.1}, "randomise: fake flies the vehicle that it has"),
        (hotlap.tune, {"first_guess": "lerned"}, "first_guess: there is no first guess named 'lerned'"),
        (hotlap.plan, {"segments": "papre"}, "segments: there is no segmentation rule named 'papre' (did you mean paper?)"),
        (hotlap.fly, {"controller": "pid"}, "controller: there is no controller named 'pid'; available: geometric"),
        (hotlap.fly, {"flights": 0}, "flights: must be from 1 to 100000, not 0"),
        (hotlap.compare, {"out": "c", "jobs": -1}, "jobs: must not be negative, not -1"),
        (hotlap.compare, {"out": "c", "first_guess": "best"}, "first_guess: there is no first guess named 'best'"),
    ],
)
def test_what_is_not_usable_is_said_by_the_name_of_the_argument(here, call, given, said):
    assert here.is_dir()
    with pytest.raises(InputError) as error:
        call("straight.toml", **given)
    assert str(error.value).startswith(said)


def test_an_unknown_format_is_said_likewise(results):
    assert results
    with pytest.raises(UnknownNameError, match=r"^format: there is no format named 'xml'; available: acados"):
        hotlap.export("mine", "xml")


class Stop(BaseException):
    pass


class Stopping:
    """A progress that stops the work at the first batch or run."""

    def note(self, *_):
        pass

    def working(self, *_):
        return nullcontext()

    def pieces(self, *_):
        return nullcontext(self.stop)

    def flights(self, *_):
        return nullcontext(self.stop)

    def stop(self, _):
        raise Stop


class Listening(Stopping):
    """The same, and keeps what it was told."""

    def __init__(self):
        self.notes = []

    def note(self, text):
        self.notes.append(text)


def test_a_tuning_says_before_it_begins_what_no_weights_make_up_for(here, monkeypatch):
    doomed, straight = Listening(), load_race(here / "straight.toml")
    monkeypatch.setattr(tuned, "BuiltIn", Loud)
    monkeypatch.setattr(first_flights, "find_doom", lambda *_: Doom(at_once=True, crashed=True, words="64 hit the floor before gate 1"))
    tight = straight.model_copy(update={"judge": straight.judge.model_copy(update={"distance": 0.1})})
    with pytest.raises(Stop):
        hotlap.tune(tight, out="mine", progress=doomed)
    loose, hopeless = doomed.notes
    assert loose.startswith("note: the plan may pass a gate at 0.2 m, where 0.1 m count")
    assert hopeless.startswith("note: no weights help as it stands: of 64 weights drawn at random none passes gate 1 (64 hit the floor")


def test_what_is_interrupted_says_how_to_go_on(here):
    assert here.is_dir()
    with pytest.raises(Stop) as stopped:
        hotlap.tune("straight.toml", seed=1, progress=Stopping())
    (note,) = stopped.value.__notes__
    assert note.startswith("nothing is lost; go on with: hotlap.tune('straight.toml', seed=1, out='runs/straight-")
    with pytest.raises(Stop) as stopped:
        hotlap.tune(load_race("straight.toml"), out="mine", progress=Stopping())
    assert stopped.value.__notes__ == ["nothing is lost; go on with: the same call, out='mine'"]
    with pytest.raises(Stop) as stopped:
        hotlap.compare(["straight.toml"], out="c", progress=Stopping(), **COMPARED)
    (note,) = stopped.value.__notes__
    assert note.startswith("nothing is lost; go on with: hotlap.compare(['straight.toml'], tuners='random_search', seeds=2, budget=")
    assert as_command(note) == f"nothing is lost; go on with: hotlap {' '.join(COMMANDS['compared'])}"


@pytest.mark.parametrize(
    ("given", "command"),
    [
        ({"race": "a.toml"}, "hotlap tune a.toml"),
        ({"race": "my race.toml", "seed": 1, "first_guess": "default"}, "hotlap tune 'my race.toml' --seed 1 --first-guess default"),
        ({"race": "a.toml", "out": "x", "budget": 300}, "hotlap tune a.toml --budget 300 --out x"),
    ],
)
def test_the_command_of_a_call_has_what_differs_from_the_defaults(given, command):
    assert command_line(hotlap.tune, given) == command


@pytest.mark.parametrize(("window", "words"), [((1.5, 9.0), "--from 1.5 --to 9"), ((None, 9.0), "--to 9"), ((0.0, None), "--from 0")])
def test_the_command_of_a_window_has_an_option_for_each_side(window, words):
    given = {"log": "a.csv", "race": "a.toml", "window": window}
    assert command_line(hotlap.score, given) == f"hotlap score a.csv --race a.toml {words}"

"""Options are read from the calls of `hotlap.api`: defaults cannot disagree, and help says them."""

from __future__ import annotations

import inspect
from pathlib import Path

import pytest

import hotlap
from hotlap.api.asked import Asked, command_line
from hotlap.cli import arguments, options
from hotlap.cli.arguments import COMMANDS
from hotlap.cli.options import arguments_of, meanings_of
from hotlap.core.errors import InputError
from hotlap.exporters.formats import FORMATS
from hotlap.tuning.goal import parse_goal
from hotlap.tuning.goal_forms import FORMS

CALLS = {"tune": hotlap.tune, "plan": hotlap.plan, "fly": hotlap.fly, "compare": hotlap.compare, "export": hotlap.export, "lap": hotlap.lap}
REQUIRED = {
    "compare": ["circle-34", "--out", "c"],
    "export": ["study", "--format", "json"],
    "lap": ["circle-34", "--parameters", "study", "--on", "mavlink:udpin:127.0.0.1:14540"],
}
EACH = pytest.mark.parametrize("name", CALLS)


@EACH
def test_every_default_is_that_of_the_call(name):
    parsed = COMMANDS[name].parser(name).parse(REQUIRED.get(name, ["circle-34"]))
    asked = arguments_of(CALLS[name], parsed)
    parameters = inspect.signature(CALLS[name]).parameters
    assert set(asked) == set(parameters) - {"progress"}
    for key, parameter in parameters.items():
        if key != "progress" and parameter.default is not parameter.empty:
            assert (key, asked[key]) == (key, parameter.default)


@EACH
def test_every_option_is_an_argument_of_the_call_and_says_its_default(name):
    taken, meanings = COMMANDS[name].parser(name).arguments, meanings_of(CALLS[name])
    for action in taken:
        if action.dest in {"help", "json", "verbose", "log_file", "suite"}:  # the last one stands for races
            continue
        parameter = inspect.signature(CALLS[name]).parameters[action.dest]
        assert meanings[action.dest]
        if parameter.default is not False and parameter.default not in {parameter.empty, None, True}:
            shown = meanings[action.dest].partition(f"; {parameter.default!r}: ")[2] or format(parameter.default, "")
            assert f"(default: {shown.removesuffix('.0')})" in (action.help or "")


def test_no_default_in_a_help_is_typed():
    for module in (arguments, options, *map(inspect.getmodule, CALLS.values())):
        assert module is not None
        assert "(default: " not in Path(str(module.__file__)).read_text(encoding="utf-8")


def test_goals_in_the_help_are_goals():
    *some, last = FORMS.replace(" or ", ", ").split(", ")
    assert [str(parse_goal(text)) for text in (*some, last)] == [text.replace("1.0", "1") for text in (*some, last)]


def test_formats_are_in_the_help():
    helped = COMMANDS["export"].parser("export").format_help()
    assert all(name in helped for name in FORMATS)


def test_an_argument_may_begin_a_line_of_its_own_or_go_on():
    def call(*, much=3):
        """Do it.

        Args:
            much: how
                much; 3: as much as there is; in Python also none.
        """
        return Asked(call, locals())

    assert meanings_of(call) == {"much": "how much; 3: as much as there is"}
    assert call().command() == "hotlap call"
    assert call(much=4).command() == "hotlap call --much 4"


def test_what_has_no_name_on_the_command_line_has_no_command():
    assert command_line(hotlap.fly, {"race": "circle-34", "parameters": object()}) == ""


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("tune", "RACE: is missing; see hotlap tune --help"),
        ("compare", "RACE, --out: is missing; see hotlap compare --help"),
        ("compare --out c", "RACE: is missing; see hotlap compare --help"),
        ("compare --races airsim", "--out: is missing; see hotlap compare --help"),
        ("compare --races lunar --out c", "--races: there is no set of races named 'lunar'; available: airsim, all, default, real"),
        ("export study", "--format: is missing; see hotlap export --help"),
        ("tune a b", "b: is one argument too many; see hotlap tune --help"),
        ("tune a -x", "-x: is no option of hotlap tune; see hotlap tune --help"),
        ("tune a --no-json", "--no-json: is no option of hotlap tune (did you mean --json?); see hotlap tune --help"),
        ("tune a --budget", "--budget: needs a value"),
        ("tune a --budget --json", "--budget: needs a value"),
        ("tune a --budget 1e2", "--budget: must be a whole number, not '1e2'"),
        ("tune a --reliability 90%", "--reliability: must be a fraction from 0 to 1, not '90%' (did you mean 0.9?)"),
        ("tune a --json=1", "--json: ignored explicit argument '1'"),
        ("plan a --cache", "--cache: is no option of hotlap plan (did you mean --no-cache?); see hotlap plan --help"),
    ],
)
def test_mistakes_are_one_clause_by_the_name_of_the_argument(line, said):
    name, *words = line.split()
    parser = COMMANDS[name].parser(name)
    for _ in range(2):  # nothing of a mistake stays
        with pytest.raises(InputError) as error:
            parser.parse(words)
        assert str(error.value) == said


@pytest.mark.filterwarnings("default::hotlap.core.renamed.RenamedWarning")
def test_a_renamed_option_works_and_one_line_says_the_new_name(hotlap):
    ran = hotlap("tune", "missing.toml", "--worlds", "2")
    assert ran.err == "hotlap: warning: --worlds is now called --samples\nhotlap: missing.toml: there is no such file\n"
    parsed = COMMANDS["tune"].parser("tune")
    with pytest.warns(match="--worlds is now called --samples"):
        assert parsed.parse(["a", "--worlds", "2"]).samples == 2  # pyright: ignore[reportOptionalMemberAccess]


def test_an_error_about_an_argument_names_the_option_and_any_other_stays():
    parser = COMMANDS["tune"].parser("tune")
    assert str(parser.as_option(InputError("", "first_guess", "no"))) == "--first-guess: no"
    for error in (InputError("race.toml", "budget", "no"), InputError("", "mass", "no"), InputError("", "race", "no")):
        assert parser.as_option(error) is error

"""What a message calls a function of Python, the prompt calls a command."""

from __future__ import annotations

import pytest

from hotlap.cli.words import as_command


@pytest.mark.parametrize(
    ("said", "typed"),
    [
        ("go on with: hotlap.tune(RACE, out='runs/a (b), c') now", "go on with: hotlap tune RACE --out 'runs/a (b), c' now"),
        ("hotlap.fly('a.toml', first_guess='default', seed=3)", "hotlap fly a.toml --first-guess default --seed 3"),
        ("hotlap.compare(['a', 'b'], tuners=['x', 'y'], out='c')", "hotlap compare a b --tuners x,y --out c"),
        ("hotlap.plan(RACE).plot() draws a race", "hotlap plan RACE.plot() draws a race"),
        ("two: hotlap.plan('a'), hotlap.check('b')", "two: hotlap plan a, hotlap check b"),
        ("hotlap.tune(", "hotlap.tune("),
        ("hotlap.tune is a function (of many)", "hotlap.tune is a function (of many)"),
        ("budget: must be from 1 to 3, not 0", "budget: must be from 1 to 3, not 0"),
    ],
)
def test_calls_become_commands(said, typed):
    assert as_command(said) == typed

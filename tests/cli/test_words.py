"""What a message calls a function of Python, the prompt calls a command."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import hotlap
from hotlap.cli.shells.words import commands
from hotlap.cli.words import as_command

SOURCE = Path(hotlap.__file__).parent
PROMPTS = ("cli", "reproduce")  # what is typed at a prompt, and pages about it
OPTIONS = {option for command in commands() for one in command.options for option in one.options if option.startswith("--")}
COMMENT = "; flown by: hotlap fly RACE --parameters THIS_FILE"  # in a file: what one types


@pytest.mark.parametrize(
    ("said", "typed"),
    [
        ("go on with: hotlap.tune(RACE, out='runs/a (b), c') now", "go on with: hotlap tune RACE --out 'runs/a (b), c' now"),
        ("hotlap.fly('a.toml', first_guess='default', seed=3)", "hotlap fly a.toml --first-guess default --seed 3"),
        ("hotlap.compare(['a', 'b'], tuners=['x', 'y'], out='c')", "hotlap compare a b --tuners x,y --out c"),
        ("hotlap.plan(RACE).plot() draws a race", "hotlap plan RACE.plot() draws a race"),
        ("two: hotlap.plan('a'), hotlap.check('b')", "two: hotlap plan a, hotlap check b"),
        ("a reference is given with reference=...", "a reference is given with --reference"),
        ("chosen by 100 flights (selection=...), with first_guess=...: a", "chosen by 100 flights (--selection), with --first-guess: a"),
        ("hotlap.tune() chooses it", "hotlap tune chooses it"),
        ("hotlap.tune(", "hotlap.tune("),
        ("hotlap.tune is a function (of many)", "hotlap.tune is a function (of many)"),
        ("budget: must be from 1 to 3, not 0", "budget: must be from 1 to 3, not 0"),
    ],
)
def test_calls_become_commands(said, typed):
    assert as_command(said) == typed


def test_no_message_outside_of_the_command_line_names_an_option():
    named = [
        f"{path.relative_to(SOURCE)}:{line}: {text}"
        for path in sorted(SOURCE.rglob("*.py"))
        if path.relative_to(SOURCE).parts[0] not in PROMPTS
        for line, text in messages(ast.parse(path.read_text(encoding="utf-8")))
        if " " in text and OPTIONS & set(re.findall(r"--[a-z-]+", text)) and COMMENT not in text
    ]
    assert named == []


def messages(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """All texts of a module that are no docstrings, with their lines."""
    texts = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in texts:
            yield node.lineno, node.value

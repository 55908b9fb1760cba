"""What the documentation makes of docstrings, parsers and tables."""

from __future__ import annotations

from enum import Enum

import pytest

from docs.pages import program
from hotlap.cli.arguments import COMMANDS
from hotlap.race.quadrotor import Quadrotor

nodes = pytest.importorskip("docutils.nodes", reason="make docs installs it")
commands, docstrings, interface, mathematics, pairs = (
    program(f"extensions/{name}") for name in ("commands", "docstrings", "interface", "mathematics", "pairs")
)


def read(text, described=None):
    lines = text.split("\n")
    docstrings.prepare(None, "", "", described, None, lines)
    return "\n".join(lines)


def test_a_bar_is_a_bar_a_star_a_product_and_a_backtick_code():
    assert read("|v| is a * b, not `c`s.") == "\\|v\\| is a \\* b, not ``c``\\ s.\n"


def test_indented_lines_are_literal():
    assert read("In short:\n\n    |x| = 1\n\nand so on") == "In short:\n\n::\n\n    |x| = 1\n\nand so on\n"


def test_a_list_is_set_off_and_its_items_go_on():
    assert read("Two:\n- one\n  more\n- two") == "Two:\n\n- one\n  more\n- two\n"
    assert read("1. one\n   more\n2. two") == "1. one\n   more\n2. two\n"


def test_members_of_an_enumeration_are_a_list():
    kind = Enum("kind", ["A", "B"])
    assert read("Which.\n\nA: one\n    thing.\nB: another.", kind) == "Which.\n\n- ``A``: one\n  thing.\n- ``B``: another.\n"


def test_attributes_are_a_list_and_arguments_are_left_to_sphinx():
    text = read("What.\n\nArgs:\n    a: one.\n\nAttributes:\n    low, high: bounds,\n        of all.")
    assert "Args:\n    a: one." in text
    assert ":Attributes:\n\n    - **low, high**: bounds,\n          of all." in text


def test_lines_that_are_indented_below_prose_stay_lines():
    assert read("Conventions\n    x ahead.\n    |y| left.") == "Conventions\n\n| x ahead.\n| \\|y\\| left.\n"


def test_what_stands_before_a_colon_is_no_type():
    lines = ["Gates: shape (M, 3)."]
    docstrings.prepare(None, "property", "", None, None, lines)
    assert ":" not in lines[0]
    docstrings.restore_colons(None, "property", "", None, None, lines)
    assert lines == ["Gates: shape (M, 3).", ""]


def test_a_signature_has_arrays_as_they_are_written_and_descriptions_have_none():
    array = "ndarray[tuple[Any, ...], dtype[float64]]"
    assert docstrings.shorten(None, "", "", read, None, f"(a: {array})", array) == ("(a: NDArray[float64])", "NDArray[float64]")
    assert docstrings.shorten(None, "", "", Quadrotor, None, "(mass: float)", None) == ("", None)


def test_pairs_of_numbers_are_tied_in_tables_only():
    source = ["| 100 [84, 99] / 3 | - / - |\n100 / 3"]
    pairs.keep(None, "", source)
    assert source == ["| 100 [84,\u00a099]\u00a0/\u00a03 | -\u00a0/\u00a0- |\n100 / 3"]


def test_every_public_name_has_a_row_that_leads_to_its_module():
    rows = interface.names()
    assert "`load_race <hotlap.files.descriptions.load_race>`" in rows
    assert "| A built-in race by name" in rows


def test_a_package_stands_for_its_modules_and_none_comes_twice():
    expanded = interface.expanded("hotlap.worlds.world hotlap.worlds.")
    assert expanded[:2] == ["hotlap.worlds.world", "hotlap.worlds"]
    assert len(expanded) == len(set(expanded))


def test_a_formula_that_is_not_understood_is_a_warning(monkeypatch):
    assert "<mfrac>" in mathematics.mathml(nodes.math("", "\\frac{a}{b}"), "inline")
    told = []
    monkeypatch.setattr(mathematics.logger, "warning", lambda *words, **_: told.append(words))
    mathematics.mathml(nodes.math("", "\\nonsense{a} & b"), "inline")
    assert told


def test_an_option_stays_on_its_line():
    section = commands.section("tune", COMMANDS["tune"])
    usage = section.split("```")[1]
    assert all(len(line) <= commands.WIDTH for line in usage.splitlines())
    assert all(line.count("[") == line.count("]") for line in usage.splitlines())

"""Help is as wide as the terminal."""

from __future__ import annotations

import pytest

from hotlap.cli.arguments import COMMANDS


@pytest.mark.parametrize("columns", [60, 100, 160])
def test_help_keeps_within_the_terminal(hotlap, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    for line in [[], *([name] for name in COMMANDS)]:
        text = hotlap(*line, "--help").out.partition("\nexamples:")[0]
        assert max(map(len, text.splitlines())) <= columns, line


def test_a_wider_terminal_has_fewer_lines(hotlap, monkeypatch):
    heights = []
    for columns in (60, 100, 160):
        monkeypatch.setenv("COLUMNS", str(columns))
        heights.append(len(hotlap("tune", "--help").out.splitlines()))
    assert heights == sorted(set(heights), reverse=True)


def test_examples_are_not_broken(hotlap, monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    out = hotlap("compare", "--help").out
    assert all(f"  {example}\n" in out for example in COMMANDS["compare"].examples)

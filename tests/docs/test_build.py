"""The documentation builds without a warning, from the code as it is."""

from __future__ import annotations

import re

import pytest

from hotlap.cli.arguments import COMMANDS

pytest.importorskip("sphinx", reason="make docs installs it")
pytestmark = pytest.mark.check


def test_every_command_and_option_is_in_the_reference(built):
    page = (built / "commands.html").read_text(encoding="utf-8")
    for name, command in COMMANDS.items():
        assert f"hotlap {name}" in page
        for action in command.parser(name)._actions:
            assert all(option in page for option in action.option_strings)


def test_no_page_needs_the_network_to_be_read(built):
    for page in built.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert not re.search(r"""<(script|link|img)\b[^>]*(src|href)=["'](https?:)?//""", text), page.name


def test_the_notebook_is_a_page_with_its_outputs(built):
    page = (built / "notebook.html").read_text(encoding="utf-8")
    assert page.count('src="data:image/png;base64,') == 3
    assert page.count('class="dataframe"') >= 5
    assert "completion=1 confirmed" in page


def test_formulas_have_become_mathml(built):
    for page in ("planning", "scoring", "proof"):
        text = (built / f"{page}.html").read_text(encoding="utf-8")
        assert "<math" in text
        assert "\\begin" not in text
        assert "$$" not in text

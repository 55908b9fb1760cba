"""Every module, name and Python file that a page mentions exists."""

from __future__ import annotations

import pkgutil
import re

import pytest

from docs.pages import DOCS, ROOT

DOTTED = re.compile(r"(?<![\w/.])hotlap(?:\.[A-Za-z_]\w*)+")
FILE = re.compile(r"(?<![\w/.:-])[\w-][\w.-]*(?:/[\w.-]+)+\.py\b")  # with a slash: a file without one may be the reader's own
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]


def exists(name: str) -> bool:
    """Whether a dotted name of hotlap leads to a module, or to something in one."""
    try:
        pkgutil.resolve_name(name)
    except (AttributeError, ImportError):
        return False
    return True


def missing(text: str) -> list[str]:
    """Dotted names and files of hotlap that a text mentions and that do not exist; files from the root, or from the package."""
    names = [name for name in dict.fromkeys(DOTTED.findall(text)) if not exists(name)]
    files = [
        file for file in dict.fromkeys(FILE.findall(text)) if not any((folder / file).is_file() for folder in (ROOT, ROOT / "src/hotlap"))
    ]
    return names + files


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_what_a_page_mentions_exists(page):
    assert missing(page.read_text(encoding="utf-8")) == []


def test_what_does_not_exist_is_noticed():
    text = "`hotlap.tuning.nothing`, `hotlap.tune`, hotlap.flight.controller.Controller.command. `tuning/loop.py` and `tuning/nothing.py`, `by_hand.py`"
    assert missing(text) == ["hotlap.tuning.nothing", "tuning/nothing.py"]

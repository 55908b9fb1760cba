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


def is_file(path: str) -> bool:
    """Whether a path leads to a file, from the root or from the package."""
    return any((folder / path).is_file() for folder in (ROOT, ROOT / "src" / "hotlap"))


def missing(text: str) -> list[str]:
    """Dotted names and files of hotlap that a text mentions and that do not exist."""
    names, files = dict.fromkeys(DOTTED.findall(text)), dict.fromkeys(FILE.findall(text))
    return [name for name in names if not exists(name)] + [file for file in files if not is_file(file)]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_what_a_page_mentions_exists(page):
    assert missing(page.read_text(encoding="utf-8")) == []


def test_what_does_not_exist_is_noticed():
    text = "`hotlap.tune`, hotlap.tuning.nothing, hotlap.flight.controller.Controller; `tuning/loop.py`, `tuning/no.py`, `by_hand.py`"
    assert missing(text) == ["hotlap.tuning.nothing", "tuning/no.py"]

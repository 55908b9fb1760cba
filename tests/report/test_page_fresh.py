"""The page that is shipped was built from the sources beside it."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

import pytest

from hotlap.report.page.writing import load_template

SOURCES = Path(__file__).parents[2] / "page"
SHIPPED = Path(__file__).parents[2] / "src/hotlap/report/page"
ROOT_FILES = ("index.html", "package.json", "package-lock.json", "vite.config.*")

pytestmark = pytest.mark.skipif(not SOURCES.is_dir(), reason="the sources of the page are not here")


def sources() -> list[Path]:
    roots = [path for pattern in ROOT_FILES for path in SOURCES.glob(pattern)]
    return sorted([*roots, *(path for path in (SOURCES / "src").rglob("*") if path.is_file())], key=name)


def name(path: Path) -> str:
    return path.relative_to(SOURCES).as_posix()


def test_the_built_page_is_not_stale():
    digest = hashlib.sha256(b"".join(name(path).encode() + b"\0" + path.read_bytes() + b"\0" for path in sources())).hexdigest()
    first = re.search(r"<!--(.*?)-->", load_template(), re.DOTALL)
    assert first is not None
    assert first[1].strip() == f"hotlap page {digest}", "page/ has changed since the page was built: make page"


def test_the_built_page_asks_for_nothing_outside_itself():
    tags = re.findall(r"<(?:link|script|img|iframe)\b[^>]*?\b(?:src|href)=\"([^\"]*)\"", load_template())
    assert all(address.startswith("data:") for address in tags)
    assert not re.search(r"@import|url\(\s*['\"]?https?:", load_template())


def test_what_is_built_in_has_its_licence():
    licences = (SHIPPED / "LICENSES.txt").read_text(encoding="utf-8")
    assert all(word in licences for word in ("three 0", "uplot 1", "The MIT License", "Permission is hereby granted"))


def test_the_lock_file_speaks_of_no_registry():
    assert '"resolved"' not in (SOURCES / "package-lock.json").read_text()

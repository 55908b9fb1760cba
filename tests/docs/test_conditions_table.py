"""The table of how controllers hold is that of the stored flights, with margins as they are computed now."""

from __future__ import annotations

import gzip
import importlib.util
import re
import sys

import pytest

from docs.pages import DOCS

BENCHMARKS = DOCS.parent / "benchmarks"
RESULTS = BENCHMARKS / "results" / "conditions.jsonl.gz"
MARGIN = re.compile(r" \(\d\.\d\d\)")


@pytest.fixture(scope="module")
def conditions():
    specification = importlib.util.spec_from_file_location("conditions", BENCHMARKS / "conditions.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules["conditions"] = module
    specification.loader.exec_module(module)
    yield module
    del sys.modules["conditions"]


def rows_of_the_page() -> dict[str, str]:
    text = (DOCS / "offset_free.md").read_text(encoding="utf-8").partition("## On all races")[2]
    lines = [line for line in text.splitlines() if line.startswith("| ")][1:]
    return {line.split()[1]: line for line in lines}


def only(race: str, folder):
    """The stored runs of one race, as a file."""
    path = folder / "one.jsonl.gz"
    with gzip.open(RESULTS, "rt") as lines, gzip.open(path, "wt") as kept:
        kept.writelines(line for line in lines if f"race='{race}'" in line)
    return path


def test_the_page_has_the_rates_and_errors_of_all_stored_flights(conditions, monkeypatch):
    monkeypatch.setattr(conditions, "margins_anew", lambda _: iter([{}]))
    _, _, *lines = conditions.documented(conditions.read(RESULTS, 1))
    assert [MARGIN.sub("", line) for line in rows_of_the_page().values()] == [MARGIN.sub("", line) for line in lines]


def test_the_margins_of_the_page_are_those_that_are_computed_now(conditions, tmp_path, capsys):
    conditions.main(["--from", str(only("airsim-circle-34", tmp_path)), "--jobs", "1"])
    assert rows_of_the_page()["airsim-circle-34"] in capsys.readouterr().out.splitlines()

"""The page of a folder of studies shows each of them, sends what has changed, and stays light with hundreds."""

from __future__ import annotations

import json
import re
import shutil

import pytest

from hotlap.report.studies_page import HEADS, OPEN_AT_ONCE, StudiesPage, row_of
from hotlap.study.database import FILE, Database
from hotlap.study.glance import Glance, State
from hotlap.study.study import Study
from hotlap.tuning.objective import Objective
from plausible_world import PlausibleWorld
from studies import begin, carry, configure

MANY = 300


class Opened:
    """The page of a study that is only counted."""

    def __init__(self, folder):
        self.folder = folder

    def page(self):
        return str(self.folder)

    def news(self, known=-1):
        return None if known else "{}"


@pytest.fixture
def folder(tmp_path):
    carry(tmp_path / "done", configure(budget=20))
    begin(tmp_path / "below" / "new", configure(goal="none", budget=20, validation=0))
    return tmp_path


def test_every_study_is_a_row_with_its_own_page_also_without_script(folder):
    (folder / "<b>").mkdir()
    (folder / "<b>" / FILE).write_bytes(b"no database" * 99)
    page = StudiesPage(folder, Opened).page()
    assert re.findall(r'<a href="([^"]*)">', page) == ["study/below/new/", "study/done/"]
    assert "<b>" not in page
    assert "unreadable: study.sqlite is no database" in page
    assert page.count("<tr data-name=") == 3
    assert "0 of 20" in page


def test_a_version_hears_only_of_what_has_changed_since(folder):
    page = StudiesPage(folder, Opened)
    first = json.loads(page.news(-1) or "")
    assert [row["name"] for row in first["rows"]] == ["below/new", "done"]
    assert page.news(first["version"]) is None
    asked = configure(goal="none", budget=20, validation=0)
    with Study.open(folder / "below" / "new", asked) as study:
        study.run(Objective(asked.scenario, PlausibleWorld(), asked.metric))
    second = json.loads(page.news(first["version"]) or "")
    assert [(row["name"], row["state"]) for row in second["rows"]] == [("below/new", "finished")]
    assert second["gone"] == []
    shutil.rmtree(folder / "done")
    third = json.loads(page.news(second["version"]) or "")
    assert (third["rows"], third["gone"]) == ([], ["done"])
    carry(folder / "done", configure(budget=20))
    fourth = json.loads(page.news(third["version"]) or "")
    assert ([row["name"] for row in fourth["rows"]], fourth["gone"]) == (["done"], [])


def test_pages_of_studies_are_made_when_they_are_asked_for_and_a_few_are_kept(folder):
    for k in range(2 * OPEN_AT_ONCE):
        shutil.copytree(folder / "done", folder / f"copy{k}")
    made = []
    page = StudiesPage(folder, lambda path: made.append(path.name) or Opened(path))
    page.page()
    assert made == []
    assert [page.study(name) is page.study(name) for name in ("done", "below/new")] == [True, True]
    for k in range(2 * OPEN_AT_ONCE):
        page.study(f"copy{k}")
    page.study("copy15")
    assert made == ["done", "new", *(f"copy{k}" for k in range(16))]
    page.study("done")
    assert made[-1] == "done"


@pytest.mark.parametrize("name", ["", "nowhere", "..", "../done", "below", "/etc", "done/", "below/../done"])
def test_nothing_but_the_studies_of_the_folder_has_a_page(folder, name):
    assert StudiesPage(folder, Opened).study(name) is None


@pytest.mark.check
def test_hundreds_of_studies_make_a_small_page_and_a_look_opens_none_that_has_not_changed(folder, monkeypatch):
    for k in range(MANY):
        shutil.copytree(folder / "done", folder / f"run-{k:03}")
    page = StudiesPage(folder, Opened)
    html = page.page()
    assert html.count("<tr data-name=") == MANY + 2
    assert len(html) < 600 * MANY, "bytes, all of it"
    opened = []
    made = Database.__init__

    def count(self, path, *, owned):
        opened.append(path)
        made(self, path, owned=owned)

    monkeypatch.setattr(Database, "__init__", count)
    version = json.loads(page.news(-1) or "")["version"]
    assert opened == []
    with Study.open(folder / "run-007", configure(budget=40)):
        opened.clear()
        news = page.news(version)
    assert opened == [folder / "run-007"]
    assert len(json.loads(news or "")["rows"]) == 1
    assert len(news or "") < 600


def test_cells_of_a_study_that_has_not_flown_say_so():
    row = row_of(Glance("s", State.STOPPED, race="r", budget=20))
    assert len(row["cells"]) == len(HEADS)
    assert dict(zip(HEADS, row["cells"], strict=True))["completion [%]"] == "-"
    minutes = row_of(Glance("s", State.SEARCHING, minutes=2.0, flights=7, completion=0.5, lap_time=5.0, successes=19, validation=20))
    cells = dict(zip(HEADS, minutes["cells"], strict=True))
    assert [cells[name] for name in HEADS[2:6]] == ["7 of 2 min", "50", "95 (20)", "5.00"]
    unreadable = row_of(Glance("s", State.UNREADABLE, fault="why"))
    assert len(unreadable["cells"]) == len(HEADS)
    json.dumps([row, minutes, unreadable], allow_nan=False)

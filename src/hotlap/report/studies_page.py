"""Studies page: a folder of studies as one table that follows them, for a server; each study's own page is a press away."""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any
from urllib.parse import quote

from hotlap.core.finite import finite
from hotlap.report.article import STYLE
from hotlap.report.markup import element, text
from hotlap.report.scripts import load_script
from hotlap.report.server import Source
from hotlap.study.glance import Follower, Glance, State, find_studies

OPEN_AT_ONCE = 8  # pages of studies that are kept, with what they have flown
HEADS = (
    *("study", "state", "flights", "completion [%]", "validated [%] (flights)", "lap [s]"),
    *("race", "tuner", "goal", "world", "seed", "changed"),
)
NUMBERS = (2, 3, 4, 5, 10)

Opener = Callable[[Path], Source]
"""Makes the live page of the study in a folder."""


class StudiesPage:
    """The page of a folder of studies; several threads may ask.

    Args:
        folder: with studies in it or below it.
        open_study: makes the page of one of them.
    """

    def __init__(self, folder: Path, open_study: Opener) -> None:
        self._folder, self._open, self._lock = folder, open_study, threading.Lock()
        self._followers: dict[str, Follower] = {}
        self._seen: dict[str, Glance] = {}
        self._rows: dict[str, tuple[int, dict[str, Any]]] = {}  # by name: number of the change, and the row
        self._gone: dict[str, int] = {}
        self._version = 0
        self._pages: dict[str, Source] = {}

    def page(self) -> str:
        """The whole page as HTML; without script it shows the studies as they are now."""
        with self._lock:
            self._look()
            version, rows = self._version, [row for _, row in self._rows.values()]
        return _render(self._folder, version, rows)

    def news(self, known: int = -1) -> str | None:
        """Rows that have changed since a version of the table as JSON; None where none has.

        Args:
            known: the version that the page has.
        """
        with self._lock:
            self._look()
            if known == self._version:
                return None
            changed = [row for when, row in self._rows.values() if when > known]
            gone = [name for name, when in self._gone.items() if when > known]
            return json.dumps({"version": self._version, "rows": changed, "gone": gone}, allow_nan=False)

    def study(self, name: str) -> Source | None:
        """The page of one of the studies; None where there is none of this name, or it cannot be read."""
        with self._lock:
            self._look()
            follower = self._followers.get(name)
            if follower is None or self._rows[name][1]["state"] == State.UNREADABLE:
                return None
            if name not in self._pages:
                self._pages = dict(list(self._pages.items())[-OPEN_AT_ONCE + 1 :])
                self._pages[name] = self._open(follower.folder)
            return self._pages[name]

    def _look(self) -> None:
        """Look at all studies again, and number what has changed."""
        found = {_name(self._folder, path): path for path in find_studies(self._folder)}
        next_version, changed = self._version + 1, False
        for name in set(self._followers) - set(found):
            del self._followers[name], self._rows[name], self._seen[name]
            self._pages.pop(name, None)
            self._gone[name], changed = next_version, True
        for name, path in found.items():
            follower = self._followers.setdefault(name, Follower(path, name))
            glance = follower.look()
            if self._seen.get(name) is not glance:
                self._seen[name], self._rows[name], changed = glance, (next_version, row_of(glance)), True
                self._gone.pop(name, None)
        self._version += changed


def row_of(glance: Glance) -> dict[str, Any]:
    """A study as a row: its cells, and the values that they are sorted by."""
    if glance.state is State.UNREADABLE:
        cells = [glance.name, f"{glance.state}: {glance.fault}", *["-"] * (len(HEADS) - 3), _moment(glance.changed)]
        return {"name": glance.name, "state": glance.state, "cells": cells, "values": {str(len(HEADS) - 1): glance.changed}}
    rate = glance.successes / glance.validation if glance.validation else math.nan
    of = f"{glance.minutes:g} min" if glance.minutes else str(glance.budget)
    cells = [
        glance.name,
        f"{glance.state}, nothing changed" if glance.kept else glance.state,
        f"{glance.flights} of {of}",
        _percent(glance.completion),
        f"{_percent(rate)} ({glance.validation})" if glance.validation else "-",
        f"{glance.lap_time:.2f}" if math.isfinite(glance.lap_time) else "-",
        glance.race,
        glance.tuner,
        glance.goal,
        glance.world,
        str(glance.seed),
        _moment(glance.changed),
    ]
    return finite({"name": glance.name, "state": glance.state, "cells": cells, "values": {str(len(HEADS) - 1): glance.changed}})


def _name(folder: Path, study: Path) -> str:
    """What a study is called: its folder, from the one that is looked at."""
    return study.relative_to(folder).as_posix()


def _percent(share: float) -> str:
    return f"{100 * share:.0f}" if math.isfinite(share) else "-"


def _moment(time: float) -> str:
    return datetime.fromtimestamp(time).astimezone().strftime("%Y-%m-%d %H:%M")


def _render(folder: Path, version: int, rows: Sequence[Mapping[str, Any]]) -> str:
    """The page."""
    title = f"Studies in {folder}"
    heads = "".join(element("th", text(head), scope="col", **_class(j)) for j, head in enumerate(HEADS))
    body = element("tbody", "".join(map(_row, rows)), data_version=version)
    table = element("div", element("table", element("thead", element("tr", heads)) + body, class_="sortable"), class_="wide", id="studies")
    sift = (
        '<p class="sift" hidden><label>Show only <input id="sift" type="search" placeholder="circle confirmed" autocomplete="off">'
        '</label> <span id="count" role="status"></span></p>'
    )
    said = element("p", "The head of a column sorts, the name of a study opens its page; the table follows the studies.")
    parts = element("h1", text(title)) + said + sift + table + '<p id="lost" role="status"></p>'
    head = '<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
    head += (
        '<meta name="color-scheme" content="light dark">'
        + element("title", text(f"{title} - hotlap"))
        + element("style", STYLE + OWN_STYLE)
    )
    script = element("script", load_script("tables", "studies"))
    return f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>{element("main", parts)}{script}</body></html>\n'


def _row(row: Mapping[str, Any]) -> str:
    """A row as the script of the page makes it, too."""
    name, *cells = row["cells"]
    shown = text(name) if row["state"] == State.UNREADABLE else element("a", text(name), href=f"study/{quote(name)}/")
    values = {j: {"data_value": row["values"][str(j)]} if str(j) in row["values"] else {} for j in range(len(HEADS))}
    rest = "".join(element("td", text(cell), **values[j], **_class(j)) for j, cell in enumerate(cells, start=1))
    return element("tr", element("th", shown, scope="row") + rest, data_name=name, data_state=row["state"])


def _class(column: int) -> dict[str, str]:
    return {"class_": "number"} if column in NUMBERS else {}


OWN_STYLE = """
main { max-width: none; }
.sift input { font: inherit; font-size: 1rem; padding: 0.2rem 0.5rem; width: 14rem; max-width: 100%; color: inherit;
  background: var(--paper); border: 1px solid var(--line); border-radius: 4px; }
#count, #lost { color: var(--quiet); }
#count { white-space: nowrap; }
#studies th, #studies td { padding-right: 0.5rem; }
#studies thead th { white-space: normal; vertical-align: bottom; }
tr[data-state=searching] td:nth-child(2) { color: var(--accent); font-weight: 600; }
tr[data-state=unreadable] { color: var(--quiet); }
tr[data-state=unreadable] td:nth-child(2) { white-space: normal; min-width: 12rem; }
tr[hidden] { display: none; }
@media (max-width: 40rem) { tbody th { white-space: normal; overflow-wrap: anywhere; min-width: 8rem; max-width: 10rem; } }
"""

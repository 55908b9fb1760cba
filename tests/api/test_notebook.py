"""In a notebook a call shows bars below its cell; elsewhere it says nothing unless it is asked to."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import pytest

import hotlap
from hotlap.api.notebook import Notebook, progress_of
from hotlap.api.progress import Quiet


class Page:
    """What a notebook shows, place by place."""

    def __init__(self) -> None:
        self.places: list[list[str]] = []

    def show(self, text: str):
        place = [text]
        self.places.append(place)
        return place.append

    @property
    def now(self) -> list[str]:
        return [place[-1] for place in self.places]


class Clock:
    """Goes on by a second at each look."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        self.now += 1.0
        return self.now


@pytest.fixture
def page():
    return Page()


@pytest.fixture
def kernel(monkeypatch, page):
    """A notebook, as far as a program can tell."""

    class Handle:
        def __init__(self, update):
            self.update = update

    display = SimpleNamespace(HTML=lambda text: text, display=lambda text, display_id: Handle(page.show(text)))
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: SimpleNamespace(kernel=object()), display=display))
    monkeypatch.setitem(sys.modules, "IPython.display", display)


def test_a_tuning_in_a_notebook_shows_its_flights(here, kernel, page, capsys):
    assert here.is_dir()
    assert kernel is None
    hotlap.tune("straight.toml", seed=1, budget=12, validation=5, out="mine", goal="mean_error<0.001")
    bars = [text for text in page.now if "<progress" in text]
    assert [text for text in bars if 'value="12" max="12"' in text and "12 of 12 flights, best so far: " in text]
    assert not any(text.endswith(" ...</small>") for text in page.now), "what was under way has ended"
    assert tuple(capsys.readouterr()) == ("", "")


def test_outside_of_a_notebook_nothing_is_said_unless_it_is_asked_for(here, capsys):
    assert here.is_dir()
    assert isinstance(progress_of(None), Quiet)
    assert isinstance(progress_of(False), Quiet)
    own = Quiet()
    assert progress_of(own) is own
    hotlap.tune("straight.toml", seed=1, budget=12, validation=5, out="mine", progress=True)
    out, said = capsys.readouterr()
    assert out == ""
    assert "of 12 flights, best so far: " in said
    assert "<" not in said
    assert all(said.splitlines())


def test_a_prompt_of_ipython_is_no_notebook(monkeypatch):
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=SimpleNamespace))
    assert isinstance(progress_of(None), Quiet)


def test_no_bars_where_they_are_not_wanted(kernel, page):
    assert kernel is None
    assert isinstance(progress_of(False), Quiet)
    assert isinstance(progress_of(None), Notebook)
    assert isinstance(progress_of(True), Notebook)
    assert page.places == []


def test_pieces_and_rounds_are_counted_and_remarks_are_no_markup(page):
    progress = Notebook(page.show, Clock())
    progress.note("a <b> remark")
    with progress.pieces("runs", 3, 1) as say:
        say("circle-34 <1>")
        say("the last")
    with progress.rounds("plans", 4) as each, each("plans", 2, 0) as say:
        say("one")
    with progress.working("planning"):
        assert page.now[-1] == "<small>planning ...</small>"
    remark, runs, plans, _ = page.now
    assert remark == "<small>a &lt;b&gt; remark</small>"
    assert runs == '<progress value="3" max="3"></progress> <small>3 of 3 runs, the last</small>'
    assert "1 of 4 plans, one" in plans
    assert any("circle-34 &lt;1&gt;" in text for text in page.places[1])


def test_a_bar_is_drawn_a_few_times_a_second_at_most(page):
    progress = Notebook(page.show, lambda: 0.0)
    with progress.pieces("runs", 1000, 0) as say:
        for i in range(1000):
            say(str(i))
    assert len(page.places[0]) == 2
    assert "1000 of 1000 runs, 999" in page.now[0]

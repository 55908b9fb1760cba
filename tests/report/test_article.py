"""An article says the same as Markdown and as HTML, and its HTML needs nothing else."""

from __future__ import annotations

import math
import re
from html.parser import HTMLParser

import pytest

from hotlap.analysis.comparison import Run
from hotlap.report.article import Article, inline
from hotlap.report.comparison_article import compose_article

PNG = bytes.fromhex(
    "89504e470d0a1a0a0000000d49484452000000010000000108060000001f15c4890000000d49444154789c6360000002000001e221bc330000000049454e44ae426082"
)


class Words(HTMLParser):
    """What a reader sees, and every address that a browser would ask."""

    def __init__(self, html):
        super().__init__()
        self.words, self.addresses, self.classes = "", [], []
        self.feed(html)

    def handle_data(self, data):
        self.words += data + " "

    def handle_starttag(self, tag, attrs):
        self.addresses += [value for name, value in attrs if name in {"src", "href"} and tag != "a"]
        self.classes += [(tag, value) for name, value in attrs if name == "class"]


@pytest.fixture
def article(tmp_path):
    (tmp_path / "map.png").write_bytes(PNG)
    made = Article("Table <I>", source="runs.jsonl")
    made.say("With `--seed 1 & 2`, *mean* of **all**.")
    made.head("Races")
    made.table(("race", "found", "[%]"), [("a<b", "yes", "97 [94, 99]"), ("c", "no", "3")])
    made.picture(tmp_path / "map.png", "where")
    return made


def test_both_forms_say_the_same(article):
    page = Words(article.html)
    for words in ("Table <I>", "--seed 1 & 2", "Races", "a<b", "97 [94, 99]", "runs.jsonl"):
        assert words in page.words
        assert words in article.markdown or words == article.source
    assert "![where](map.png)" in article.markdown
    assert "| a<b | yes | 97 [94, 99] |" in article.markdown


def test_a_long_name_of_a_row_has_a_line_of_its_own_and_that_of_a_column_several():
    long = "10 % heavier and 15 % less thrust and steady push of 3 m/s^2 as of wind"
    made = Article("Holds")
    made.table(("tuner", long), [("gate_gp", "97"), (long, "3")])
    head, body = made.html.partition("<thead>")[2].split("</thead>")
    assert f'<th scope="col" class="number long">{long}</th>' in head
    assert '<tr><th scope="row">gate_gp</th><td class="number">97</td></tr>' in body
    assert f'<tr class="over"><th scope="row" colspan="2" class="long">{long}</th></tr><tr><td></td><td class="number">3</td></tr>' in body
    assert "th.long { white-space: normal;" in made.html
    assert f"| {long} | 3 |" in made.markdown


def test_html_asks_nobody_for_anything(article):
    page = Words(article.html)
    assert page.addresses
    assert all(address.startswith("data:image/png;base64,") for address in page.addresses)
    assert "<script" not in article.html
    assert not re.search(r"url\(|@import", article.html)


def test_numbers_are_aligned_and_words_are_not(article):
    assert Words(article.html).classes.count(("td", "number")) == 2


def test_it_is_readable_in_the_dark_on_paper_and_on_a_small_screen(article):
    for words in ("prefers-color-scheme: dark", "@media print", "width=device-width", "overflow-x: auto"):
        assert words in article.html


@pytest.mark.parametrize(
    ("words", "html"),
    [
        ("`a*b*c`", "<code>a*b*c</code>"),
        ("*a* and **b**", "<em>a</em> and <strong>b</strong>"),
        ("2 * 3 * 4", "2 * 3 * 4"),
        ("<script>", "&lt;script&gt;"),
        ("metropolis_hastings:tied of 97 [94, 99]", "metropolis_hastings:tied of 97 [94, 99]"),
        ("`a` <b>*c*</b> # 1. &amp;", "<code>a</code> &lt;b&gt;<em>c</em>&lt;/b&gt; # 1. &amp;amp;"),
    ],
)
def test_the_few_marks_of_a_paragraph(words, html):
    assert inline(words) == html


def test_a_picture_that_is_gone_is_an_error(article, tmp_path):
    (tmp_path / "map.png").unlink()
    with pytest.raises(FileNotFoundError):
        _ = article.html


def test_a_comparison_names_every_tuner_and_race_with_intervals():
    spent = {"budget": 200, "flights": 20, "search_flights": 20, "confirmed": True, "successes": 40, "validation": 50}
    worth = {"completion": 1.0, "cost": 5.0, "lap_time": math.nan, "tuner_time": 0.1, "curve": ((1, 0.2), (20, 1.0))}
    runs = [Run(race=race, tuner=tuner, seed=0, **spent, **worth) for race in ("one", "two") for tuner in ("a:x", "b:y")]
    page = Words(compose_article(runs, "runs.jsonl", "hotlap compare one two").html)
    assert all(words in page.words for words in ("one", "two", "a:x", "b:y", "100 [21, 100]", "hotlap compare one two"))

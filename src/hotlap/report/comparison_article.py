"""Article of a comparison of tuners: curves, tables, a heat map and pairs; it is drawn here, so that it needs no matplotlib."""

from __future__ import annotations

from collections.abc import Sequence

from hotlap.analysis.comparison import Run
from hotlap.analysis.comparison_table import Row, cells_of, held_cells_of, overall, rows_of
from hotlap.analysis.paired import paired, paired_cells
from hotlap.core.counts import count
from hotlap.report.article import Article
from hotlap.report.comparison_charts import BAND_UP_TO, curve_chart, legend, profile_chart, style_of
from hotlap.report.comparison_curves import curves_of
from hotlap.report.comparison_heat import heat_maps
from hotlap.report.comparison_looks import looks_of
from hotlap.report.markup import element
from hotlap.report.scripts import load_script


def compose_article(runs: Sequence[Run], source: str, command: str) -> Article:
    """The article of a comparison: over all races, drawn, race by race, and pair by pair.

    Args:
        runs: at least one.
        source: name of the file with the runs, in the folder of the article.
        command: shell command that does the comparison again; "" where there is none.
    """
    races, seeds = list(dict.fromkeys(run.race for run in runs)), len({run.seed for run in runs})
    article = Article(f"Tuners compared on {', '.join(races) if len(races) <= 3 else f'{len(races)} races'}", source=source)
    article.say(
        f"Every tuner began at the same first guess and met the same noise, {count(seeds, 'seed')} on each race. "
        "*Confirmed*: the share of runs that found a controller which passed its re-flights. *Validated*: the share of fresh flights in "
        "which that controller then met the goal. *Lap*: the median over the races and seeds that all tuners solved, in brackets how many "
        "these are. *Flights*: search flights to the confirmed controller, the median, and that with re-flights. *Completion at 50*: of "
        "the best candidate after 50 flights, the median. *ms/flight*: the tuner's own time for a flight. In square brackets: 95 % "
        "intervals, for flights the quartiles; a dash where fewer than that confirmed a controller, or none did. A press on the head of "
        "a column sorts the table."
    )
    article.head("Over all races")
    _add_table(article, overall(runs))
    _add_charts(article, runs, races)
    article.head("Race by race")
    article.draw(heat_maps(rows_of(runs)))
    _add_table(article, rows_of(runs))
    _add_pairs(article, runs)
    _add_held(article, runs)
    if command:
        article.head("Run it again")
        article.say(f"`{command}`")
    return article


def _add_charts(article: Article, runs: Sequence[Run], races: Sequence[str]) -> None:
    """Curves of each race and the profile over all, with one key."""
    looks = looks_of(list(dict.fromkeys(run.tuner for run in runs)))
    article.style, article.script = f"{STYLE}\n{style_of(looks)}", load_script("tables", "comparison")
    article.head("Flight by flight")
    quartiles = ", the band its quartiles" if len(looks) <= BAND_UP_TO else ""
    article.say(
        "Completion of the best candidate so far, each flight at its own number, from that of the first guess on; it falls where the best "
        "one fails when it is flown again. "
        f"The line is the median over seeds{quartiles}. Lines that coincide lie side by side, the first tuner on top. "
        "Point at a chart, or go through it with the arrow keys, to read its values."
    )
    charts = element("div", "".join(curve_chart(curves_of(race, runs), looks) for race in races), class_="charts")
    said = element(
        "p", "Performance profile: the share of all races and seeds that a tuner solved within a multiple of the fastest tuner's flights."
    )
    article.draw(element("section", legend(looks) + charts + said + profile_chart(runs, looks), class_="drawn"), "![curves](curves.png)")


def _add_pairs(article: Article, runs: Sequence[Run]) -> None:
    """Each two tuners."""
    cells = paired_cells(paired(runs))
    if not cells:
        return
    article.head("Pair by pair")
    article.say(
        "The same race with the same seed is flown by both, and their results are subtracted: *confirmed* and *validated* in points of per "
        "cent, positive where the first tuner is better; *flights*: in how many pairs it needed fewer and in how many more; *lap*: by how "
        "much its lap is longer, median over the pairs that both solved. In brackets: 95 % intervals, by resampling the seeds within each "
        "race, so they speak of these races alone; none where all pairs differ by the same. *p*: exact sign test (confirmed, flights) or "
        "Wilcoxon's signed rank test (validated, lap), two-sided, corrected for the number of pairs of tuners (Holm)."
    )
    heads, *body = cells
    article.table(heads, body, sortable=True)


def _add_held(article: Article, runs: Sequence[Run]) -> None:
    """What is held under the conditions that were asked for, if any were."""
    if not any(run.held for run in runs):
        return
    article.head("Will it hold?")
    article.say(
        "The result of each run flown under the conditions that were asked for; share of flights that met the goal, mean over runs."
    )
    for rows in (overall(runs), rows_of(runs)):
        heads, *body = held_cells_of(rows)
        article.table(heads, body)


def _add_table(article: Article, rows: Sequence[Row]) -> None:
    """Add rows as a table."""
    heads, *body = cells_of(rows)
    article.table(heads, body, sortable=True)


STYLE = """
main { max-width: 84rem; }
.charts { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 19rem), 1fr)); gap: 1rem; }
.chart { margin: 0; position: relative; }
.chart .cursor { stroke: var(--ink); stroke-width: 1; fill: none; }
.values { position: absolute; top: 2rem; z-index: 1; display: grid; padding: 0.3rem 0.6rem; border: 1px solid var(--line);
  border-radius: 4px; background: var(--paper); font-size: 0.8rem; font-variant-numeric: tabular-nums;
  pointer-events: none; white-space: nowrap; }
.values[hidden] { display: none; }
.values span { color: var(--own); }
.chart figcaption { color: var(--ink); font-weight: 500; margin: 0; }
.chart svg { display: block; width: 100%; height: auto; }
.wide-chart { max-width: 31rem; }
.chart text { fill: var(--quiet); font-size: 11px; font-variant-numeric: tabular-nums; }
.chart text.name { fill: var(--ink); }
.grid { stroke: var(--line); stroke-width: 1; }
.line { fill: none; stroke: var(--own); stroke-width: 2; }
.band { fill: var(--own); stroke: none; opacity: 0.14; }
.one-lit .chart .line:not(.lit) { opacity: 0.2; }
.one-lit .chart .band:not(.lit) { opacity: 0.03; }
.chart .away { display: none; }
.legend { display: flex; flex-wrap: wrap; gap: 0.3rem 0.5rem; padding: 0.5rem 0; background: var(--paper); }
.legend button, .choice button { font: inherit; font-size: 0.85rem; color: var(--ink); background: none; border: 1px solid var(--line);
  border-radius: 4px; padding: 0.15rem 0.5rem; cursor: pointer; }
.legend svg { vertical-align: middle; margin-right: 0.4rem; }
.legend button[aria-pressed=false] { color: var(--quiet); text-decoration: line-through; }
.choice { display: flex; flex-wrap: wrap; gap: 0.5rem; }
.choice button[aria-pressed=true] { border-color: var(--accent); box-shadow: inset 0 0 0 1px var(--accent); }
@media (min-width: 60rem) and (min-height: 40rem) { .drawn .legend { position: sticky; top: 0; max-height: 20vh; overflow-y: auto; } }
table.heat td { text-align: right; background: color-mix(in srgb, var(--accent) calc(var(--heat, 0%) * 0.5), transparent); }
table.heat thead th { white-space: normal; vertical-align: bottom; text-align: right; }
table.heat thead th:first-child { text-align: left; }
table.heat td, table.heat thead th:not(:first-child) { padding-left: 0.9rem; }
figure[hidden] { display: none; }
""".strip()

"""Article of a score: a flight that really happened beside a simulated one, with tables and charts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hotlap.analysis.transfer import metres
from hotlap.reference.scenario import Scenario
from hotlap.report.article import Article
from hotlap.report.input_charts import inputs
from hotlap.report.pictures import save
from hotlap.report.scene import Scene
from hotlap.report.time_charts import tracking_error
from hotlap.report.track_view import track


def compose_article(
    folder: Path,
    scene: Scene,
    scenario: Scenario,
    facts: Mapping[str, str],
    figures: Sequence[tuple[str, str, str]],
    gates: Sequence[Mapping[str, Any]],
    notes: Sequence[str],
    command: str,
) -> Article:
    """The article of a score.

    Args:
        folder: for its pictures.
        scene: the flight first, then a simulated one.
        scenario: that was flown.
        facts: of the result; the first is the title.
        figures: what was measured, flown, and simulated.
        gates: a row each, as `hotlap score --json` has them.
        notes: what was assumed.
        command: shell command that does the same again; "" where there is none.

    Raises:
        InputError: a picture cannot be written.
    """
    title, *_ = facts.values()
    article = Article(f"{scenario.race.name}: a real flight")
    article.say(
        f"The log `{title.partition(': ')[2]}` judged by the race's judge, beside simulated flights of the same race with noise. The error "
        "is the distance from the clocked reference, at each control period from the start until the flight's end."
    )
    article.table(("", "flown", "simulated"), figures)
    article.say(f"Time and frame: {facts['time and frame']}.")
    for name, figure, caption in _pictures(scene, scenario):
        article.picture(save(folder / f"{name}.png", figure), caption)
    article.head("Gate by gate")
    heads = ("gate", "passed", "distance [m]", "at [s]", "simulated [m]", "at [s]", "planned at [s]")
    article.table(heads, map(_cells, gates))
    article.head("What was assumed")
    article.say("The simulated flight that is drawn is the one in the middle of all, by gates passed and mean error.")
    for note in notes:
        article.say(note[:1].upper() + note[1:] + ".")
    if command:
        article.head("Run it again")
        article.say(f"`{command}`")
    return article


def _pictures(scene: Scene, scenario: Scenario) -> Iterator[tuple[str, Any, str]]:
    """Name, figure and caption of each chart that has something to show."""
    if not len(scene.traces[0].times):
        return
    yield "track", track(scene), "The flight, coloured by its speed, the simulated one dashed, and the plan"
    yield "error", tracking_error(scene), "Tracking error over time, flown and simulated"
    if np.isfinite(scene.traces[0].commands).all(axis=1).any():
        yield "inputs", inputs(scene, scenario), "Commands of the flight, with those of the reference and the limits"


def _cells(row: Mapping[str, Any]) -> list[str]:
    """The cells of one gate."""
    numbers = [(metres(row[f"{who}distance"]), _seconds(row[f"{who}time"])) for who in ("", "simulated_")]
    return [row["gate"], "yes" if row["passed"] else "no", *numbers[0], *numbers[1], _seconds(row["planned_time"])]


def _seconds(time: float) -> str:
    return f"{time:.2f}" if math.isfinite(time) else "-"

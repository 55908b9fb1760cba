"""Still: what of a page is readable without JavaScript: headline, map and tables."""

from __future__ import annotations

import math
from collections.abc import Iterator

from hotlap.goal import Quantity
from hotlap.report.demonstration import BEST
from hotlap.report.markup import element, facts, paragraph, table, text
from hotlap.report.page.shown import Shown
from hotlap.report.page.standing import Standing
from hotlap.report.page.track_map import draw_track_map
from hotlap.report.scene import Scene, stage
from hotlap.result import Result
from hotlap.validation import Validation, wilson_interval


def describe_still(standing: Standing, shown: Shown | None) -> str:
    """The same study as HTML.

    Args:
        standing: of the study.
        shown: what was flown again; None: nothing yet.
    """
    scene = stage(standing.configuration.course) if shown is None else shown.scene
    parts = [
        element("h1", text(title_of(standing))),
        paragraph(summary_of(standing)),
        _figure(scene),
        element("h2", "Facts"),
        facts(_facts(standing)),
        *_tables(standing, shown),
        element("h2", "Run it again"),
        element("pre", element("code", text(standing.command))),
    ]
    return "\n".join(parts)


def title_of(standing: Standing) -> str:
    """Race and tuner."""
    return f"{standing.configuration.course.race.name}: {standing.configuration.tuner}"


def summary_of(standing: Standing) -> str:
    """How the study stands, in a sentence or two."""
    result = standing.result
    if result is None:
        return "No flights yet."
    where = "" if standing.finished else "The search is still running. "
    return f"{where}{_verdict(result, standing)} {_held(result.validation)}".strip()


def _verdict(result: Result, standing: Standing) -> str:
    """Whether it worked."""
    gates = f"{100 * result.best.completion:.0f} % of the gates"
    lap = f", a lap of {result.best.lap_time:.2f} s" if math.isfinite(result.best.lap_time) else ""
    if standing.configuration.settings.goal.quantity is Quantity.NONE:
        return f"{result.flights} flights; the best passed {gates}{lap}."
    if result.best.confirmed:
        return f"{result.goal} confirmed after {result.search_flights} search flights: {gates}{lap}."
    return f"{result.goal} NOT confirmed in {result.flights} flights; the best so far passed {gates}{lap}."


def _held(validation: Validation | None) -> str:
    """What fresh flights say of it."""
    return "" if validation is None else f"Holds in {share(validation.successes, validation.flights)}."


def share(successes: int, flights: int) -> str:
    """A share with its interval: 97 of 100 flights (95 % interval 92 to 99 %)."""
    low, high = wilson_interval(successes, flights)
    return f"{successes} of {flights} flights (95 % interval {100 * low:.0f} to {100 * high:.0f} %)"


def _figure(scene: Scene) -> str:
    """The map with a line on what it shows."""
    fastest = float(scene.traces[0].speed.max(initial=0.0)) if scene.traces else scene.reference.max_speed
    what = f"{scene.traces[0].label}, {scene.traces[0].ending}" if scene.traces else "plan"
    words = f"{what}: coloured by speed, from violet at rest to yellow at {fastest:.1f} m/s; circles: gates, {scene.distance:g} m around"
    crosses = "; red crosses: where failed flights ended" if any(len(repeats.failures) for repeats in scene.repeats) else ""
    return element("figure", draw_track_map(scene) + element("figcaption", text(words + crosses)))


def _facts(standing: Standing) -> dict[str, object]:
    """Figures one by one."""
    asked, result = standing.configuration, standing.result
    race, settings = asked.course.race, asked.settings
    return {
        "race": race.name,
        "vehicle": race.vehicle.name,
        "the controller believes in": race.believed.name,
        "planned lap": f"{asked.course.reference.lap_time:.2f} s",
        "goal": str(settings.goal),
        "seed": settings.seed,
        "flights": "" if result is None else f"{result.flights} of at most {settings.budget}, re-flights included",
        "wall time": "" if result is None else f"{result.wall_time:.1f} s",
        "remark": "" if result is None else result.remark,
        "world": asked.world,
        "fingerprint": asked.fingerprint,
    }


def _tables(standing: Standing, shown: Shown | None) -> Iterator[str]:
    """What was tuned, and how it flies."""
    yield element("h2", "What was tuned") + _parameters(standing)
    if shown is None:
        return
    yield element("h2", "How often it passes every gate") + table(
        ("", "flights", "complete"),
        [(repeats.label, repeats.flights, share(repeats.complete, repeats.flights)) for repeats in shown.scene.repeats],
        numbers=(1,),
    )
    if shown.holds:
        rows = [(hold.change, share(hold.validation.successes, hold.validation.flights)) for hold in shown.holds]
        yield element("h2", "Will it hold?") + table(("the truth is", "success"), rows)


def _parameters(standing: Standing) -> str:
    """From the first guess to the best, by segment."""
    asked = standing.configuration
    first, best, kinds = asked.first_guess, standing.best, asked.course.segments.segment_classes
    rows = []
    for i, kind in enumerate(kinds):
        changes = (f"{a:.3g} → {b:.3g}" for a, b in zip(first[i].tolist(), best[i].tolist(), strict=True))
        rows.append((f"{i + 1} {kind}", *changes))
    return table(("segment", *asked.course.space.names), rows, f"first guess → {BEST}")

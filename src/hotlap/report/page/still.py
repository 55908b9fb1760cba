"""Still: what of a page is readable without JavaScript: headline, map and tables."""

from __future__ import annotations

import math
from collections.abc import Iterator

from hotlap.core.success_rate import Validation, wilson_interval
from hotlap.report.demonstration import BEST
from hotlap.report.markup import element, facts, paragraph, table, text
from hotlap.report.page.replay import Replay
from hotlap.report.page.track_map import draw_track_map
from hotlap.report.scene import Scene, stage
from hotlap.study.result import Result
from hotlap.study.snapshot import Snapshot
from hotlap.tuning.goal import Quantity


def describe_still(snapshot: Snapshot, replay: Replay | None) -> str:
    """The same study as HTML.

    Args:
        snapshot: of the study.
        replay: what was flown again; None: nothing yet.
    """
    scene = stage(snapshot.configuration.scenario) if replay is None else replay.scene
    parts = [
        element("h1", text(title_of(snapshot))),
        paragraph(summary_of(snapshot)),
        _figure(scene),
        element("h2", "Facts"),
        facts(_facts(snapshot)),
        *_tables(snapshot, replay),
        element("h2", "Run it again"),
        element("pre", element("code", text(snapshot.command))),
    ]
    return "\n".join(parts)


def title_of(snapshot: Snapshot) -> str:
    """Race and tuner."""
    return f"{snapshot.configuration.scenario.race.name}: {snapshot.configuration.tuner}"


def summary_of(snapshot: Snapshot) -> str:
    """How the study stands, in a sentence or two."""
    result = snapshot.result
    if result is None:
        return "No flights yet."
    where = "" if snapshot.finished else "The search is still running. "
    return f"{where}{_verdict(result, snapshot)} {_held(result.validation)}".strip()


def _verdict(result: Result, snapshot: Snapshot) -> str:
    """Whether it worked."""
    gates = f"{100 * result.best.completion:.0f} % of the gates"
    lap = f", a lap of {result.best.lap_time:.2f} s" if math.isfinite(result.best.lap_time) else ""
    if snapshot.configuration.settings.goal.quantity is Quantity.NONE:
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


def _facts(snapshot: Snapshot) -> dict[str, object]:
    """Figures one by one."""
    asked, result = snapshot.configuration, snapshot.result
    race, settings = asked.scenario.race, asked.settings
    return {
        "race": race.name,
        "vehicle": race.vehicle.name,
        "the controller believes in": race.control_model.name,
        "planned lap": f"{asked.scenario.reference.lap_time:.2f} s",
        "goal": str(settings.goal),
        "seed": settings.seed,
        "flights": "" if result is None else f"{result.flights} of at most {settings.budget}, re-flights included",
        "wall time": "" if result is None else f"{result.wall_time:.1f} s",
        "remark": "" if result is None else result.remark,
        "world": asked.world,
        "fingerprint": asked.fingerprint,
    }


def _tables(snapshot: Snapshot, replay: Replay | None) -> Iterator[str]:
    """What was tuned, and how it flies."""
    yield element("h2", "What was tuned") + _parameters(snapshot)
    if replay is None:
        return
    yield element("h2", "How often it passes every gate") + table(
        ("", "flights", "complete"),
        [(repeats.label, repeats.flights, share(repeats.complete, repeats.flights)) for repeats in replay.scene.repeats],
        numbers=(1,),
    )
    if replay.holds:
        rows = [(hold.change, share(hold.validation.successes, hold.validation.flights)) for hold in replay.holds]
        yield element("h2", "Will it hold?") + table(("the vehicle is", "success"), rows)


def _parameters(snapshot: Snapshot) -> str:
    """From the first guess to the best, by segment."""
    asked = snapshot.configuration
    first, best, kinds = asked.first_guess, snapshot.best, asked.scenario.segments.segment_classes
    rows = []
    for i, kind in enumerate(kinds):
        changes = (f"{a:.3g} → {b:.3g}" for a, b in zip(first[i].tolist(), best[i].tolist(), strict=True))
        rows.append((f"{i + 1} {kind}", *changes))
    return table(("segment", *asked.scenario.space.names), rows, f"first guess → {BEST}")

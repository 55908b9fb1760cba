"""Static HTML: the part of the page that needs no JavaScript: result, map of the track (SVG) and tables."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence

from hotlap.analysis.remedies import failures_of, what_to_try, why
from hotlap.analysis.robustness import Robustness
from hotlap.core.counts import count
from hotlap.core.success_rate import Validation, wilson_interval
from hotlap.report.markup import element, facts, paragraph, table, text
from hotlap.report.page.replay import BEST, Replay
from hotlap.report.page.static_map import draw_track_map
from hotlap.report.scene import Repeats, Scene, stage
from hotlap.study.kept_guess import KeptGuess, find_kept_guess
from hotlap.study.result import Result
from hotlap.study.snapshot import Snapshot
from hotlap.tuning.goal import Goal, Quantity

MOST_ENDS = 3  # of flights, that are told apart where a study failed


def render_static(snapshot: Snapshot, replay: Replay | None) -> str:
    """The study as HTML without script.

    Args:
        snapshot: of the study.
        replay: the flights of the page; None: nothing was flown again yet.
    """
    scene = stage(snapshot.configuration.scenario) if replay is None else replay.scene
    parts = [
        element("h1", text(title_of(snapshot))),
        paragraph(summary_of(snapshot)),
        *(paragraph(f"{guess.words[0].upper()}{guess.words[1:]}.") for guess in [_guess(snapshot, replay)] if guess is not None),
        *(_failure(snapshot, replay) if replay is not None and _failed(snapshot) else ()),
        _figure(scene),
        element("h2", "Facts"),
        facts(_facts(snapshot)),
        *_tables(snapshot, replay),
        element("h2", "Repeat this study"),
        element("pre", element("code", text(snapshot.command))),
    ]
    return "\n".join(parts)


def _guess(snapshot: Snapshot, replay: Replay | None) -> KeptGuess | None:
    """The guess that was kept."""
    return find_kept_guess(snapshot.configuration, snapshot.result, None if replay is None else replay.errors)


def title_of(snapshot: Snapshot) -> str:
    """Title of the page: race and tuner."""
    return f"{snapshot.configuration.scenario.race.name}: {snapshot.configuration.tuner}"


def summary_of(snapshot: Snapshot) -> str:
    """The result of the study so far, in one or two sentences."""
    result = snapshot.result
    if result is None:
        return "No flights yet."
    where = "" if snapshot.finished else "The search is still running. "
    return f"{where}{_verdict(result, snapshot)} {_validated(result.validation)}".strip()


def _verdict(result: Result, snapshot: Snapshot) -> str:
    """Whether the goal was confirmed, after how many flights, and how good the best flight is."""
    gates = f"{100 * result.best.completion:.0f} % of the gates"
    lap = f", a lap of {result.best.lap_time:.2f} s" if math.isfinite(result.best.lap_time) else ""
    if snapshot.configuration.settings.goal.quantity is Quantity.NONE:
        return f"{count(result.flights, 'flight')}; the {BEST} parameters passed {gates}{lap}."
    if result.best.confirmed:
        return f"{result.goal} confirmed after {count(result.search_flights, 'search flight')}: {gates}{lap}."
    return f"{result.goal} NOT confirmed in {count(result.flights, 'flight')}; the parameters that are kept passed {gates}{lap}."


def _validated(validation: Validation | None) -> str:
    """The success rate in validation flights."""
    return "" if validation is None else f"Success rate in the validation: {share(validation.successes, validation.flights)}."


def share(successes: int, flights: int) -> str:
    """A success rate with its interval: 97 of 100 flights (95 % interval 92 to 99 %)."""
    low, high = wilson_interval(successes, flights)
    return f"{successes} of {count(flights, 'flight')} (95 % interval {100 * low:.0f} to {100 * high:.0f} %)"


def _figure(scene: Scene) -> str:
    """The map with a caption."""
    fastest = float(scene.traces[0].speed.max(initial=0.0)) if scene.traces else scene.reference.max_speed
    what = f"flight with the {scene.traces[0].label} parameters, {scene.traces[0].ending}" if scene.traces else "plan"
    words = f"{what}; colour: speed, from violet (0 m/s) to yellow ({fastest:.1f} m/s); {_legend(scene)}"
    crosses = "; red crosses: where failed flights ended" if any(len(positions) for positions in scene.failures) else ""
    return element("figure", draw_track_map(scene) + element("figcaption", text(words + crosses)))


def _legend(scene: Scene) -> str:
    """What the marks of a scene's structures mean."""
    known = scene.structures
    if known.plain:
        return f"circles: gates, radius {scene.distance:g} m"
    parts = ["outlines: openings of the gates"]
    parts += ["arrows: the way in which they are passed"] * any(gate.normal is not None for gate in known.gates)
    parts += ["circles: gates without an orientation"] * any(gate.plane is None for gate in known.gates)
    parts += ["grey: obstacles"] * bool(known.obstacles)
    limits = [name for name in ("box", "floor", "ceiling") if getattr(known, name) is not None]
    return "; ".join([*parts, *[f"dotted: {', '.join(limits)}"] * bool(limits)])


def _facts(snapshot: Snapshot) -> dict[str, object]:
    """Settings and results as a list of facts."""
    asked, result = snapshot.configuration, snapshot.result
    race, settings = asked.scenario.race, asked.settings
    return {
        "race": race.name,
        "vehicle": race.vehicle.name,
        "model in the controller": race.control_model.name,
        "planned lap time": f"{asked.scenario.reference.lap_time:.2f} s",
        "goal": str(settings.goal),
        "seed": settings.seed,
        "flights": "" if result is None else f"{result.flights} of at most {settings.budget}, re-flights included",
        "search time": "" if result is None else f"{result.wall_time:.1f} s",
        "remark": snapshot.remark,
        "world": asked.world,
        "fingerprint": asked.fingerprint,
    }


def _tables(snapshot: Snapshot, replay: Replay | None) -> Iterator[str]:
    """Tables: parameters, success rates, and robustness."""
    yield element("h2", "Tuned parameters") + _parameters(snapshot)
    if replay is None:
        return
    yield element("h2", "Flights that passed every gate") + table(
        ("parameters", "flights", "passed every gate"),
        [(repeats.label, repeats.flights, share(repeats.complete, repeats.flights)) for repeats in replay.scene.repeats],
        numbers=(1,),
    )
    if replay.robustness:
        yield element("h2", "Robustness: the tuned parameters under other conditions") + _robustness(
            replay.robustness, asked=bool(snapshot.hold)
        )
    if not _failed(snapshot):
        yield from _advice(snapshot, replay)


def _failed(snapshot: Snapshot) -> bool:
    """Whether a study has ended without what it was after."""
    asked, result = snapshot.configuration, snapshot.result
    return snapshot.finished and result is not None and not result.best.confirmed and asked.settings.goal.quantity is not Quantity.NONE


def _failure(snapshot: Snapshot, replay: Replay) -> Iterator[str]:
    """Why a study failed, as its flights ended and as far as causes are known, and what to try."""
    flown = _flown(replay.scene.repeats[0], snapshot.configuration.settings.goal) if replay.scene.repeats else ()
    yield element("h2", "Why it failed") + _list([*flown, *why(failures_of(replay.robustness[:1]))])
    yield from _advice(snapshot, replay)


def _flown(repeats: Repeats, goal: Goal) -> Iterator[str]:
    """How the new flights of a study that failed ended, the most frequent ends first."""
    of = f"{repeats.flights} new flights"
    if repeats.complete == repeats.flights:
        missing = "was not confirmed in the search" if goal.quantity is Quantity.COMPLETION else "asks for more"
        yield f"all {of} passed every gate, but the goal ({goal}) {missing}"
        return
    yield from (f"{number} of {of} {end}" for end, number in Counter(repeats.ends).most_common(MOST_ENDS))
    unknown = repeats.flights - repeats.complete - len(repeats.ends)
    if unknown:
        yield f"{unknown} of {of} did not pass every gate, and where they ended is not known"


def _advice(snapshot: Snapshot, replay: Replay) -> Iterator[str]:
    """What to try where flights fail."""
    advice = what_to_try(failures_of(replay.robustness), snapshot.advice)
    if advice:
        yield element("h2", "What to try") + _list(advice)


def _list(lines: Sequence[str]) -> str:
    return element("ul", "".join(element("li", text(line)) for line in lines))


def _robustness(robustness: Sequence[Robustness], *, asked: bool) -> str:
    """A row for each condition: success rate, what is left of the thrust, and why flights fail."""
    heads = ("condition", "success rate", "thrust over what is needed", "why flights fail", *["asked for"] * asked)
    rows = []
    for one in robustness:
        thrust, why = "" if one.margin is None else one.margin.figure, f"{one.causes[0].cause}: {one.causes[0].found}" if one.causes else ""
        rows.append((one.change, share(one.validation.successes, one.validation.flights), thrust, why, *["yes" * one.asked] * asked))
    return table(heads, rows)


def _parameters(snapshot: Snapshot) -> str:
    """First guess and best value of each parameter in each segment."""
    asked = snapshot.configuration
    first, best, kinds = asked.first_guess, snapshot.best, asked.scenario.segments.segment_classes
    rows = []
    for i, kind in enumerate(kinds):
        changes = (f"{a:.3g} → {b:.3g}" for a, b in zip(first[i].tolist(), best[i].tolist(), strict=True))
        rows.append((f"{i + 1} {kind}", *changes))
    return table(("segment", *asked.scenario.space.names), rows, f"first guess → {BEST}")

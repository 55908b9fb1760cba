"""Remedies: what to try where flights fail, from all that was found out about it, in one list, each once."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from hotlap.analysis.diagnosis import Diagnosis
from hotlap.analysis.robustness import Robustness
from hotlap.race.conditions import UNCHANGED

SETTING = re.compile(r"\b([a-z_]+\.[a-z_]+|takes at most)(?: =)? (\[[^\]]*\]|[^\s,;]*[^\s,;:])")  # of a race, or a plan, with its value
SLOWER = ("planning.thrust_share", "takes at most")  # settings that make a plan slower: the least does for all
SLOWER_PLANS = "slower plans"

Failures = Sequence[tuple[str, Sequence[Diagnosis]]]


@dataclass(frozen=True)
class _Told:
    """One piece of advice.

    Attributes:
        words: what to do.
        change: what that changes, in words that do not recommend it.
        condition: under which flights fail; "" where it is not about one.
        proof: what flights without the cause gave, in words; "" where there were none.
        studied: whether it was found out by other means than these flights.
        helps: whether it did any good where it was flown.
    """

    words: str
    change: str
    condition: str = ""
    proof: str = ""
    studied: bool = False
    helps: bool = True

    @property
    def name(self) -> str:
        """What it is, in words that do not recommend it: all slower plans are one thing."""
        return SLOWER_PLANS if self.setting in SLOWER else self.change

    @property
    def setting(self) -> str:
        """What it would set, or what it says: advice with the same is told once."""
        found = SETTING.search(self.words)
        return found[1] if found else self.words

    @property
    def value(self) -> str:
        """What it would be set to; "" where it is no setting."""
        found = SETTING.search(self.words)
        return found[2] if found else ""

    def reason(self, value: str) -> str:
        """For which condition it is, with its value where that is another."""
        told = ", ".join(part for part in (self.value if self.value != value else "", self.proof) if part)
        return ": ".join(part for part in (self.condition, told) if part)


def failures_of(robustness: Sequence[Robustness], causes: Sequence[Diagnosis] = ()) -> Failures:
    """Why flights fail, by the names of the conditions under which they do: all causes as tuned, else the likeliest one.

    The name is "" where nothing but one set of flights is known.

    Args:
        robustness: of all conditions, as tuned first; empty where they were not flown.
        causes: of flights as tuned, where these are others.
    """
    tuned = [(UNCHANGED.name if robustness else "", tuple(causes))] if causes else []
    rows = [(one.change, one.causes[: None if one.condition == UNCHANGED else 1]) for one in robustness]
    return [*tuned, *((name, found) for name, found in rows if found and not (tuned and name == UNCHANGED.name))]


def why(failures: Failures) -> Iterator[str]:
    """A line for each cause, with the conditions under which it makes flights fail."""
    found = dict[str, list[str]]()
    for condition, causes in failures:
        for cause in causes:
            found.setdefault(f"{cause.cause}: {cause.found}", []).append(condition)
    yield from (f"{', '.join(conditions)}: {words}" if any(conditions) else words for words, conditions in found.items())


def what_to_try(failures: Failures, further: Sequence[str] = ()) -> tuple[str, ...]:
    """A line for each thing to try, with the conditions that it is for and what flights with it gave; each setting once.

    Args:
        failures: from `failures_of`.
        further: what else was found out, as by tuning calmer plans; it comes first.
    """
    told = [_Told(words, words, studied=True) for words in further]
    told += [_Told(one.advice, one.named, condition, one.proof, helps=one.helps) for condition, causes in failures for one in causes]
    groups = dict[str, list[_Told]]()
    for one in told:
        if one.helps:
            groups.setdefault(one.setting, []).append(one)
    return (*map(_line, groups.values()), *_vain([one for one in told if not one.helps]))


def _line(group: Sequence[_Told]) -> str:
    """What is to be set, or done, and why."""
    first = group[0]
    if first.setting in SLOWER and not first.studied:  # the calmest plan does for all of them
        first = min(group, key=lambda one: float(one.value))
    reasons = dict.fromkeys(reason for one in group if not one.studied and (reason := one.reason(first.value)))
    return f"{first.words} ({'; '.join(reasons)})" if reasons else first.words


def _vain(told: Sequence[_Told]) -> Iterator[str]:
    """What does not help where it is the only change, in one line."""
    groups = dict[str, list[_Told]]()
    for one in told:
        groups.setdefault(one.name, []).append(one)
    named = [f"{name}{f' ({conditions})' if (conditions := _conditions(group)) else ''}" for name, group in groups.items()]
    if named:
        plural = len(named) > 1 or SLOWER_PLANS in groups
        yield f"{', '.join(named)} alone {'do' if plural else 'does'} not help: {', '.join(dict.fromkeys(one.proof for one in told))}"


def _conditions(group: Sequence[_Told]) -> str:
    """For which it was tried."""
    return ", ".join(dict.fromkeys(one.condition for one in group if one.condition))

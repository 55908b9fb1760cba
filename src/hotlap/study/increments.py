"""Increments: a state that grows, kept as what each batch changed in it.

A tuner's state holds its whole history; written whole at every batch, a study of n batches would write O(n^2) bytes. Written as
increments it is O(n), for a list that has grown is kept as the items that were added.
"""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from typing import Any

INSIDE, ADDED, VALUE = "inside", "added", "value"  # entries of a table that changed, items behind a list, or another value


def increment(before: Any, after: Any) -> dict[str, Any]:
    """What turns one value into another, both plain JSON; a list that has grown is described by its new items alone.

    Args:
        before: shares no list and no table with `after`, in which its owner may go on writing.
        after: the value wanted.
    """
    if isinstance(before, dict) and isinstance(after, dict) and list(before) == list(after):
        return {INSIDE: {key: increment(before[key], after[key]) for key in after if not _is_same(before[key], after[key])}}
    if isinstance(before, list) and isinstance(after, list) and before and _is_same(before, after[: len(before)]):
        return {ADDED: after[len(before) :]}
    return {VALUE: after}


def grow(before: Any, change: Mapping[str, Any]) -> Any:
    """A value after an increment."""
    if INSIDE in change:
        return {**before, **{key: grow(before[key], inner) for key, inner in change[INSIDE].items()}}
    return [*before, *change[ADDED]] if ADDED in change else change[VALUE]


def _is_same(before: Any, after: Any) -> bool:
    """Whether two values are the same to the last bit: 0 is not 0.0, and 0.0 not -0.0, though Python calls them equal."""
    return before == after and pickle.dumps(before) == pickle.dumps(after)

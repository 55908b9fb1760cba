"""Increments put together give the state again, to the last bit, and what has not changed is not written again."""

from __future__ import annotations

import json
from functools import reduce

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hotlap.study.increments import grow, increment

LEAVES = st.none() | st.booleans() | st.integers(-3, 3) | st.sampled_from([0.0, -0.0, 1.0, 0.1]) | st.sampled_from(["a", "b"])
VALUES = st.recursive(
    LEAVES, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from("xyz"), inner, max_size=3), max_leaves=8
)


@given(st.lists(VALUES, min_size=1, max_size=5))
def test_increments_one_after_the_other_give_every_state(states):
    before, kept = None, []
    for state in states:
        kept.append(json.dumps(increment(before, state)))
        before = reduce(grow, map(json.loads, kept), None)
        assert json.dumps(before) == json.dumps(state), "also where Python calls two numbers equal that are not the same"


@given(VALUES, st.lists(VALUES, min_size=1, max_size=3), st.lists(VALUES, max_size=3))
def test_of_a_list_that_has_grown_the_new_items_are_kept(other, known, new):
    before, after = {"other": other, "history": known}, {"other": other, "history": [*known, *new]}
    assert increment(before, after) == {"inside": {"history": {"added": new}} if new else {}}


@pytest.mark.parametrize("after", [[1.0, 2.0], [2.0], [], [0.0, 1.0, 2.0], [[1.0], [2.0], [3.0]]])
def test_a_history_that_was_rewritten_is_kept_whole(after):
    assert increment([1.0, 2.5], after) == {"value": after}


def test_what_was_kept_is_not_touched_by_a_later_increment():
    before = {"history": [[1.0]], "more": {"count": 1}}
    text = json.dumps(before)
    grow(before, json.loads(json.dumps(increment(before, {"history": [[1.0], [2.0]], "more": {"count": 2}}))))
    assert json.dumps(before) == text

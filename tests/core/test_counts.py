"""One thing is not several."""

from __future__ import annotations

import pytest

from hotlap.core.counts import count


@pytest.mark.parametrize(("number", "words"), [(0, "0 gates"), (1, "1 gate"), (2, "2 gates")])
def test_one_thing_is_not_several(number, words):
    assert count(number, "gate") == words

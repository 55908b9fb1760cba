"""A file is read for what it holds."""

from __future__ import annotations

import tracemalloc

import pytest

from hotlap.core.errors import InputError
from hotlap.system.regular_files import PART, read_bytes


def test_a_high_limit_costs_no_memory(tmp_path):
    (tmp_path / "small").write_bytes(b"content")
    tracemalloc.start()
    try:
        assert read_bytes(tmp_path / "small", 2_000_000_000) == b"content"
        assert tracemalloc.get_traced_memory()[1] < 3 * PART
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("size", [0, 1, PART - 1, PART, PART + 1, 3 * PART])
def test_all_of_it_is_read_up_to_the_limit(tmp_path, size):
    content = bytes(range(256)) * (size // 256) + b"x" * (size % 256)
    (tmp_path / "file").write_bytes(content)
    assert read_bytes(tmp_path / "file", size) == content
    if size:
        with pytest.raises(InputError, match="is larger than"):
            read_bytes(tmp_path / "file", size - 1)

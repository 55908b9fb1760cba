"""`hotlap.identify` reads what `hotlap.logs` reads: the same flight gives the same numbers, whichever program wrote it."""

from __future__ import annotations

import numpy as np
import pytest

import hotlap
from hotlap.core.errors import InputError
from logs.written import make_flight, write_csv, write_ulog


def test_a_log_of_another_program_is_read_before_anything_is_fitted(tmp_path, monkeypatch):
    seen = []

    def look(logs, *_, **__):
        seen.extend(logs)
        raise InputError("", "logs", "enough")

    monkeypatch.setattr("hotlap.api.identified.identify", look)
    flight = make_flight()
    files = [write_ulog(tmp_path / "a.ulg", flight), write_csv(tmp_path / "b.csv", flight)]
    keys = [None, {"time": "stamp", "rates": "gx gy gz"}]
    for file, key in zip(files, keys, strict=True):
        with pytest.raises(InputError, match="enough"):
            hotlap.identify(file, quadrotor="five-inch", map=key)
    assert [log.kind for log in seen] == ["a ULog of PX4", "a CSV table"]
    np.testing.assert_allclose(seen[0].signals["rates"].values, seen[1].signals["rates"].values, atol=1e-5)

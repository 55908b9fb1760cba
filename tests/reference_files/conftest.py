"""A flight to be read, and the columns of its file."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.reference.reference import Reference
from hotlap.reference.run_out import extend
from hotlap.reference_files.csv import COLUMNS, save_reference
from planning import small

from .flights import RACE, Columns


@pytest.fixture(scope="package")
def reference() -> Reference:
    """A plan with its run-out."""
    return extend(small.planned("drag")[3], RACE.planning_model.gravity, RACE.planning_drag)


@pytest.fixture(scope="package")
def whole(reference, tmp_path_factory) -> Columns:
    """The columns of its file."""
    path = tmp_path_factory.mktemp("whole") / "flight.csv"
    save_reference(path, reference)
    return dict(zip(COLUMNS, np.genfromtxt(path, delimiter=",", skip_header=1).T, strict=True))

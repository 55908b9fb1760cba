"""Experiments by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from hotlap.analysis.resumable import Context
from hotlap.reproduce.experts import experts
from hotlap.reproduce.initialisations import initialisations
from hotlap.reproduce.landscapes import landscape
from hotlap.reproduce.page import Page
from hotlap.reproduce.robustness import robustness
from hotlap.reproduce.tables import table1, table2, table3

Experiment = Callable[[Context], Page]

EXPERIMENTS: Mapping[str, Experiment] = {
    "table1": table1,
    "table2": table2,
    "table3": table3,
    "landscape": landscape,
    "experts": experts,
    "robustness": robustness,
    "initialisations": initialisations,
}

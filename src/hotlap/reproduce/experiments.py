"""Experiments by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from hotlap.analysis.resumable import ResumableJobs
from hotlap.report.article import Article
from hotlap.reproduce.experts import experts
from hotlap.reproduce.initialisations import initialisations
from hotlap.reproduce.landscapes import landscape
from hotlap.reproduce.robustness import robustness
from hotlap.reproduce.tables import table1, table2, table3


class Experiment(Protocol):
    """An experiment of the paper."""

    def __call__(self, jobs: ResumableJobs, *, quick: bool) -> Article:
        """Fly what is missing, and write what was found.

        Args:
            jobs: keeps results, and the pictures of the page in its folder.
            quick: the short form, under a minute.
        """
        ...


EXPERIMENTS: Mapping[str, Experiment] = {
    "table1": table1,
    "table2": table2,
    "table3": table3,
    "landscape": landscape,
    "experts": experts,
    "robustness": robustness,
    "initialisations": initialisations,
}

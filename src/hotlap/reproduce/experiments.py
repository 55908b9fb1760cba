"""Experiments by name; none is loaded before it is performed."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Protocol

from hotlap.core.errors import InputError

if TYPE_CHECKING:
    from hotlap.analysis.resumable import ResumableJobs
    from hotlap.report.article import Article


class UnavailableError(InputError):
    """An experiment needs something that is not installed."""


class Experiment(Protocol):
    """An experiment of the paper."""

    def __call__(self, jobs: ResumableJobs, *, quick: bool) -> Article:
        """Fly what is missing, and write what was found.

        Args:
            jobs: keeps results, and the pictures of the page in its folder.
            quick: the short form, under a minute.

        Raises:
            UnavailableError: something that it needs is not installed.
        """
        ...


EXPERIMENTS: Mapping[str, str] = {
    "table1": "tables",
    "table2": "tables",
    "table3": "tables",
    "landscape": "landscapes",
    "experts": "experts",
    "robustness": "robustness",
    "initialisations": "initialisations",
    "real_world": "real_world",
}
"""The module of this package that holds the function of each name."""


SHORT = (
    "**Quick form**: fewer flights, seeds and races than the paper has, to see that it runs. Its figures say little; without `--quick` the "
    "whole experiment is flown."
)


def perform(name: str, jobs: ResumableJobs, *, quick: bool) -> Article:
    """Fly what is missing of an experiment, and write what was found.

    Args:
        name: one of `EXPERIMENTS`.
        jobs: keeps results, and the pictures of the page in its folder.
        quick: the short form, under a minute.

    Raises:
        UnavailableError: something that it needs is not installed.
    """
    experiment: Experiment = getattr(import_module(f"hotlap.reproduce.{EXPERIMENTS[name]}"), name)
    article = experiment(jobs, quick=quick)
    if quick:
        from hotlap.report.article import Paragraph  # noqa: PLC0415  the experiment has loaded it

        article.parts.insert(0, Paragraph(SHORT))
    return article

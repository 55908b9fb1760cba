"""Experiments by name; none is loaded before it is performed."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hotlap.analysis.resumable import Context
    from hotlap.reproduce.page import Page

EXPERIMENTS: Mapping[str, str] = {
    "table1": "tables",
    "table2": "tables",
    "table3": "tables",
    "landscape": "landscapes",
    "experts": "experts",
    "robustness": "robustness",
    "initialisations": "initialisations",
}
"""The module of this package that holds the function of each name."""


def perform(name: str, context: Context) -> Page:
    """Do what is missing of an experiment.

    Args:
        name: one of `EXPERIMENTS`.
        context: where its results are kept, and how it is done.
    """
    return getattr(import_module(f"hotlap.reproduce.{EXPERIMENTS[name]}"), name)(context)

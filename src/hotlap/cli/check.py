"""`hotlap check FILE`: what a track, quadrotor or race means."""

from __future__ import annotations

from argparse import Namespace

from rich.text import Text

from hotlap.check import Finding, Level, describe
from hotlap.cli.output import present, table
from hotlap.errors import PlanningError
from hotlap.files import TYPES, Description, load
from hotlap.planning import cache
from hotlap.planning.problem import Problem
from hotlap.race import Race

STYLES = {Level.FACT: "", Level.NOTE: "yellow", Level.WARNING: "bold red"}


def run(options: Namespace) -> int:
    """Say it; a warning is a finding, not a failure."""
    description = load(options.file)
    kind = next(kind for kind, described in TYPES.items() if isinstance(description, described))
    findings = describe(description, _planned_top_speed(description))
    document = {"kind": kind, "name": description.name, "findings": [vars(finding) for finding in findings]}
    cells = table([(finding.label, _value(finding), finding.remark) for finding in findings], indent="  ")
    styled = (Text(line, style=STYLES[finding.level]) for line, finding in zip(cells, findings, strict=True))
    lines = [Text(f"{kind} {description.name}", style="bold"), *styled]
    present(as_json=options.json, document=document, lines=lines)
    return 0


def _planned_top_speed(description: Description) -> float | None:
    """[m/s] of a race's plan, if it has been planned before: planning now would take too long."""
    if not isinstance(description, Race):
        return None
    try:
        reference = cache.load(cache.key(Problem.of(description)))
    except PlanningError:
        return None
    return None if reference is None else float(reference.speeds.max())


def _value(finding: Finding) -> str:
    """The figure, marked where it matters, also without colours."""
    return finding.value if finding.level is Level.FACT else f"{finding.level}: {finding.value}"

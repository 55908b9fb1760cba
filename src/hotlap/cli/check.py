"""`hotlap check FILE`: what a track, quadrotor or race means."""

from __future__ import annotations

import shlex
import shutil
from argparse import Namespace
from collections.abc import Sequence

from rich.text import Text

from hotlap.cli.output import present, table
from hotlap.core.errors import PlanningError
from hotlap.files.descriptions import TYPES, Description, Kind, load
from hotlap.planning import cache
from hotlap.planning.feasibility import Finding, Level, describe
from hotlap.planning.problem import Problem
from hotlap.race.race import Race
from hotlap.race.track import Track

WIDEST = 100  # columns of a map
ROLES = {Kind.TRACK: "track", Kind.QUADROTOR: "vehicle"}  # in a race
STYLES = {Level.FACT: "", Level.NOTE: "yellow", Level.WARNING: "bold red"}


def run(options: Namespace) -> int:
    """Say it; a warning is a finding, not a failure."""
    description = load(options.file)
    kind = next(kind for kind, described in TYPES.items() if isinstance(description, described))
    findings = describe(description, _planned_top_speed(description))
    document = {"kind": kind, "name": description.name, "findings": [vars(finding) for finding in findings]}
    cells = table([(finding.label, _value(finding), finding.remark) for finding in findings], indent="  ")
    styled = (Text(line, style=STYLES[finding.level]) for line, finding in zip(cells, findings, strict=True))
    title, further = Text(f"{kind} {description.name}", style="bold"), f"next: {_next(kind, options.file, findings)}"
    lines = [title, *styled, *_picture(description), further]
    present(as_json=options.json, document=document, lines=lines)
    return 0


def _picture(description: Description) -> list[str]:
    """A track as a map: a wrong sign shows at once."""
    if not isinstance(description, Track):
        return []
    from hotlap.report.map import draw_track  # noqa: PLC0415  only for tracks

    width = min(shutil.get_terminal_size().columns, WIDEST)
    return draw_track(description, width=width, height=width // 4).splitlines()


def _next(kind: Kind, file: str, findings: Sequence[Finding]) -> str:
    """The command that one would give now."""
    name = shlex.quote(file)
    command = f"hotlap tune {name}" if kind is Kind.RACE else f"hotlap new race NAME --{ROLES[kind]} {name}"
    return f"see to the warnings, then {command}" if any(finding.level is Level.WARNING for finding in findings) else command


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

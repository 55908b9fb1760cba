"""`hotlap check FILE`: what a track, quadrotor or race means."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from argparse import Namespace
from collections.abc import Sequence

from rich.text import Text

from hotlap.api.asked import command_line
from hotlap.api.checked import CheckedFile
from hotlap.api.checking import check
from hotlap.api.tuning import tune
from hotlap.cli.options import arguments_of
from hotlap.cli.output import present, table
from hotlap.cli.parser import wrapped
from hotlap.cli.progress import TERMINAL
from hotlap.feasibility.finding import Finding, Level
from hotlap.files.descriptions import Kind
from hotlap.race.race import Race
from hotlap.race.track import Track

WIDEST = 100  # columns of a map
ROLES = {Kind.TRACK: "track", Kind.QUADROTOR: "vehicle"}  # in a race
STYLES = {Level.FACT: "", Level.NOTE: "yellow", Level.WARNING: "bold red"}


def run(options: Namespace) -> int:
    """Say it; a warning is a finding, not a failure."""
    checked = check(**arguments_of(check, options), progress=TERMINAL)
    findings = checked.findings
    cells = wrap_remarks([(finding.label, _value(finding), finding.remark) for finding in findings], _columns())
    styled = (Text(line, style=STYLES[finding.level]) for lines, finding in zip(cells, findings, strict=True) for line in lines)
    title, further = Text(f"{checked.kind} {checked.description.name}", style="bold"), f"next: {_next(checked, options)}"
    lines = [title, *styled, *_picture(checked), further]
    present(as_json=options.json, document=checked.to_dict(), lines=lines)
    return 0


def wrap_remarks(rows: Sequence[tuple[str, str, str]], columns: int | None) -> list[list[str]]:
    """The lines of each row: label, value and remark as columns; where these are too wide, each remark goes on from its value.

    Args:
        rows: cells.
        columns: of the terminal; None: however many it takes.
    """
    whole = table(rows, indent="  ")
    if columns is None or max(map(len, whole), default=0) <= columns:
        return [[line] for line in whole]
    room = max(len(label) for label, _, _ in rows)
    first = [f"  {label:<{room}}  {value}{'  ' * bool(remark)}" for label, value, remark in rows]
    lines = (wrapped(remark, columns, " " * (room + 4), start).splitlines() for start, (_, _, remark) in zip(first, rows, strict=True))
    return [found or [start] for found, start in zip(lines, first, strict=True)]


def _columns() -> int | None:
    """Of the terminal, or as `COLUMNS` says; None where neither is there, so that each finding stays on one line."""
    return shutil.get_terminal_size().columns if "COLUMNS" in os.environ or sys.stdout.isatty() else None


def _picture(checked: CheckedFile) -> list[str]:
    """A track as a map, and that of a race whose gates have openings: a wrong sign shows at once."""
    track = checked.description.track if isinstance(checked.description, Race) else checked.description
    if not isinstance(track, Track) or (checked.kind is Kind.RACE and not track.has_openings):
        return []
    from hotlap.report.map import draw_track  # noqa: PLC0415  only for tracks

    width = min(shutil.get_terminal_size().columns, WIDEST)
    return draw_track(track, width=width, height=width // 4).splitlines()


def _next(checked: CheckedFile, options: Namespace) -> str:
    """The command that one would give now."""
    if checked.kind is Kind.RACE:
        same = {name: getattr(options, name) for name in ("reference", "segments", "controller")}
        command = command_line(tune, {"race": options.file, **same})
    else:
        command = f"hotlap new race NAME --{ROLES[checked.kind]} {shlex.quote(options.file)}"
    return f"see to the warnings, then {command}" if checked.warned else command


def _value(finding: Finding) -> str:
    """The figure, marked where it matters, also without colours."""
    return finding.value if finding.level is Level.FACT else f"{finding.level}: {finding.value}"

"""Identified: a quadrotor's numbers as logs of its flights tell them, and files of them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hotlap.api.asked import Asked
from hotlap.api.identifying import KNOWN
from hotlap.api.inputs import as_path, check_target
from hotlap.api.outcome import Outcome
from hotlap.core.counts import count
from hotlap.core.errors import InputError, UnknownNameError
from hotlap.files.descriptions import load_quadrotor, names
from hotlap.files.kinds import Kind
from hotlap.identification.estimates import Estimate
from hotlap.identification.holding import hold_of
from hotlap.identification.identify import STAGES, Identification, identify
from hotlap.identification.quadrotor_file import quadrotor_of, text_of
from hotlap.logs.key_map import asked_map
from hotlap.logs.readers import read
from hotlap.logs.window import check_window, cut
from hotlap.race.quadrotor import Quadrotor
from hotlap.report.formats import SUFFIXES
from hotlap.system.text_files import replace

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class IdentifiedQuadrotor(Outcome):
    """What logs say of a quadrotor.

    Attributes:
        quadrotor: the base with what they tell.
        identification: all of it: estimates with intervals, thrust map, predictions where the logs were not fitted.
        file: that was written; None where none was asked for.
        picture: likewise.
    """

    quadrotor: Quadrotor
    identification: Identification
    file: Path | None = None
    picture: Path | None = None

    @property
    def estimates(self) -> tuple[Estimate, ...]:
        """Of each number, with its interval."""
        return self.identification.estimates

    def facts(self) -> dict[str, str]:
        """What was identified from what, and the files."""
        found = self.identification
        return {
            "title": f"{found.base.name}, from {count(len(found.logs), 'log')} of {found.seconds:.0f} s",
            "told": f"{len(found.estimates) - len(found.untold)} of {len(found.estimates)} numbers",
            "file": str(self.file or ""),
            "picture": str(self.picture or ""),
        }

    @property
    def hold(self) -> str:
        """What the intervals leave open, in the words of `--hold`: `hotlap.tune(race, hold=found.hold)`."""
        return hold_of(self.estimates)

    def rows(self) -> list[dict[str, Any]]:
        """A row for each number."""
        return [one.dump() for one in self.estimates]

    def to_dict(self) -> dict[str, Any]:
        """The keys of `hotlap identify --json`."""
        files = {name: None if path is None else str(path) for name, path in (("file", self.file), ("picture", self.picture))}
        return {**self.identification.to_dict(), "hold": self.hold, **files}

    def plot(self) -> Figure:
        """Predicted against measured, on the seconds of the first log that were not fitted."""
        from hotlap.report.identification_chart import identification  # noqa: PLC0415  matplotlib, only where there is something to draw

        return identification(self.identification)


def carry_out(asked: Asked) -> IdentifiedQuadrotor:
    """Check what was asked for, fit, and write."""
    known = _known(asked.known)
    given = [asked.logs] if isinstance(asked.logs, str | Path) else list(asked.logs)
    if not given:
        raise InputError("", "logs", "at least one is needed")
    check_window(asked.window)
    out, picture = as_path(asked.out), as_path(asked.picture)
    check_target(out, (".toml",))
    check_target(picture, SUFFIXES)
    base = load_quadrotor(asked.quadrotor)
    keys = asked_map(asked.map)
    logs = [cut(read(path, keys), asked.window) for path in given]
    with asked.progress.pieces("stages", STAGES, 0, even=False) as say:
        found = identify(logs, base, thrust_known="thrust" in known, loop_known="rate_loop" in known, say=say)
    label = str(out or asked.quadrotor)
    identified = IdentifiedQuadrotor(quadrotor_of(found, label), found, out, picture)
    if out is not None:
        replace(out, text_of(found, _from(out, asked.quadrotor)))
    if picture is not None:
        from hotlap.report.pictures import save  # noqa: PLC0415  matplotlib, only where there is something to draw

        save(picture, identified.plot())
    return identified


def _known(asked: str | Sequence[str]) -> tuple[str, ...]:
    """What of the base is taken to be right."""
    given = tuple(part.strip() for part in asked.split(",")) if isinstance(asked, str) else tuple(asked)
    for name in given:
        if name not in KNOWN:
            raise UnknownNameError("quantity", str(name), KNOWN, key="known")
    if len({"mass", "thrust"} & {*given}) != 1 or len({*given}) < len(given):
        raise InputError("", "known", "a log cannot tell mass from thrust: one of the two, not both, has to be known")
    return given


def _from(out: Path, base: str | Path) -> str:
    """The base as the file that is written calls it: by name, or by its path from there."""
    if str(base) in names(Kind.QUADROTOR):
        return str(base)
    return Path(os.path.relpath(Path(base).resolve(), out.resolve().parent)).as_posix()

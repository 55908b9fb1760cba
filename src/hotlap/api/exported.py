"""Exported: what was written for other programs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hotlap.api.asked import Asked
from hotlap.api.inputs import as_path, check_target
from hotlap.api.outcome import Outcome
from hotlap.exporters import export
from hotlap.exporters.formats import FORMATS
from hotlap.study.study import Study


@dataclass(frozen=True, repr=False)
class ExportedFiles(Outcome):
    """Files of a study for another program.

    Attributes:
        race: its name.
        format: of which program.
        files: that were written.
        confirmed: whether the parameters reached the goal in all re-flights.
    """

    race: str
    format: str
    files: tuple[Path, ...]
    confirmed: bool

    def facts(self) -> dict[str, str]:
        """What was written, and whether it was confirmed."""
        files = ", ".join(map(str, self.files))
        return {"race": f"{self.race} as {self.format}", "files": files, "confirmed": "confirmed" if self.confirmed else "not confirmed"}

    def rows(self) -> list[dict[str, Any]]:
        """A row for each file."""
        return [{"race": self.race, "format": self.format, "file": str(file), "confirmed": self.confirmed} for file in self.files]

    def to_dict(self) -> dict[str, Any]:
        """The keys of `hotlap export --json`."""
        return {"race": self.race, "format": self.format, "files": list(map(str, self.files)), "confirmed": self.confirmed}


def carry_out(asked: Asked) -> ExportedFiles:
    """Write them."""
    out = as_path(asked.out)
    check_target(out)
    with Study.read(asked.folder) as study:
        files = export(study, asked.format, out)
        race, result = study.configuration.scenario.race.name, study.result
    confirmed = result is not None and result.best.confirmed
    if FORMATS[asked.format].finished and not confirmed:
        asked.progress.note(f"note: {asked.folder}: these parameters were not confirmed: they did not reach the goal in all re-flights")
    return ExportedFiles(race, asked.format, files, confirmed)

"""Planned: a minimum-time reference with its segments, and files of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hotlap.api.asked import Asked
from hotlap.api.inputs import as_path, check_source, check_target
from hotlap.api.outcome import Outcome
from hotlap.api.scenarios import load, make_scenario
from hotlap.api.wording import seconds
from hotlap.core.counts import count
from hotlap.reference.reference import Reference
from hotlap.reference.scenario import Scenario
from hotlap.reference_files.csv import save_reference
from hotlap.report.formats import SUFFIXES

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class PlannedReference(Outcome):
    """The reference of a race, cut into segments.

    Attributes:
        scenario: race, reference and segments.
        csv: the file of the reference; None where none was asked for.
        picture: the file of its picture; None where none was asked for.
    """

    scenario: Scenario
    csv: Path | None = None
    picture: Path | None = None

    @property
    def reference(self) -> Reference:
        """The planned flight, row by row."""
        return self.scenario.reference

    def facts(self) -> dict[str, str]:
        """Duration, speeds, segments and files."""
        reference, segments = self.reference, self.scenario.segments
        return {
            "race": f"{self.scenario.race.name}: {count(len(reference.gate_times), 'gate')} in {seconds(reference.lap_time)}",
            "top speed": f"top speed {reference.speeds.max():.1f} m/s",
            "segments": count(len(segments), "segment"),
            "csv": str(self.csv or ""),
            "picture": str(self.picture or ""),
        }

    def rows(self) -> list[dict[str, Any]]:
        """The rows of the reference up to its end: time [s], position [m], attitude, velocity [m/s], thrust [m/s^2], rates [rad/s]."""
        return self.reference.records()

    def to_dict(self) -> dict[str, Any]:
        """The keys of `hotlap plan --json`."""
        reference, pieces = self.reference, self.scenario.segments.pieces
        files = {"csv": self.csv, "picture": self.picture}
        return {
            "race": self.scenario.race.name,
            "duration": float(reference.duration),
            "lap_time": reference.lap_time,
            "max_speed": float(reference.speeds.max()),
            "mean_speed": float(reference.speeds.mean()),
            "cpu_time": float(reference.cpu_time),
            "gates": len(reference.gate_times),
            "segments": [{"class": piece.kind, "start": piece.start, "end": piece.end, "segment": piece.segment} for piece in pieces],
            "notes": list(self.scenario.notes),
            **{kind: str(path) for kind, path in files.items() if path is not None},
        }

    def plot(self) -> Figure:
        """The path from above and from the side, coloured by speed."""
        from hotlap.report.scene import stage  # noqa: PLC0415  matplotlib, only where there is something to draw
        from hotlap.report.track_view import track  # noqa: PLC0415

        return track(stage(self.scenario))


def carry_out(asked: Asked) -> PlannedReference:
    """Plan, or read a reference; write what is asked for."""
    out, picture = as_path(asked.out), as_path(asked.picture)
    check_target(out)
    check_target(picture, SUFFIXES)
    check_source(as_path(asked.reference))
    scenario = make_scenario(load(asked.race, None), asked, cache=asked.cache)
    if out is not None:
        save_reference(out, scenario.reference)
    planned = PlannedReference(scenario, out, picture)
    if picture is not None:
        from hotlap.report.pictures import save  # noqa: PLC0415  matplotlib again

        save(picture, planned.plot())
    return planned

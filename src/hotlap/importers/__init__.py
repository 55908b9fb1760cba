"""Import: tracks and quadrotors from the files of other programs; one file of code a program.

    imported = hotlap.importers.read("race_uzh_7g_multiprisma.yaml")
    imported.description, imported.taken, imported.lost, imported.text

A file is told by what stands in it, not by its name. Each importer has `FORMATS`; whoever adds one adds a line here.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

from hotlap.core.errors import InputError
from hotlap.core.printable import printable
from hotlap.files.content import Content
from hotlap.files.kinds import Kind
from hotlap.files.recognition import TYPES
from hotlap.importers import agilicious, drone_models, fast_fly, lsy_drone_racing, mrs, rpg_time_optimal, sdf, togt, urdf
from hotlap.importers.documents import read_document
from hotlap.importers.imported import Findings, Format, Imported, rounded
from hotlap.importers.markup import Markup

FORMATS: tuple[Format, ...] = (
    *togt.FORMATS,
    *lsy_drone_racing.FORMATS,
    *rpg_time_optimal.FORMATS,
    *fast_fly.FORMATS,
    *agilicious.FORMATS,
    *mrs.FORMATS,
    *drone_models.FORMATS,
    *sdf.FORMATS,
    *urdf.FORMATS,
)
SIMULATOR = "airsim:"
OURS = ({"gates", "start"}, {"rotor_thrust"}, {"track", "vehicle"})  # keys of files that need no import


def read(path: str | Path, name: str | None = None) -> Imported:
    """A track or quadrotor from a file of another program.

    Args:
        path: the file, or `airsim://host:port` for the level that a simulator runs there.
        name: what it is to be called; of a file with several vehicles the one that is read. None: as in the file, or the file's own name.

    Raises:
        InputError: the file is none that can be read, no simulator answers, or they say what cannot be; with file, key and reason.
    """
    if str(path).startswith(SIMULATOR):
        from hotlap.importers import airsim  # noqa: PLC0415  it loads a world

        source, found = airsim.read_level(str(path), name)
        return _imported(source, airsim.NAME, Kind.TRACK, found, "")
    root = read_document(Path(path))
    source = Markup(str(path), root) if isinstance(root, Element) else Content(str(path), root)
    format_ = _format_of(source)
    try:
        found = format_.read(source, name)
    except RecursionError:
        raise InputError(str(path), "", "is nested too deeply") from None
    return _imported(str(path), format_.name, format_.kind, found, Path(path).stem)


def _imported(source: str, format_: str, kind: Kind, found: Findings, stem: str) -> Imported:
    """What was found, checked."""
    _end_at_the_last_gate(found)
    origin = printable(Path(source).name) if stem else source
    named = {"name": found.table.get("name") or printable(stem), "provenance": f"{origin}, {format_}"}
    whole = rounded({**found.table, **named})
    table = {key: whole[key] for key in TYPES[kind].model_fields if key in whole}
    lost = [*found.lost, *_defaults(table)] if kind is Kind.QUADROTOR else found.lost
    imported = Imported(source, format_, kind, table, tuple(found.taken), tuple(lost))
    imported.description  # noqa: B018  it is checked
    return imported


def _end_at_the_last_gate(found: Findings) -> None:
    """Leave out an end that is the last gate's own place."""
    last = (found.table.get("gates") or [None])[-1]
    place = last["position"] if isinstance(last, dict) else last
    if place is not None and found.table.get("end") == place:
        del found.table["end"]
        found.taken.append("the end is the last gate's place: the plan ends there")


def _defaults(table: Mapping[str, Any]) -> list[str]:
    """What a quadrotor's file does not say although it matters."""
    unsaid = [key for key in ("motor_time", "rate_gain", "rate_limit", "delay") if key not in table]
    unsaid += ["drag"] if not {"drag", "rotor_drag", "body_drag"} & set(table) else []
    return [f"what the file does not say: {', '.join(unsaid)} stay at the defaults of hotlap"] if unsaid else []


def _format_of(source: Content | Markup) -> Format:
    """What a file is."""
    if isinstance(source, Content) and any(keys <= set(source.table()) for keys in OURS):
        raise InputError(source.file, "", f"is a file of hotlap itself: hotlap.check({source.file!r})")
    for format_ in FORMATS:
        if format_.xml == isinstance(source, Markup) and format_.matches(source):
            return format_
    raise InputError(source.file, "", f"is none of what can be read: {'; '.join(format_.name for format_ in FORMATS)}")


__all__ = ["FORMATS", "Format", "Imported", "read"]

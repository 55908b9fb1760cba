"""`hotlap export DIR`: a study's parameters, or its flights, in the files of other programs."""

from __future__ import annotations

import shlex
from argparse import Namespace

from hotlap.api.exported import ExportedFiles
from hotlap.api.exporting import export
from hotlap.cli.options import arguments_of
from hotlap.cli.output import present
from hotlap.cli.progress import TERMINAL
from hotlap.files.descriptions import names
from hotlap.files.kinds import Kind

HINTS = {
    "rpg_mpc": "one list entry for each segment; what rpg_mpc does not read is said in the file",
    "acados": "W and W_e of each segment, and the code that sets them stage by stage",
    "agilicious": "the vehicle, and the reference as a sampled trajectory",
    "px4": "QGroundControl, Parameters, Tools, Load from file; what they rest on is said in the file",
    "mcap": "Foxglove opens it; ros2 bag info FILE",
    "toml": "hotlap fly RACE --parameters FILE",  # only a built-in race is called by its name
    "optuna": "optuna-dashboard sqlite:///FILE",
}


def run(options: Namespace) -> int:
    """Write them."""
    exported = export(**arguments_of(export, options), progress=TERMINAL)
    present(as_json=options.json, document=exported.to_dict(), lines=[_line(exported)])
    return 0


def _line(exported: ExportedFiles) -> str:
    """What was written, and what it is for."""
    hint = HINTS.get(exported.format, "").replace("FILE", shlex.quote(str(exported.files[0])))
    if exported.race in names(Kind.RACE):
        hint = hint.replace("RACE", exported.race)
    return f"wrote {', '.join(map(str, exported.files))}{': ' if hint else ''}{hint}"

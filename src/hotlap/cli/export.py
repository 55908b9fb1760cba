"""`hotlap export DIR`: a study's parameters, or its flights, in the files of other programs."""

from __future__ import annotations

import shlex
from argparse import Namespace

from hotlap.cli.inputs import check_target
from hotlap.cli.output import note, present
from hotlap.exporters import FORMATS, export
from hotlap.files.descriptions import Kind, names
from hotlap.study.study import Study

HINTS = {
    "rpg_mpc": "one list entry for each segment; what rpg_mpc does not read is said in the file",
    "acados": "W and W_e of each segment, and the code that sets them stage by stage",
    "toml": "hotlap fly RACE --parameters FILE",  # only a built-in race is called by its name
    "optuna": "optuna-dashboard sqlite:///FILE",
}


def run(options: Namespace) -> int:
    """Write them."""
    check_target(options.out)
    with Study.read(options.folder) as study:
        files = export(study, options.format, options.out)
        race, result = study.configuration.scenario.race.name, study.result
    confirmed = result is not None and result.best.confirmed
    if FORMATS[options.format].finished and not confirmed:
        note(f"note: {options.folder}: these parameters were not confirmed: they did not reach the goal in all re-flights")
    hint = HINTS.get(options.format, "").replace("FILE", shlex.quote(str(files[0])))
    if race in names(Kind.RACE):
        hint = hint.replace("RACE", race)
    document = {"race": race, "format": options.format, "files": [str(file) for file in files], "confirmed": confirmed}
    lines = [f"wrote {', '.join(map(str, files))}{': ' if hint else ''}{hint}"]
    present(as_json=options.json, document=document, lines=lines)
    return 0

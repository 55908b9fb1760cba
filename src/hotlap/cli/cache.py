"""`hotlap cache`: what is kept between runs, where, and how to remove it."""

from __future__ import annotations

from argparse import Namespace

from hotlap.cli.output import present, table
from hotlap.core.counts import count
from hotlap.system.disk_cache import folder
from hotlap.system.kept import KINDS, clear, kept

UNITS = ("bytes", "kB", "MB", "GB")


def run(options: Namespace) -> int:
    """Say what is kept, and remove it where that is asked for."""
    place, found = folder("plans").parent, kept()
    size = sum(one.size for one in found)
    if options.clear:
        clear()
    document = {
        "folder": str(place),
        "bytes": size,
        "kinds": [{"kind": one.kind, "meaning": KINDS[one.kind], "files": one.files, "bytes": one.size} for one in found],
        "removed": options.clear,
    }
    rows = table([(one.kind, written(one.size), count(one.files, "file"), KINDS[one.kind]) for one in found], right=(1, 2), indent="  ")
    further = "all of it is removed" if options.clear else "to remove it: hotlap cache --clear; to keep it elsewhere: HOTLAP_CACHE=FOLDER"
    present(as_json=options.json, document=document, lines=[f"{place}: {written(size)}", *rows, further])
    return 0


def written(size: float) -> str:
    """A size [bytes] for people."""
    for unit in UNITS[:-1]:
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:.3g} {UNITS[-1]}"

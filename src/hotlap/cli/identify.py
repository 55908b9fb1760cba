"""`hotlap identify LOG...`: a quadrotor's numbers from logs of its flights."""

from __future__ import annotations

import math
import shlex
from argparse import Namespace
from collections.abc import Iterator
from typing import TYPE_CHECKING

from hotlap.api.identifying import identify
from hotlap.cli.options import arguments_of
from hotlap.cli.output import Line, present, table
from hotlap.cli.progress import TERMINAL
from hotlap.identification.wording import number

if TYPE_CHECKING:
    from hotlap.api.identified import IdentifiedQuadrotor
    from hotlap.identification.estimates import Estimate


def run(options: Namespace) -> int:
    """Fit, and say what the logs tell and what they do not."""
    found = identify(**arguments_of(identify, options), progress=TERMINAL)
    present(as_json=options.json, document=found.to_dict(), lines=_lines(found))
    return 0


def _lines(found: IdentifiedQuadrotor) -> Iterator[Line]:
    """Numbers, predictions, what is missing, and files."""
    known = found.identification
    yield f"{found.facts()['title']}; taken to be right: its {known.known}"
    cells = [("number", "value", "95 % interval", "unit", "base"), *(_cells(one) for one in found.estimates if one.told)]
    yield from table(cells, right=(1, 4), indent="  ")
    yield "seconds that were not fitted: error of what is predicted, and of the base (rms)"
    rows = [("", "identified", "base", "of", "")]
    rows += [
        (f"{one.channel} {one.axis}", number(one.error), number(one.former_error), number(one.size), one.unit) for one in known.predictions
    ]
    yield from table(rows, right=(1, 2, 3), indent="  ")
    if known.untold:
        yield "not told by the log"
        for one in known.untold:
            yield f"  {one.name}: {one.reason}"
            if one.manoeuvre:
                yield f"    would tell: {one.manoeuvre}"
    yield from (f"note: {note}" for note in known.notes)
    if found.hold:
        yield f'what the intervals leave open, for tune and fly: --hold "{found.hold}"'
    if found.picture is not None:
        yield f"picture written to {found.picture}"
    if found.file is not None:
        yield f"wrote {found.file}; next: hotlap check {shlex.quote(str(found.file))}"


def _cells(one: Estimate) -> tuple[str, ...]:
    former = "" if math.isnan(one.former) else number(one.former)
    return one.name, number(one.value), f"{number(one.low)} to {number(one.high)}", one.unit, former

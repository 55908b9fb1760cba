"""`hotlap watch DIR`: the page of a study in the browser, while its flights come in."""

from __future__ import annotations

import signal
import sys
from argparse import Namespace

from hotlap import worlds
from hotlap.api.inputs import check_range
from hotlap.cli.flying import make_ready
from hotlap.cli.output import note, present
from hotlap.cli.stopping import Stopped
from hotlap.study.study import Study
from hotlap.worlds.world import is_slow


def run(options: Namespace) -> int:
    """Serve until Ctrl-C."""
    check_range("port", options.port, 0, 65535)
    with Study.read(options.study) as study:
        world = worlds.build(study.configuration.world)
        if is_slow(world):
            note(f"note: the flights shown are of the built-in world; {world.name} flies for the study alone")
            world = worlds.build(worlds.DEFAULT)
        make_ready(world, study.configuration.scenario)
    from hotlap.report.page.writing import LiveStudy, load_template  # noqa: PLC0415  they load the flight core
    from hotlap.report.server import Server  # noqa: PLC0415

    load_template()  # a page that was not built is said here, not to the browser
    try:
        with Server(LiveStudy(options.study, world), options.host, options.port) as server:
            if options.json:
                present(as_json=True, document={"study": str(options.study), "address": server.address}, lines=())
                sys.stdout.flush()
            note(f"{options.study} is shown at {server.address} until Ctrl-C")
            server.serve_forever()
    except Stopped as stop:
        if stop.signal != signal.SIGINT:
            raise
    return 0

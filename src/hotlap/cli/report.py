"""`hotlap report DIR`: the page of a study, its figures, and its flight as a moving picture."""

from __future__ import annotations

from argparse import Namespace

from hotlap import worlds
from hotlap.cli.flying import make_ready
from hotlap.cli.inputs import check_target
from hotlap.cli.output import facts, present, working
from hotlap.study import Study

VIDEOS = (".gif", ".mp4")


def run(options: Namespace) -> int:
    """Fly what is shown, and write what was asked for."""
    check_target(options.video, VIDEOS)
    with Study.read(options.study) as study:
        world = worlds.build(study.configuration.world)
        make_ready(world, study.configuration.course)
        from hotlap.report.page.writing import write_report  # noqa: PLC0415  it loads the flight core

        with working("writing the report"):
            page = write_report(study, world)
    document = {"study": str(options.study), "report": str(page), "figures": [], "video": None}
    present(as_json=options.json, document=document, lines=facts({"report": str(page)}))
    return 0

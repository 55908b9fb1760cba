"""`hotlap report DIR`: the page of a study, its figures, and its flight as a moving picture."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from hotlap import worlds
from hotlap.api.inputs import check_target
from hotlap.cli.flying import make_ready
from hotlap.cli.output import Line, facts, present, working
from hotlap.cli.progress import follow_pieces
from hotlap.study.study import Study
from hotlap.worlds.world import World

VIDEOS = (".gif", ".mp4")


def run(options: Namespace) -> int:
    """Fly what is shown, and write what was asked for."""
    _check_video(options.video)
    with Study.read(options.study) as study:
        world = worlds.build(study.configuration.world)
        make_ready(world, study.configuration.scenario)
        from hotlap.report.page.writing import write_report  # noqa: PLC0415  it loads the flight core

        with working("writing the report"):
            page = write_report(study, world)
        figures = _draw(study, world, options.format) if options.figures else ()
        if options.video is not None:
            _film(options.video, study, world)
    document = {
        "study": str(options.study),
        "report": str(page),
        "figures": [str(path) for path in figures],
        "video": None if options.video is None else str(options.video),
    }
    present(as_json=options.json, document=document, lines=_lines(page, figures, options.video))
    return 0


def _check_video(path: Path | None) -> None:
    """Refuse a video that could not be written."""
    check_target(path, VIDEOS)
    if path is not None:
        from hotlap.report.film.recording import check_recorder  # noqa: PLC0415  only where there is something to record

        check_recorder(path)


def _draw(study: Study, world: World, kind: str) -> tuple[Path, ...]:
    """Every figure as a file."""
    from hotlap.report.pictures import draw_everything  # noqa: PLC0415  matplotlib takes half a second to load

    with working("drawing the figures"):
        return draw_everything(study.folder, study, world, kind)


def _film(path: Path, study: Study, world: World) -> None:
    """The flight as a moving picture."""
    from hotlap.report.film.film import write_film  # noqa: PLC0415  matplotlib again
    from hotlap.study.snapshot import read_snapshot  # noqa: PLC0415

    write_film(path, read_snapshot(study), world, follow_pieces)


def _lines(page: Path, figures: tuple[Path, ...], video: Path | None) -> list[Line]:
    """What is where."""
    named = {"figures" if i == 0 else " " * i: str(path) for i, path in enumerate(figures)}
    return [*facts({"report": str(page), **named, "video": "" if video is None else str(video)})]

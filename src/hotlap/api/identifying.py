"""Identifying: the call `identify`; imports nothing that takes time before it is called."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hotlap.api.asked import Asked

if TYPE_CHECKING:
    from hotlap.api.identified import IdentifiedQuadrotor
    from hotlap.api.progress import Progress


KNOWN = ("mass", "thrust", "rate_loop")


def identify(
    logs: Sequence[str | Path] | str | Path,
    *,
    quadrotor: str | Path,
    known: str | Sequence[str] = "mass",
    map: str | Path | Mapping[str, Any] | None = None,  # noqa: A002  the option's name
    window: tuple[float | None, float | None] | None = None,
    out: Path | str | None = None,
    picture: Path | str | None = None,
    progress: Progress | bool | None = None,
) -> IdentifiedQuadrotor:
    """Find a quadrotor's numbers in logs of its flights, each with an interval: all that `hotlap identify` does.

    Args:
        logs: of one vehicle: PX4 ULog, Betaflight blackbox, ArduPilot dataflash, MCAP, ROS bags, hotlap's own CSV or other tables.
        quadrotor: what it is believed to be: a built-in quadrotor or a TOML file, of its geometry, mass and form of rate loop.
        known: what of it is taken to be right: mass, or thrust, and the other is identified; with `,rate_loop` its rate loop, too, as
            where a firmware's gains were copied. In Python also a list.
        map: TOML file that says which columns of a table, or which topics, are which signal; in Python also a dict.
        window: seconds of every log's clock from which on and up to which it counts, (from, to); None: all of it.
        out: file to write, a quadrotor: .toml.
        picture: predicted against measured, where it was not fitted: .png, .svg or .pdf.
        progress: receives messages about the progress of the work; True: bars or lines; False: nothing; None: bars in a notebook.

    Returns:
        The numbers, what the logs cannot tell, and the files that were written.

    Raises:
        InputError: a log cannot be read or cannot be right, or no vehicle has the numbers that were found.
    """
    asked = Asked(identify, locals())
    from hotlap.api.identified import carry_out  # noqa: PLC0415  it loads what fits

    return carry_out(asked)

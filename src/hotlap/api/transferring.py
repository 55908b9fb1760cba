"""Transferring: the call `transfer`; imports nothing that takes time before it is called."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hotlap.api.asked import Asked

if TYPE_CHECKING:
    from hotlap.api.progress import Progress
    from hotlap.api.transferred import TransferResult
    from hotlap.worlds.world import World


def transfer(
    folder: str | Path,
    *,
    to: str | World | Sequence[str | World],
    flights: int = 3,
    seed: int = 0,
    cluster: str | None = None,
    progress: Progress | bool | None = None,
) -> TransferResult:
    """Fly a study's parameters, and the default ones, in other worlds with the same noise: all that `hotlap transfer` does.

    Args:
        folder: folder of a study that has ended, as hotlap tune made it.
        to: names of other worlds; in Python also worlds themselves.
        flights: of each set of parameters in each world, 3 or more.
        seed: of the noise.
        cluster: address of a dask scheduler, or the file it wrote, whose workers fly in simulators; None: this machine.
        progress: receives messages about the progress of the work; True: bars or lines; False: nothing; None: bars in a notebook.

    Returns:
        How each flight went, in the world of the study first.

    Raises:
        InputError: something that was given is not usable, the study has not ended, or a world cannot be opened.
    """
    asked = Asked(transfer, locals())
    from hotlap.api.transferred import carry_out  # noqa: PLC0415  it loads what flies

    return carry_out(asked)

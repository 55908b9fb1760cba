"""Lapping: the call `lap`; imports nothing that takes time before it is called."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from hotlap.api.asked import Asked
from hotlap.reference.segmentation_rule import SegmentationRule

if TYPE_CHECKING:
    from hotlap.api.lapped import LapResult
    from hotlap.api.progress import Progress
    from hotlap.core.parameters import Parameters
    from hotlap.race.race import Race


def lap(
    race: Race | str | Path,
    *,
    parameters: str | Path | Parameters,
    on: str,
    arm: bool = False,
    dry_run: bool = False,
    origin: str = "0,0,0,0",
    geofence: str = "",
    margin: float | None = None,
    stray: float | None = None,
    on_stop: str = "land",
    throttle_curve: float = 0.0,
    battery: bool = True,
    rehearsal: bool = True,
    wait: float | None = None,
    reference: str | Path | None = None,
    segments: str = SegmentationRule.PAPER,
    controller: str | None = None,
    log: str | Path | None = None,
    progress: Progress | bool | None = None,
) -> LapResult:
    """Fly a real vehicle once: all that `hotlap lap` does. Read docs/real_flight.md first.

    Args:
        race: a built-in race (hotlap races) or a TOML file; in Python also a `Race`.
        parameters: a parameters file or a study's folder; in Python also numbers, shape (segments, parameters).
        on: the vehicle.
        arm: arm it, and take off from the ground.
        dry_run: print what would be sent for a while, and send nothing but heartbeats.
        origin: x,y,z,yaw [m, deg] of the race's origin in the vehicle's own world, or 'here': the race starts above where it stands.
        geofence: box that it must not leave, x,x,y,y,z,z [m] in the race's world; '': around its path.
        margin: [m] between its path and that box; None: 2.
        stray: [m] from the reference at most; None: 3, or the race's judge.crash where that is less.
        on_stop: what the vehicle is asked for when something stops the flight.
        throttle_curve: how thrust grows with throttle, from 0, evenly, to 1, with its square.
        battery: thrust goes with the battery's voltage; False: the autopilot makes up for the battery's voltage.
        rehearsal: fly the parameters in simulation first; False: do not ask whether the parameters hold in simulation.
        wait: [s] for the vehicle to be heard; None: 10.
        reference: read this CSV instead of planning.
        segments: how the reference is cut.
        controller: which one flies; None: the race's.
        log: write the flight as CSV, step by step; None: race and time, .csv.
        progress: receives messages about the progress of the work; True: bars or lines; False: nothing; None: bars in a notebook.

    Returns:
        What the flight was, judged as simulated ones are.

    Raises:
        InputError: something that was given is not usable, there is no vehicle, or it refused.
        PlanningError: the race has no plan.
    """
    asked = Asked(lap, locals())
    from hotlap.api.lapped import carry_out  # noqa: PLC0415  it loads what flies

    return carry_out(asked)

"""The world of Betaflight: the unmodified firmware's rate loop and mixer before hotlap's own rotors and body, in lockstep.

The firmware is another project's program (GPL-3), which the package `betaflight` builds; it runs in a process of its own.
"""

from __future__ import annotations

import math

from hotlap.reference.scenario import Scenario
from hotlap.worlds.betaflight.settings import read_lines
from hotlap.worlds.betaflight.simulator import Betaflight

NOISE = 0.5  # rad/s: what actuation noise may add to a commanded rate


def open_simulator(scenario: Scenario, instance: int, argument: str = "") -> Betaflight:
    """A firmware that has armed and hovers.

    Args:
        scenario: whose vehicle flies, with the throttles of the vehicle that its controller knows.
        instance: which of several side by side; they share nothing.
        argument: a file with lines of Betaflight's command line, a `diff all` for example; "": none.

    Raises:
        InputError: the file cannot be read, or the firmware refuses a line of it.
        SimulatorError: the firmware is not installed, does not start, or does not arm.
    """
    del instance
    race = scenario.race
    own = read_lines(argument) if argument else ()
    track = race.track
    lowest = [-math.inf if track.floor is None else track.floor, -math.inf if track.box is None else track.box.low[2]]
    most_rate = max(race.controller.rates) + NOISE
    return Betaflight(race.vehicle, own, known_as=race.control_model, most_rate=most_rate, floor=max(lowest))


__all__ = ["Betaflight", "open_simulator"]

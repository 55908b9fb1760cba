"""Time of one control step: `Controller.command` in float64, as on a vehicle."""

from __future__ import annotations

from itertools import count

import pytest

from hotlap.flight.controller import Controller
from hotlap.race.controllers import ControllerKind
from hotlap.reference.scenario import Scenario


@pytest.mark.parametrize("age", [0.0, 0.045])
@pytest.mark.parametrize("kind", ControllerKind)
def test_command(benchmark, scenario, kind, age):
    flown = Scenario(scenario.race.with_controller(kind), scenario.reference, scenario.segments)
    controller, table, steps = Controller(flown, flown.space.default), flown.reference.table, count()
    offset = 0.05  # beside the reference

    def setup():
        tick = next(steps) % (flown.reference.planned_rows - 1)
        if tick == 0:
            controller.reset()
        return (0.01 * tick, table[tick, :10] + offset, age), {}

    benchmark.pedantic(controller.command, setup=setup, rounds=3000, warmup_rounds=10)

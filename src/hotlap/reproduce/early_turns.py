"""Early turns: why the default weights track the double Split-S better with dead time than without, shown by a shorter horizon.

The controller plans with inputs that are constant between its nodes, and applies the beginning of the first. With nodes far apart it turns
about half of their distance early: a slow rate loop, or dead time, makes up for that; nodes that are closer make it needless.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hotlap.analysis.transfer import DEFAULT, TransferRow
from hotlap.core.parameters import Parameters
from hotlap.reference.scenario import Scenario
from hotlap.report.article import Article
from hotlap.report.transfer_article import errors_of

HORIZON = 1.0  # times the unit of the horizon
SHORT = "default, short horizon"


def sets_of(scenario: Scenario, default: Parameters) -> Mapping[str, Parameters]:
    """The default weights, shape (S, K), and the same with a short horizon."""
    short = default.copy()
    short[:, scenario.space.names.index("horizon")] = HORIZON
    return {DEFAULT: default, SHORT: short}


def tell_early_turns(page: Article, scenario: Scenario, default: Parameters, flown: Mapping[str, Sequence[TransferRow]]) -> None:
    """Add the table, and what it means.

    Args:
        page: to add to.
        scenario: of one of the races; the controllers of all are the same.
        default: weights, shape (S, K).
        flown: rows of both sets in the same worlds, by what is different about the race.
    """
    controller = scenario.race.controller
    seconds = [controller.horizon_unit * float(horizon) for horizon in (default[0, scenario.space.names.index("horizon")], HORIZON)]
    apart = [1e3 * horizon / controller.nodes for horizon in seconds]
    page.head("Why dead time helps the default weights")
    page.say(
        "With the default weights flights track better with dead time than without, where the firmware turns the drone. The horizon "
        f"explains it: {controller.nodes} nodes over {seconds[0]:g} s are {apart[0]:.0f} ms apart, inputs are constant between them, and "
        "the beginning of the first is what is applied. So the drone turns early, and lies beside the path, not before or behind it. "
        "The rate loop of its file is slow enough to hide that; the firmware is quicker, and dead time hides it again. "
        f"With {seconds[1]:g} s the nodes are {apart[1]:.0f} ms apart, and dead time does harm. What was tuned for the firmware without "
        "dead time has a short horizon, too."
    )
    rows = [[row.world, name, row.label, errors_of(row, lambda flight: flight.mean_error)] for name, some in flown.items() for row in some]
    page.table(("world", "race", "parameters", "mean error [m]"), sorted(rows, key=lambda cells: (cells[0], cells[2])))

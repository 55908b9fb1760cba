"""A controller that heeds what another one commands, so that it can take over in flight without a jolt."""

from __future__ import annotations

from hotlap.core.parameters import Parameters
from hotlap.core.records import Floats
from hotlap.flight.command_log import CommandLog
from hotlap.flight.controller import Controller
from hotlap.reference.scenario import Scenario


class GivenCommands(CommandLog):
    """A log of commands that takes up those that were really sent.

    Attributes:
        given: shape (4,) the command that was sent in place of the controller's own; None: its own was.
    """

    given: Floats | None = None

    def keep(self) -> None:
        """Take up the command of this control step."""
        if self.given is not None:
            self._history[0] = self.given
        super().keep()


class HeedingController(Controller):
    """The controller, which can be told that another command than its own was sent.

    Args:
        scenario: see `Controller`.
        parameters: likewise.
    """

    def __init__(self, scenario: Scenario, parameters: Parameters) -> None:
        super().__init__(scenario, parameters)
        self._log = self._given = GivenCommands(self._loop.history[:, :, 0], self._settings.period)
        self.reset()

    def heed(self, time: float, state: Floats, age: float, given: Floats) -> None:
        """One control step: it observes, plans and predicts as in `command`, with the command that was sent in place of its own.

        Args:
            time: as of `command`, like what follows.
            state: shape (10,) or (13,).
            age: [s].
            given: shape (4,) what was sent.
        """
        self._given.given = given
        try:
            self.command(time, state, age)
        finally:
            self._given.given = None

"""Scenario: a race made ready to fly, with its reference, its segments and the controller's parameters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import ParameterSpace
from hotlap.core.shown import Shown
from hotlap.race.controllers import space_of
from hotlap.race.race import Race
from hotlap.reference.reference import Reference
from hotlap.reference.segmentation import Segments

LEAST_MARGIN = 1.0  # of thrust, from which on offset-free control was not worse on random tracks; below it was, in part of them
COMMANDED = 0.95  # share of the rotors' thrust that it commands at most: all of it would leave no torque


@dataclass(frozen=True, repr=False)
class Scenario(Shown):
    """Everything that a flight needs but parameters and seed: what a world flies.

    Attributes:
        race: track, vehicle and settings.
        reference: the flight that the controller is asked to repeat.
        segments: the parts of the reference that have parameters of their own.
        notes: what was assumed about a reference that was read, one line each.
    """

    race: Race
    reference: Reference
    segments: Segments
    notes: tuple[str, ...] = ()

    @property
    def space(self) -> ParameterSpace:
        """The tunable parameters of one segment, with their bounds."""
        settings = self.race.controller
        return space_of(settings.kind, settings.low, settings.high, settings.default)

    @property
    def offset_free(self) -> bool:
        """Whether the controller learns thrust effectiveness and disturbance: as the race says, or where the plan leaves thrust for it."""
        asked = self.race.controller.offset_free
        return self.thrust_margin >= LEAST_MARGIN if asked is None else asked

    @property
    def corrects_target(self) -> bool:
        """Whether the controller corrects its targets, for what it estimates or for drags that its model has."""
        return self.offset_free or self.knows_drag

    @property
    def knows_drag(self) -> bool:
        """Whether the drag that its model has counts along the horizon, or in the feed-forward: `controller.reference_drag`."""
        model = self.race.control_model
        return self.race.controller.reference_drag and any((*model.drag, *model.body_drag, model.rotor_drag))

    @property
    def thrust_limits(self) -> tuple[float, float]:
        """[m/s^2] Least and largest thrust that is commanded: as planned, or offset-free as far as the rotors have it."""
        low, high = self.race.controller.thrust
        return (low, COMMANDED * self.race.control_model.max_acceleration) if self.offset_free else (low, high)

    @property
    def planned_thrust(self) -> tuple[float, float]:
        """[m/s^2] Least and largest thrust that an MPC plans over its horizon, while thrust has its full effectiveness."""
        low, high = self.thrust_limits
        return low, min(high, self.race.controller.thrust[1])

    @property
    def thrust_margin(self) -> float:
        """Thrust that an offset-free controller may plan over the largest thrust of the reference [-]."""
        most = min(self.race.controller.thrust[1], COMMANDED * self.race.control_model.max_acceleration)
        return most / float(self.reference.thrust[: self.reference.planned_rows].max())

    @property
    def gate_segments(self) -> NDArray[np.int64]:
        """Segment that each gate lies in, shape (gates,)."""
        return self.segments.at(self.reference.gate_times)

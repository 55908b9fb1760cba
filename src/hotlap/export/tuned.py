"""Tuned: what a study has found, beside the course that it was found for."""

from __future__ import annotations

from dataclasses import dataclass

from hotlap.controllers import TUNABLE, ControllerKind
from hotlap.course import Course
from hotlap.errors import InputError
from hotlap.files import PARAMETERS_FILE, load_parameters
from hotlap.parameters import Parameters
from hotlap.preparation import parameters_for
from hotlap.race import ControllerSettings
from hotlap.saved_parameters import SavedParameters
from hotlap.study import Study


@dataclass(frozen=True)
class Tuned:
    """Parameters as they were saved, and what flies with them.

    Attributes:
        course: race, reference and segments.
        saved: the content of `parameters.toml`.
        values: shape (S, K), in the order of the course's space.
    """

    course: Course
    saved: SavedParameters
    values: Parameters

    @property
    def controller(self) -> ControllerSettings:
        """Settings that are not tuned."""
        return self.course.race.controller

    @property
    def spacings(self) -> list[float]:
        """[s] between the nodes of the horizon, for each segment: `horizon * horizon_unit / nodes`."""
        settings = self.controller
        return (self.values[:, self.course.space.names.index("horizon")] * settings.horizon_unit / settings.nodes).tolist()


def read_tuned(study: Study) -> Tuned:
    """The parameters that a study has ended with.

    Raises:
        InputError: it has not ended, or its file does not fit it.
    """
    file = study.folder / PARAMETERS_FILE
    if not file.exists():
        reason = f"holds a study that has not ended, so no {PARAMETERS_FILE}; hotlap tune --out {study.folder} goes on with it"
        raise InputError(str(study.folder), "", reason)
    course, saved = study.configuration.course, load_parameters(file)
    return Tuned(course, saved, parameters_for(course, saved, str(file)))


def need_weights(tuned: Tuned, name: str) -> None:
    """Refuse parameters that are no weights of an MPC.

    Args:
        tuned: whose controller counts.
        name: of the format.

    Raises:
        InputError: with the controller that was tuned.
    """
    kind = tuned.controller.kind
    if TUNABLE[kind].names != TUNABLE[ControllerKind.MPC].names:
        raise InputError("--format", "", f"{name} takes the weights of an MPC; tuned was the {kind} controller: use json, toml or csv")

"""Exported parameters: the tuned parameters of a study, with the scenario that they were tuned on."""

from __future__ import annotations

from dataclasses import dataclass

from hotlap.core.errors import InputError
from hotlap.core.parameters import Parameters
from hotlap.files.descriptions import PARAMETERS_FILE, load_parameters
from hotlap.files.parameters_file import SavedParameters
from hotlap.planning.preparation import parameters_for
from hotlap.race.controllers import TUNABLE, ControllerKind
from hotlap.race.race import ControllerSettings
from hotlap.reference.scenario import Scenario
from hotlap.study.study import Study


@dataclass(frozen=True)
class ExportedParameters:
    """Parameters as they were saved, and what flies with them.

    Attributes:
        scenario: race, reference and segments.
        saved: the content of `parameters.toml`.
        values: shape (S, K), in the order of the scenario's space.
    """

    scenario: Scenario
    saved: SavedParameters
    values: Parameters

    @property
    def controller(self) -> ControllerSettings:
        """Settings that are not tuned."""
        return self.scenario.race.controller

    @property
    def spacings(self) -> list[float]:
        """[s] between the nodes of the horizon, for each segment: `horizon * horizon_unit / nodes`."""
        settings = self.controller
        return (self.values[:, self.scenario.space.names.index("horizon")] * settings.horizon_unit / settings.nodes).tolist()


def read_tuned(study: Study) -> ExportedParameters:
    """The parameters that a study has ended with.

    Raises:
        InputError: it has not ended, or its file does not fit it.
    """
    file = study.folder / PARAMETERS_FILE
    if not file.exists():
        reason = f"holds a study that has not ended, so no {PARAMETERS_FILE}; hotlap.tune(RACE, out={str(study.folder)!r}) goes on with it"
        raise InputError(str(study.folder), "", reason)
    scenario, saved = study.configuration.scenario, load_parameters(file)
    return ExportedParameters(scenario, saved, parameters_for(scenario, saved, str(file)))


def need_weights(tuned: ExportedParameters, name: str) -> None:
    """Refuse parameters that are no weights of an MPC.

    Args:
        tuned: whose controller counts.
        name: of the format.

    Raises:
        InputError: with the controller that was tuned.
    """
    kind = tuned.controller.kind
    if TUNABLE[kind].names != TUNABLE[ControllerKind.MPC].names:
        raise InputError("", "format", f"{name} takes the weights of an MPC; tuned was the {kind} controller: use json, toml or csv")

"""What the tuned controller flew with besides its weights, and what of that a solver that only takes the weights does not do."""

from __future__ import annotations

from dataclasses import replace

from hotlap.exporters.tuned import ExportedParameters, read_tuned
from hotlap.files.parameters_file import CHOSEN_SHARE, Remark, SavedParameters
from hotlap.race.controller_kind import ControllerKind, Solver, kind_and_solver
from hotlap.reference.scenario import Scenario
from hotlap.study.study import Study


def flown_with(scenario: Scenario) -> dict[str, Remark]:
    """The controller as it flew, what the race leaves open decided: remarks for a file.

    Thrusts are per mass [m/s^2], bandwidths of the observer [rad/s], period and prediction [s].
    """
    race, settings = scenario.race, scenario.race.controller
    kind, solver = kind_and_solver(settings.law)
    low, high = scenario.planned_thrust
    told: dict[str, Remark] = {"controller": str(kind), "period": settings.period, "prediction": race.prediction}
    if kind is not ControllerKind.GEOMETRIC:
        told |= {"solver": str(solver), "nodes": settings.nodes, "sweeps": settings.sweeps}
    told["offset_free"] = scenario.offset_free
    if scenario.offset_free:
        told |= {"observer_thrust": settings.observer.thrust, "observer_acceleration": settings.observer.acceleration}
    told |= {"reference_drag": scenario.knows_drag, "least_thrust": low, "largest_thrust": high}
    told |= {"largest_command": scenario.thrust_limits[1], "thrust_margin": scenario.thrust_margin}
    if race.planning.thrust_share is not None and race.planning.quadrotor is None:
        told["thrust_share"] = race.planning.thrust_share
    return told


def read_remarked(study: Study) -> SavedParameters:
    """The parameters that a study has ended with, with these remarks.

    Raises:
        InputError: it has not ended, or its file does not fit it.
    """
    tuned = read_tuned(study)
    return replace(tuned.saved, flown_with=flown_with(tuned.scenario))


def plan_words(tuned: ExportedParameters) -> str:
    """With what share of the thrust the plan was made, and who chose it; "" where no share was asked for."""
    share = tuned.scenario.race.planning.thrust_share
    if share is None or tuned.scenario.race.planning.quadrotor is not None:
        return ""
    return f"{100 * share:g} % of the rotors' thrust{', chosen by hotlap tune' if CHOSEN_SHARE in tuned.saved.provenance else ''}"


def not_reproduced(scenario: Scenario, *, own_model: bool) -> list[str]:
    """What the tuned controller did, and a solver that takes the weights does not: a sentence for each.

    Args:
        scenario: that was flown.
        own_model: whether the model of that solver is the user's to write.
    """
    settings = scenario.race.controller
    kind, solver = kind_and_solver(settings.law)
    missing = []
    if scenario.offset_free:
        observer, most = settings.observer, scenario.thrust_limits[1]
        missing.append(
            f"The observer of offset-free control (bandwidths: thrust effectiveness {observer.thrust:g} rad/s, disturbance "
            f"{observer.acceleration:g} rad/s; commands up to {most:g} m/s^2 where thrust is lost). Without it a wrong mass, a weak "
            "battery or a steady wind displaces the drone."
        )
    if scenario.knows_drag and kind is not ControllerKind.MPC_DRAG:
        cure = ": a model with that drag comes close" if own_model else ""
        missing.append(f"The model's drag along the horizon, by which each node and its target were corrected{cure}.")
    if kind is ControllerKind.MPC_DRAG:
        missing.append(f"The drag in the model of mpc_drag{': write it into the model of the solver' if own_model else ''}.")
    if scenario.corrects_target:
        missing.append("The reference without drag: its thrusts and attitudes were taken anew from its accelerations.")
    if solver is Solver.LINE_SEARCH:
        missing.append(
            "The offsets of line_search: a node's input was an offset from the reference's inputs, which go on changing within the node."
        )
    return missing

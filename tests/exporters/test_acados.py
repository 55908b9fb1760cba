"""The exported cost is the cost that hotlap flies: compared with the memory of its own controller, node by node, all along a flight."""

from __future__ import annotations

import json
import runpy
from dataclasses import replace

import numpy as np
import pytest

from exporters.studies import VALUES, alternating, tune, tuned
from flight.scenarios import fly, make_scenario
from hotlap.core.errors import InputError
from hotlap.exporters import export
from hotlap.exporters.acados import weights
from hotlap.exporters.acados_weights import TunedWeights
from hotlap.flight.controller import Controller
from hotlap.flight.riccati import _diagonal, state_gradient
from hotlap.race.race import SegmentSwitch

NODES = 20
KNOWN_DELAY = {"delay": 0.03}


class Recorder:
    """Takes what an AcadosOcpSolver takes, and keeps what the stages' costs come to.

    As in acados, new time steps are also the new factors of the stages' costs, whatever `cost_scaling` these had.
    """

    def __init__(self, cost_scaling: float = 0.1) -> None:
        self.costs: dict[int, np.ndarray] = {}
        self.scaling = np.full(NODES, cost_scaling)

    def set_new_time_steps(self, steps: np.ndarray) -> None:
        assert steps.shape == (NODES,)
        self.steps = self.scaling = steps

    def cost_set(self, stage: int, field: str, value: np.ndarray) -> None:
        assert field == "W"
        assert value.shape == ((14, 14) if stage < NODES else (10, 10))
        self.costs[stage] = value * (self.scaling[stage] if stage < NODES else 1.0)


def cases():
    """Every rule of handing over, with segments of one piece and of several, known dead time."""
    for segment_switch in SegmentSwitch:
        scenario = make_scenario(
            KNOWN_DELAY, model=KNOWN_DELAY, controller={"segment_switch": segment_switch, "segment_switch_distance": 1.0}
        )
        yield pytest.param(scenario, id=f"{segment_switch}-apart")
        yield pytest.param(replace(scenario, segments=alternating()), id=f"{segment_switch}-shared")


@pytest.mark.parametrize("scenario", list(cases()))
def test_every_stage_has_the_weights_of_the_flown_controller_all_along_a_flight(scenario, tmp_path):
    (tmp_path / "weights.json").write_text(json.dumps(weights(tuned(scenario))))
    exported, solver = TunedWeights(tmp_path / "weights.json"), Recorder()
    log = fly(scenario, VALUES[None], numbers="float64", log=[0]).logs[0]
    controller, seen = Controller(scenario, VALUES), set()
    for time, state in zip(log.times[:-1], log.states[:-1], strict=True):
        controller.command(time, state)
        times = exported.apply(solver, time, state[:3])
        flown = controller._memory
        xy, z, attitude, velocity = flown.weights[:, :, 0].T
        expected = np.array([xy, xy, z, *[attitude] * 4, *[velocity] * 3]).T
        np.testing.assert_allclose(solver.steps, flown.spacing[0, 0], rtol=1e-14)
        np.testing.assert_allclose([np.diag(solver.costs[n])[:10] for n in range(NODES + 1)], expected, rtol=1e-12)
        inputs = [np.diag(solver.costs[n])[10:] for n in range(NODES)]
        np.testing.assert_allclose(inputs, np.tile(flown.input_weights[:, 0], (NODES, 1)), rtol=1e-12)
        positions = scenario.reference.position_at(times)
        np.testing.assert_allclose(flown.reference[:, :3, 0], positions, atol=1e-9)
        seen.add(tuple(flown.weights[:, 0, 0]))
    assert len(seen) > 1, "a flight that hands over"
    assert all(np.count_nonzero(cost - np.diag(np.diag(cost))) == 0 for cost in solver.costs.values())


def test_the_exported_quadratic_has_the_gradient_that_the_controller_descends():
    """|q - q_ref|^2 on four components, in the tangent coordinates that the controller solves in."""
    rng = np.random.default_rng(5)
    scenario = make_scenario()
    W = np.array(weights(tuned(scenario))["segments"][1]["W_e"])
    x, r = rng.standard_normal(10), rng.standard_normal(14)
    x[3:7] /= np.linalg.norm(x[3:7])
    r[3:7] = x[3:7] + 0.1 * rng.standard_normal(4)
    r[3:7] /= np.linalg.norm(r[3:7])

    def moved(deviation):
        (w, a, b, c), (i, j, k) = x[3:7], 0.5 * deviation[3:6]
        turned = np.array([w - a * i - b * j - c * k, a + w * i + b * k - c * j, b + w * j - a * k + c * i, c + w * k + a * j - b * i])
        return np.concatenate([x[:3] + deviation[:3], turned / np.linalg.norm(turned), x[7:] + deviation[6:]])

    def cost(deviation):
        return 0.5 * float(W @ (moved(deviation) - r[:10]) ** 2)

    step = 1e-6
    numerical = [(cost(step * e) - cost(-step * e)) / (2 * step) for e in np.eye(9)]
    flown = state_gradient(_diagonal(VALUES[1, :4]), x, np.zeros(9), r)
    np.testing.assert_allclose(flown, numerical, rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("made_with", [0.05, 1.0])
def test_the_cost_is_the_same_however_the_solver_scaled_its_stages_before(tmp_path, made_with):
    (tmp_path / "weights.json").write_text(json.dumps(weights(tuned(make_scenario()))))
    solver = Recorder(made_with)
    TunedWeights(tmp_path / "weights.json").apply(solver, 0.0)
    assert solver.costs[0][0, 0] == pytest.approx(VALUES[0, 0])
    assert solver.costs[NODES][0, 0] == VALUES[0, 0]


def test_the_code_that_is_written_runs_without_hotlap(tmp_path):
    with tune(tmp_path / "study") as opened:
        data, code = export(opened, "acados", tmp_path / "mine.json")
    assert (data.name, code.name) == ("mine.json", "mine.py")
    assert "import hotlap" not in code.read_text()
    assert "from hotlap" not in code.read_text()
    exported, solver = runpy.run_path(str(code))["TunedWeights"](data), Recorder()
    times = exported.apply(solver, 0.0, np.zeros(3))
    horizon = VALUES[0, 4] * 0.5
    np.testing.assert_allclose([times[-1], solver.steps.sum()], horizon)
    assert set(solver.costs) == set(range(NODES + 1))


def test_a_flight_begins_anew_after_a_reset(tmp_path):
    scenario = make_scenario(controller={"segment_switch": SegmentSwitch.DISTANCE})
    (tmp_path / "weights.json").write_text(json.dumps(weights(tuned(scenario))))
    exported, solver = TunedWeights(tmp_path / "weights.json"), Recorder()
    there = scenario.reference.position_at(scenario.segments.starts)[1]
    pieces = [(exported.apply(solver, 0.01 * k, there), exported.piece)[1] for k in range(3)]
    exported.reset()
    exported.apply(solver, 0.0, there)
    assert (pieces, exported.piece) == ([0, 1, 1], 0)


def test_weights_are_not_written_where_the_code_goes(tmp_path):
    with tune(tmp_path / "study") as opened, pytest.raises(InputError, match="is the name of the weights' JSON"):
        export(opened, "acados", tmp_path / "weights.py")

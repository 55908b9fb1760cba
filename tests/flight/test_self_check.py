"""Compiled lanes that do not fly what the interpreter flies are found out, once, and not flown."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from numba.core.errors import NumbaError
from numpy.testing import assert_allclose, assert_array_equal

from flight.scenarios import fly, make_scenario, parameters
from hotlap.flight import self_check
from hotlap.flight.fly import fly_batch
from hotlap.flight.kernel import worker
from hotlap.flight.numbers import Numbers
from hotlap.flight.program import MEANING
from hotlap.race.controllers import ControllerKind
from hotlap.worlds import BuiltIn

LANES = Numbers.FLOAT32X8


@pytest.fixture
def remark(tmp_path, monkeypatch):
    """Where it is written what a check found."""
    path = tmp_path / "kernels" / "remark.txt"
    monkeypatch.setattr(self_check, "remark_on", lambda dispatcher: path)
    return path


def test_the_interpreter_flies_what_plain_floats_fly():
    scenario = self_check.make_scenario(ControllerKind.MPC)
    asked, seeds = np.tile(scenario.space.default, (2, 2, 1)), np.arange(2)
    logs, errors = self_check.fly_interpreted(scenario, asked, seeds)
    flown = fly_batch(scenario, asked, seeds, numbers=Numbers.FLOAT64, log=[0, 1])[0]
    for i in range(2):
        assert_allclose(logs[i][:, :13], flown.logs[i].states, atol=1e-9)
        assert_allclose(logs[i][:, 17:], flown.logs[i].commands, atol=1e-9)
    assert_allclose(errors, flown.mean_error, atol=1e-12)


def test_the_flights_meet_bounds_and_leave_them():
    scenario = self_check.make_scenario(ControllerKind.MPC)
    flown = fly_batch(scenario, np.tile(scenario.space.default, (20, 2, 1)), np.arange(20), numbers=LANES, log=range(20))[0]
    thrust = np.concatenate([flown.logs[i].commands[:, 0] for i in range(20)])
    assert 0.2 < (thrust > scenario.race.controller.thrust[1] - 1e-6).mean() < 0.8


def test_nothing_compiled_is_left_in_an_interpreted_function():
    known = {}
    self_check.interpreted(worker(LANES, ControllerKind.MPC), known)
    assert {function.__name__ for function in known.values()} >= {"work", "control", "solve", "fly_period", "judge", "normal"}
    for function in known.values():
        modules = [value for value in function.__globals__.values() if isinstance(value, SimpleNamespace)]
        values = [value for module in modules for value in vars(module).values()]
        values += [*function.__globals__.values(), *(cell.cell_contents for cell in function.__closure__ or ())]
        assert not [value for value in values if hasattr(value, "py_func")]


@pytest.mark.parametrize("kind", ControllerKind)
def test_lanes_agree_with_the_interpreter(kind):
    assert self_check.check(LANES, kind)


@pytest.mark.parametrize(("operation", "meaning"), [("minimum", max), ("negate", float), ("sqrt", lambda a: 1.01 * a**0.5)])
def test_an_operation_that_means_something_else_is_found_out(operation, meaning, monkeypatch):
    monkeypatch.setitem(MEANING, operation, meaning)
    assert not self_check.check(LANES, ControllerKind.MPC)


@pytest.mark.parametrize("error", [NumbaError("no such overload"), NotImplementedError(), RuntimeError("LLVM")])
def test_lanes_that_cannot_be_compiled_do_not_agree(error, monkeypatch):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr(self_check, "fly_batch", fail)
    assert not self_check.check(LANES, ControllerKind.MPC)


@pytest.mark.parametrize("result", [True, False])
def test_what_was_found_out_is_known_the_next_time(result, remark, monkeypatch):
    monkeypatch.setattr(self_check, "check", lambda numbers, kind: result)
    assert self_check.agrees(LANES, ControllerKind.MPC) is result
    assert remark.exists()
    monkeypatch.setattr(self_check, "check", lambda numbers, kind: 1 / 0)
    assert self_check.agrees(LANES, ControllerKind.MPC) is result


@pytest.mark.parametrize("damage", [b"", b"agr", b"\xff"])
def test_a_damaged_remark_is_found_out_again(damage, remark, monkeypatch):
    remark.parent.mkdir()
    remark.write_bytes(damage)
    monkeypatch.setattr(self_check, "check", lambda numbers, kind: False)
    assert not self_check.agrees(LANES, ControllerKind.MPC)
    assert remark.read_text() == self_check.DIFFERS


def test_a_remark_that_cannot_be_kept_is_no_error(remark, monkeypatch):
    remark.parent.write_text("no folder")
    monkeypatch.setattr(self_check, "check", lambda numbers, kind: True)
    assert self_check.agrees(LANES, ControllerKind.MPC)


def test_a_world_without_sound_lanes_says_so_once_and_flies_plain_floats(monkeypatch):
    monkeypatch.setattr(self_check, "agrees", lambda numbers, kind: False)
    world, scenario = BuiltIn("float32x8"), make_scenario(noise={"rates": 0.1})
    with pytest.warns(RuntimeWarning, match="float32x8 flights differ from interpreted ones"):
        flown = world.fly(scenario, parameters(2), np.arange(2))
    again = world.fly(scenario, parameters(2), np.arange(2))  # warnings are errors here
    for flights in (flown, again):
        assert_array_equal(flights.clock_distance, fly(scenario, 2, numbers="float64").clock_distance)


def test_plain_floats_need_no_check(monkeypatch):
    monkeypatch.setattr(self_check, "agrees", lambda numbers, kind: 1 / 0)
    assert BuiltIn("float64").sound_numbers(ControllerKind.MPC) is Numbers.FLOAT64

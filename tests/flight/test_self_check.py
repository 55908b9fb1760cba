"""Compiled lanes that do not fly what the interpreter flies are found out, once, and not flown."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from numba.core.errors import NumbaError
from numpy.testing import assert_allclose, assert_array_equal

from flight.scenarios import fly, make_scenario, parameters
from hotlap.core.errors import HotlapError
from hotlap.core.records import Cause, End
from hotlap.flight import self_check
from hotlap.flight.fly import fly_batch
from hotlap.flight.numbers import Numbers, best_numbers
from hotlap.flight.registry import CONTROLLERS
from hotlap.race.controller_kind import kind_and_solver
from hotlap.race.controllers import ControllerKind
from hotlap.system import sealed
from hotlap.system.sealed import CacheWarning
from hotlap.worlds import BuiltIn

LANES = best_numbers()
GATES = len(self_check.GATES)
COLUMNS = [f"{name}{k or ''}" for name in self_check.JUDGED for k in range(GATES if name in ("rim_distance", "closest_distance") else 1)]


@pytest.fixture
def result_file(tmp_path, monkeypatch):
    """Where it is written what a check found."""
    path = tmp_path / "kernels" / "result_file.txt"
    monkeypatch.setattr(self_check, "check_file_of", lambda dispatcher: path)
    return path


WRONG = {"minimum": "max", "negate": "float", "sqrt": "lambda a: 1.01 * a**0.5"}  # operations that mean something else
DETAILED = ("scale-torque-4", "betaflight-pid-6")  # kinds of plant that between them have every part
WRONG_JUDGES = {"rim_distance": "openings", "_corner": "collisions"}  # functions that measure two centimetres more, and their modules
INTERPRET = f"""
import sys
from importlib import import_module
import numpy as np
from hotlap.core.errors import HotlapError
from hotlap.flight import self_check
from hotlap.flight.program import MEANING
from hotlap.flight.registry import CONTROLLERS
lanes, flown = {LANES.lanes}, {{}}
def fly(name, kind, plant="plain"):
    flown.update({{f"{{name}}-{{k}}": array for k, array in enumerate(self_check.fly_interpreted(kind, lanes, plant))}})
for kind in CONTROLLERS:
    fly(kind, kind)
for plant in {DETAILED}:
    fly(plant, "geometric", plant)
for operation, wrong in {{{", ".join(f'"{operation}": {wrong}' for operation, wrong in WRONG.items())}}}.items():
    right, MEANING[operation] = MEANING[operation], wrong
    fly(operation, "geometric")
    MEANING[operation] = right
for name, place in {WRONG_JUDGES}.items():
    module = import_module(f"hotlap.flight.{{place}}")
    right = getattr(module, name)
    setattr(module, name, lambda *given, right=right: right(*given) + 0.02)
    fly(name, "geometric")
    setattr(module, name, right)
np.savez(sys.stdout.buffer, **flown)
"""


@pytest.fixture(scope="module")
def interpreted() -> dict[str, list[np.ndarray]]:
    """What an interpreter flies, with every controller, and with each operation that means something else; of one process."""
    found: dict[str, list[np.ndarray]] = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(self_check, "PROGRAM", INTERPRET)
        with self_check.interpreter(ControllerKind.MPC, LANES.lanes) as running:
            arrays = np.load(BytesIO(self_check.answer_of(running)))
    for name in arrays.files:
        found.setdefault(name.rpartition("-")[0], []).append(arrays[name])
    return found


@pytest.mark.check
def test_the_interpreter_flies_what_plain_floats_fly(interpreted):
    scenario, rows = self_check.make_scenario(ControllerKind.MPC), self_check.compared(LANES.lanes)
    asked, seeds = self_check.draw_flights(scenario, LANES.lanes)
    flown = fly_batch(scenario, asked[rows], seeds[rows], numbers=Numbers.FLOAT64, log=range(len(rows)))[0]
    *logs, judged = interpreted[ControllerKind.MPC]
    for i, log in enumerate(logs):
        assert_allclose(log[:, :13], flown.logs[i].states, atol=1e-9)
        assert_allclose(log[:, 17:], flown.logs[i].commands, atol=1e-9)
    assert_allclose(judged[:, 0], flown.mean_error, atol=1e-12)


def test_the_flights_meet_bounds_and_leave_them():
    scenario = self_check.make_scenario(ControllerKind.MPC)
    flown = fly_batch(scenario, np.tile(scenario.space.default, (20, 2, 1)), np.arange(20), numbers=LANES, log=range(20))[0]
    thrust = np.concatenate([flown.logs[i].commands[:, 0] for i in range(20)])
    assert 0.2 < (thrust > scenario.race.controller.thrust[1] - 1e-6).mean() < 0.8


@pytest.mark.parametrize("kind", CONTROLLERS)
@pytest.mark.check
def test_lanes_agree_with_the_interpreter(kind, interpreted):
    tolerance = self_check.TOLERANCES[kind_and_solver(kind)[1]]
    assert self_check.same(self_check.fly_compiled(LANES, kind), interpreted[kind], tolerance)


@pytest.mark.parametrize("plant", DETAILED)
@pytest.mark.check
def test_lanes_of_detailed_plants_agree_with_the_interpreter(plant, interpreted):
    flown = self_check.fly_compiled(LANES, ControllerKind.GEOMETRIC, plant)
    assert self_check.same(flown, interpreted[plant])
    assert not self_check.same(flown, interpreted[ControllerKind.GEOMETRIC])


@pytest.mark.parametrize("operation", WRONG)
@pytest.mark.check
def test_an_operation_that_means_something_else_is_found_out(operation, interpreted):
    assert not self_check.same(self_check.fly_compiled(LANES, ControllerKind.GEOMETRIC), interpreted[operation])


@pytest.mark.parametrize("name", WRONG_JUDGES)
@pytest.mark.check
def test_a_judge_that_measures_something_else_is_found_out(name, interpreted):
    assert not self_check.same(self_check.fly_compiled(LANES, ControllerKind.GEOMETRIC), interpreted[name])


@pytest.mark.check
def test_the_judge_takes_part_with_openings_and_a_crash(interpreted):
    """The first flight passes a window and a tunnel, and meets a pole; the others miss the window."""
    for kind in ControllerKind:
        first, *others = (dict(zip(COLUMNS, row, strict=True)) for row in interpreted[kind][-1])
        assert (first["end"], first["cause"], first["cause_index"], first["gates_passed"]) == (End.CRASHED, Cause.POLE, 0, 2)
        assert all((row["end"], row["gates_passed"]) == (End.MISSED, 0) for row in others)


@pytest.mark.check
def test_a_kernel_is_checked_by_a_process_of_its_own(monkeypatch):
    assert self_check.check(LANES, ControllerKind.GEOMETRIC)
    monkeypatch.setattr(self_check, "PROGRAM", "import sys; import numpy as np; np.savez(sys.stdout.buffer, np.zeros(3))")
    assert not self_check.check(LANES, ControllerKind.GEOMETRIC)


def test_an_interpreter_that_fails_says_why(monkeypatch):
    monkeypatch.setattr(self_check, "PROGRAM", "raise MemoryError('none left')")
    with pytest.raises(HotlapError, match="check of the compiled flight core failed: MemoryError: none left"):
        self_check.check(LANES, ControllerKind.MPC)
    monkeypatch.setattr(self_check.sys, "executable", "/no/python")
    with pytest.raises(HotlapError, match="Python cannot be started"):
        self_check.check(LANES, ControllerKind.MPC)


@pytest.mark.parametrize("error", [NumbaError("no such overload"), NotImplementedError(), RuntimeError("LLVM")])
def test_lanes_that_cannot_be_compiled_do_not_agree(error, monkeypatch):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr(self_check, "fly_batch", fail)
    monkeypatch.setattr(self_check, "PROGRAM", "")
    assert not self_check.check(LANES, ControllerKind.MPC)


@pytest.mark.parametrize("result", [True, False])
def test_what_was_found_out_is_known_the_next_time(result, result_file, monkeypatch):
    monkeypatch.setattr(self_check, "check", lambda numbers, kind, plant: result)
    assert self_check.agrees(LANES, ControllerKind.MPC) is result
    assert result_file.exists()
    monkeypatch.setattr(self_check, "check", lambda numbers, kind, plant: 1 / 0)
    assert self_check.agrees(LANES, ControllerKind.MPC) is result


@pytest.mark.parametrize("damage", [b"", b"agrees", b"\xff"])
def test_a_damaged_result_is_found_out_again(damage, result_file, monkeypatch):
    result_file.parent.mkdir()
    result_file.write_bytes(damage)
    monkeypatch.setattr(self_check, "check", lambda numbers, kind, plant: False)
    with pytest.warns(CacheWarning, match="is damaged"):
        assert not self_check.agrees(LANES, ControllerKind.MPC)
    assert sealed.read(result_file) == self_check.DIFFERS


def test_a_result_that_cannot_be_kept_is_no_error(result_file, monkeypatch):
    result_file.parent.write_text("no folder")
    monkeypatch.setattr(self_check, "check", lambda numbers, kind, plant: True)
    assert self_check.agrees(LANES, ControllerKind.MPC)


def test_a_world_without_sound_lanes_says_so_once_and_flies_plain_floats(monkeypatch):
    monkeypatch.setattr(self_check, "agrees", lambda numbers, kind, plant: False)
    world, scenario = BuiltIn("float32x8"), make_scenario(noise={"rates": 0.1})
    with pytest.warns(RuntimeWarning, match="float32x8 flights differ from interpreted ones"):
        flown = world.fly(scenario, parameters(2), np.arange(2))
    again = world.fly(scenario, parameters(2), np.arange(2))  # warnings are errors here
    for flights in (flown, again):
        assert_array_equal(flights.clock_distance, fly(scenario, 2, numbers="float64").clock_distance)


def test_plain_floats_need_no_check(monkeypatch):
    monkeypatch.setattr(self_check, "agrees", lambda numbers, kind, plant: 1 / 0)
    assert BuiltIn("float64").sound_numbers(ControllerKind.MPC) is Numbers.FLOAT64

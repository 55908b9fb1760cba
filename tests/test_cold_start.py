"""A process that finds plan and kernel in the caches flies soon: it loads nothing that plans, compiles equations or draws."""

from __future__ import annotations

import subprocess
import sys

import pytest

from hotlap.cli.main import main

FLY = ["fly", "circle-34", "--flights", "2", "--first-guess", "learned", "--json"]  # none fails: to find out why takes equations
IDLE = {"casadi", "matplotlib", "sklearn", "cmaes", "IPython"}


@pytest.fixture(scope="module")
def warm():
    """The caches hold what the flights need."""
    assert main(FLY) == 0


@pytest.mark.usefixtures("warm")
def test_a_second_process_loads_neither_planner_nor_equations():
    program = f"import sys; from hotlap.cli import main; main({FLY!r}); print(*sys.modules, file=sys.stderr)"
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    modules = set(ran.stderr.splitlines()[-1].split())
    assert "compiling" not in ran.stderr.replace(ran.stderr.splitlines()[-1], "")
    assert {"numba", "hotlap.flight.kernel"} <= modules
    assert {name.partition(".")[0] for name in modules} & IDLE == set()
    assert modules & {"hotlap.dynamics.models", "hotlap.planning.minimum_time", "scipy.linalg"} == set()


@pytest.mark.usefixtures("warm")
@pytest.mark.parametrize("name", ["circle-34"])
def test_a_controller_by_itself_needs_no_equations_either(name):
    program = (
        "import sys; from hotlap.planning.preparation import prepare; from hotlap.flight.controller import Controller\n"
        f"scenario = prepare({name!r}); controller = Controller(scenario, scenario.space.default)\n"
        "controller.command(0.0, scenario.reference.table[0, :10]); print(*sys.modules)"
    )
    for _ in range(2):  # the first may compile
        ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert {module.partition(".")[0] for module in ran.stdout.split()} & IDLE == set()

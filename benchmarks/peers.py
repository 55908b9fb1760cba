"""Computing time compared with other solvers and simulators, in one run on one core: python benchmarks/peers.py

It needs an environment with `pip install hotlap rotorpy`. CasADi's solvers are given the same problem: circle-34, default parameters,
20 nodes, states from a logged flight of hotlap, each step warm-started with the last plan shifted by a period. IPOPT iterates to
convergence; qrqp solves one quadratic problem per step, as hotlap's controller does. RotorPy simulates one drone with its own dynamics and
no controller; hotlap simulates the plant with controller, noise and judge.
"""

from __future__ import annotations

import argparse
import os

os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")  # before numpy is loaded

import statistics
import time
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np

from hotlap.analysis.speed import RACE, machine_name
from hotlap.core.records import Log
from hotlap.dynamics import models
from hotlap.flight.controller import Controller
from hotlap.flight.fly import fly_batch
from hotlap.flight.numbers import Numbers, best_numbers
from hotlap.planning.preparation import prepare
from hotlap.reference.scenario import Scenario

STEPS, PLANT_STEPS = 100, 4  # control steps that another solver computes; steps of the plant in each

QUIET = {"print_time": False, "print_header": False, "print_iteration": False, "print_status": False, "error_on_fail": False}
SOLVERS: dict[str, tuple[str, dict[str, Any]]] = {
    "CasADi + IPOPT (MUMPS)": ("ipopt", {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "warm_start_init_point": "yes"}}),
    "CasADi sqpmethod + qrqp, one step": (
        "sqpmethod",
        {**QUIET, "max_iter": 1, "qpsol": "qrqp", "hessian_approximation": "exact", "convexify_strategy": "regularize",
         "qpsol_options": {"print_iter": False, "print_header": False, "error_on_fail": False, "print_info": False}},
    ),
}  # fmt: skip


def problem(scenario: Scenario) -> tuple[dict[str, ca.SX], int]:
    """The nonlinear program of Eq. 3 of the paper, with measured state and reference as parameters; and its number of nodes."""
    settings, weights = scenario.race.controller, scenario.space.default
    nodes, h = settings.nodes, weights[4] * settings.horizon_unit / settings.nodes
    Q = ca.DM([weights[0], weights[0], weights[1], *[weights[2]] * 4, *[weights[3]] * 3])
    R = ca.DM([settings.input_weights[0], settings.input_weights[1], settings.input_weights[1], settings.input_weights[2]])
    X, U = ca.SX.sym("X", 10, nodes + 1), ca.SX.sym("U", 4, nodes)
    start, reference, node = ca.SX.sym("start", 10), ca.SX.sym("reference", 14, nodes + 1), models.node_map()
    cost = sum(ca.dot(Q, (X[:, n] - reference[:10, n]) ** 2) for n in range(nodes + 1))
    cost += sum(ca.dot(R, (U[:, n] - reference[10:, n]) ** 2) for n in range(nodes))
    gaps = [X[:, 0] - start, *(X[:, n + 1] - node(X[:, n], U[:, n], h, scenario.race.control_model.gravity) for n in range(nodes))]
    parts = [part for n in range(nodes) for part in (X[:, n], U[:, n])]  # in order of time: sparse in a band
    unknowns, parameters = ca.vertcat(*parts, X[:, nodes]), ca.vertcat(start, ca.vec(reference))
    return {"x": unknowns, "p": parameters, "f": cost / 2, "g": ca.vertcat(*gaps)}, nodes


def solve_steps(scenario: Scenario, log: Log, name: str, options: dict[str, Any]) -> tuple[float, float]:
    """Median CPU time of a control step [us], and the median difference of its thrust from hotlap's [m/s^2]."""
    nlp, nodes = problem(scenario)
    solver = ca.nlpsol("solver", name, nlp, options)
    settings, h = scenario.race.controller, scenario.space.default[4] * scenario.race.controller.horizon_unit / nodes
    rates, free = np.array(settings.rates), np.full(10, np.inf)
    low, high = np.concatenate([settings.thrust[:1], -rates]), np.concatenate([settings.thrust[1:], rates])
    bounds = [np.concatenate([np.tile(np.concatenate([-free, low]), nodes), -free])]
    bounds.append(np.concatenate([np.tile(np.concatenate([free, high]), nodes), free]))
    table, times, costs, apart = scenario.reference.table, scenario.reference.times, [], []
    guess = None
    for time_now, state, command in zip(log.times[:STEPS], log.states[:STEPS], log.commands[:STEPS], strict=True):
        rows = np.transpose([np.interp(time_now + h * np.arange(nodes + 1), times, column) for column in table.T])
        if guess is None:
            guess = np.concatenate([rows[:-1].ravel(), rows[-1, :10]])
        start = time.process_time()
        guess = solver(x0=guess, p=np.concatenate([state[:10], rows.ravel()]), lbx=bounds[0], ubx=bounds[1], lbg=0, ubg=0)["x"]
        costs.append(time.process_time() - start)
        guess = np.array(guess).ravel()
        apart.append(abs(np.clip(guess[10], low[0], high[0]) - command[0]))
        plan = guess[: 14 * nodes].reshape(nodes, 14)
        plan += settings.period / h * (np.vstack([plan[1:], plan[-1:]]) - plan)  # the warm start
        guess[: 14 * nodes] = plan.ravel()
    return 1e6 * statistics.median(costs), statistics.median(apart)


def our_command(scenario: Scenario, log: Log) -> float:
    """Median time of `Controller.command` [us]."""
    controller, costs = Controller(scenario, scenario.space.default), []
    for _ in range(2):  # the first may compile
        controller.reset()
        for time_now, state in zip(log.times[:-1], log.states[:-1], strict=True):
            start = time.perf_counter()
            controller.command(time_now, state)
            costs.append(time.perf_counter() - start)
    return 1e6 * statistics.median(costs)


def our_steps(scenario: Scenario, numbers: Numbers) -> float:
    """Control steps per second of one core, with plant, noise and judge."""
    flights = 16 * numbers.lanes
    parameters = np.repeat(scenario.space.first_guess(len(scenario.segments))[None], flights, axis=0)
    rates = []
    for _ in range(4):
        start = time.process_time()
        _, effort = fly_batch(scenario, parameters, np.arange(flights), numbers=numbers, threads=1)
        rates.append(effort.useful_steps / (time.process_time() - start))
    return statistics.median(rates[1:])


def rotorpy_steps() -> float:
    """Simulation steps of 2.5 ms per second of one core, of RotorPy's drone in hover."""
    from rotorpy.vehicles.hummingbird_params import quad_params  # noqa: PLC0415
    from rotorpy.vehicles.multirotor import Multirotor  # noqa: PLC0415

    drone = Multirotor(quad_params, control_abstraction="cmd_motor_speeds")
    state, control = drone.initial_state, {"cmd_motor_speeds": drone.initial_state["rotor_speeds"]}

    def fly() -> None:
        nonlocal state
        for _ in range(1000):
            state = drone.step(state, control, 0.0025)

    return 1000 / seconds(fly)


def seconds(work: Callable[[], None]) -> float:
    """CPU time of some work [s], the best of three."""
    best = np.inf
    for _ in range(3):
        start = time.process_time()
        work()
        best = min(best, time.process_time() - start)
    return best


def main() -> None:
    """Print the tables."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    scenario = prepare(RACE)
    first = scenario.space.first_guess(len(scenario.segments))[None]
    log = fly_batch(scenario, first, np.zeros(1, dtype=np.int64), numbers=Numbers.FLOAT64, log=[0])[0].logs[0]
    lanes, command = our_steps(scenario, best_numbers()), our_command(scenario, log)
    rows = [(f"hotlap, {best_numbers()}, plant and judge included", 1e6 / lanes, None), ("hotlap, one command, float64", command, None)]
    rows += [(title, *solve_steps(scenario, log, *solver)) for title, solver in SOLVERS.items()]
    print(f"{machine_name()}; {RACE}\n\n| controller | us a step | times the lanes | thrust apart, m/s^2 |\n|---|---|---|---|")
    for title, cost, apart in rows:
        print(f"| {title} | {cost:,.1f} | {cost * lanes / 1e6:,.0f} | {'' if apart is None else f'{apart:.1e}'} |")
    flown, alone = PLANT_STEPS * lanes, rotorpy_steps()
    print("\n| simulator | steps of the vehicle/s | ratio |\n|---|---|---|")
    print(f"| hotlap, with controller | {flown:,.0f} | {flown / alone:,.0f} |")
    print(f"| RotorPy, without | {alone:,.0f} | 1 |")


if __name__ == "__main__":
    main()

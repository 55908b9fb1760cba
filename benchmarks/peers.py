"""Controllers, simulators and planners of others beside hotlap's, in one run on one core: python benchmarks/peers.py

It needs gcc and an environment of its own with `pip install 'hotlap[rotorpy,crazyflow]' comma-deps-acados torch torchdiffeq roma`; what is
not installed is left out, and said so.

Controllers are given the same problem: circle-34, default parameters, 20 nodes, states from a logged flight of hotlap, each step begun with
the last solution moved on by a period. acados solves one real-time iteration in generated, compiled code. Simulators fly a drone in hover
and have no controller but their own rate loop; hotlap's flights have plant, controller, noise and judge. Plans are compared with those that
TOGT-Planner publishes, for its tracks and its quadrotor: a point, with all of the thrust of its rotors.
"""

from __future__ import annotations

import os

os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")  # before numpy is loaded
os.environ |= {"SCIPY_ARRAY_API": "1", "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false"}  # crazyflow's; one thread

import argparse
import statistics
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import chdir

import acados_rti
import numpy as np

from hotlap.analysis.speed import RACE, machine_name
from hotlap.core.records import Log
from hotlap.files.descriptions import load_race, load_track
from hotlap.flight.controller import Controller
from hotlap.flight.fly import fly_batch
from hotlap.flight.numbers import Numbers, best_numbers
from hotlap.planning.preparation import prepare
from hotlap.race.race import PLANT_STEP, PlanDynamics
from hotlap.race.track import Track
from hotlap.reference.scenario import Scenario
from hotlap.system.blas_threads import one_thread

STEPS, PLANT_STEPS = 300, 4  # control steps that another solver computes; steps of the plant in each
DRONES, CALLS = 1024, 100  # that a batch simulates, and steps that are timed
HOVER = np.array([0.0, 0.0, 1.0])
PUBLISHED = {  # TOGT-Planner's README and resources/trajectory at 9b5aea4: seconds to the end, where the drone stands again
    "seven gates (togt-7g)": (("TOGT", 8.23), ("TOGT, refined by multiple shooting", 7.01)),
    "19 gates, 0.4 m to the rim (togt-19g)": (("AOS and TOGT", 16.83),),
    "19 waypoints (split-S)": (("AOS", 17.93), ("CPC, the optimum by its authors", 17.56)),
}
CLEARANCE = 0.4  # m, of the 19 gates


def our_command(scenario: Scenario, log: Log) -> float:
    """Median time of `Controller.command` [us], of the processor as all times here."""
    controller, costs = Controller(scenario, scenario.space.default), []
    for _ in range(2):  # the first may compile
        controller.reset()
        for time_now, state in zip(log.times[:-1], log.states[:-1], strict=True):
            start = time.process_time()
            controller.command(time_now, state)
            costs.append(time.process_time() - start)
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


def controllers(scenario: Scenario, lanes: float) -> Iterator[str]:
    """Lines of a table: times of a control step.

    Args:
        scenario: what is flown.
        lanes: our control steps per second.
    """
    first = scenario.space.first_guess(len(scenario.segments))[None]
    log = fly_batch(scenario, first, np.zeros(1, dtype=np.int64), numbers=Numbers.FLOAT64, log=[0])[0].logs[0]
    yield "| controller | us a control step | times the lanes | thrust apart, m/s^2 |\n|---|---|---|---|"
    yield f"| hotlap, {best_numbers()}, plant and judge included | {1e6 / lanes:.1f} | 1 | |"
    command = our_command(scenario, log)
    yield f"| hotlap, `Controller.command`, float64 | {command:.0f} | {command * lanes / 1e6:.0f} | |"
    for name, tuned in (("acados as it is", False), ("acados, hotlap's step, quickest settings", True)):
        inside, outside, apart = acados_rti.solve_steps(acados_rti.build(scenario, tuned=tuned), scenario, log, STEPS)
        times = np.median(inside), np.median(outside)
        for how, cost in zip((", solving alone", ", with references and warm start set from Python"), times, strict=True):
            yield f"| {name}{how} | {cost:.0f} | {cost * lanes / 1e6:.0f} | {np.median(apart):.0e} |"


def simulators(lanes: float) -> Iterator[str]:
    """Lines of a table: steps of the vehicle per second and core.

    Args:
        lanes: our control steps per second.
    """
    ours = PLANT_STEPS * lanes
    yield "| simulator | steps of the vehicle a second | hotlap's over it |\n|---|---|---|"
    yield f"| hotlap, with controller, noise and judge | {ours:,.0f} | 1 |"
    for name, measure in SIMULATORS.items():
        try:
            steps = measure()
        except ModuleNotFoundError as error:
            left_out(name, error)
        else:
            yield f"| {name} | {steps:,.0f} | {ours / steps:,.1f} |"


def rotorpy_one() -> float:
    """RotorPy's drone under rotor speeds."""
    from rotorpy.vehicles.hummingbird_params import quad_params  # noqa: PLC0415
    from rotorpy.vehicles.multirotor import Multirotor  # noqa: PLC0415

    drone = Multirotor(quad_params, control_abstraction="cmd_motor_speeds")
    state, control = drone.initial_state, {"cmd_motor_speeds": drone.initial_state["rotor_speeds"]}

    def fly() -> None:
        nonlocal state
        for _ in range(CALLS):
            state = drone.step(state, control, PLANT_STEP)

    return CALLS / seconds(fly)


def rotorpy_batch() -> float:
    """RotorPy's batched drones under rotor speeds, integrated by the fourth-order rule in PyTorch."""
    import torch  # noqa: PLC0415
    from rotorpy.vehicles.hummingbird_params import quad_params  # noqa: PLC0415
    from rotorpy.vehicles.multirotor import BatchedMultirotor, BatchedMultirotorParams, Multirotor  # noqa: PLC0415

    torch.set_num_threads(1)
    device = torch.device("cpu")
    one = Multirotor(quad_params).initial_state
    state = {key: torch.tensor(np.tile(value, (DRONES, 1))).double() for key, value in one.items()}
    params = BatchedMultirotorParams([quad_params] * DRONES, DRONES, device)
    drones = BatchedMultirotor(params, DRONES, state, device, control_abstraction="cmd_motor_speeds", integrator="rk4")
    control = {"cmd_motor_speeds": state["rotor_speeds"].clone()}

    def fly() -> None:
        nonlocal state
        for _ in range(CALLS):
            state = drones.step(state, control, PLANT_STEP)

    return DRONES * CALLS / seconds(fly)


def crazyflow(control: str) -> float:
    """crazyflow's drones, by its defaults but for the control, under body rates or rotor speeds."""
    from crazyflow.control import Control  # noqa: PLC0415
    from crazyflow.sim import Dynamics, Sim  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as folder, chdir(folder):  # MuJoCo writes a log where it is
        sim = Sim(n_worlds=DRONES, dynamics=Dynamics.first_principles, control=getattr(Control, control))
    sim.reset()
    if control == "body_rate":
        sim.body_rate_control(np.tile(np.array([0.0, 0, 0, 0.0434 * 9.81], dtype=np.float32), (DRONES, 1, 1)))
    else:
        sim.rotor_vel_control(np.full((DRONES, 1, 4), 15000.0, dtype=np.float32))

    def fly() -> None:
        sim.step(10 * CALLS)
        sim.data.states.pos.block_until_ready()

    return 10 * DRONES * CALLS / seconds(fly)


SIMULATORS: dict[str, Callable[[], float]] = {
    "RotorPy `Multirotor`": rotorpy_one,
    f"RotorPy `BatchedMultirotor`, {DRONES} drones, rk4": rotorpy_batch,
    f"crazyflow, {DRONES} drones, body rates": lambda: crazyflow("body_rate"),
    f"crazyflow, {DRONES} drones, rotor speeds": lambda: crazyflow("rotor_vel"),
}


def standing_split_s() -> Track:
    """The split-S track with its two gates above each other where TOGT-Planner has them, and the last waypoint as a place to stand."""
    track, ours, theirs = load_track("split-s"), -2.5, -4.5
    moved = [(theirs if x == ours else x, y, z) for x, y, z in (gate.position for gate in track.gates[:19])]
    gates = tuple(gate.model_copy(update={"position": position}) for gate, position in zip(track.gates, moved, strict=False))
    return track.model_copy(update={"gates": gates, "end": (4.75, -0.9, 1.2), "end_at_rest": True})


def plans() -> Iterator[str]:
    """Lines of a table: seconds to the end of the track, and how long hotlap planned."""
    tracks = load_track("togt-7g"), load_track("togt-19g"), standing_split_s()
    yield "| track | planner | s to the end | hotlap | its time to plan |\n|---|---|---|---|---|"
    for (name, published), track in zip(PUBLISHED.items(), tracks, strict=True):
        race = load_race("togt-7g")
        point = race.vehicle.model_copy(update={"radius": 0.0})
        limits = {"dynamics": PlanDynamics.IDEAL, "clearance": CLEARANCE * (track is tracks[1]), "tolerance": 0.3}
        planning = race.planning.model_copy(update={"quadrotor": point, "thrust_share": None, **limits})
        ours = prepare(race.model_copy(update={"planning": planning, "vehicle": point, "track": track})).reference
        for planner, end in published:
            change = 100 * (ours.duration / end - 1)
            yield f"| {name} | {planner} | {end:.2f} | {ours.duration:.2f} s ({change:+.1f} %) | {ours.cpu_time:.1f} s |"


def seconds(work: Callable[[], None]) -> float:
    """CPU time of some work [s], the best of three after one that compiles."""
    work()
    best = np.inf
    for _ in range(3):
        start = time.process_time()
        work()
        best = min(best, time.process_time() - start)
    return best


def left_out(what: str, error: ModuleNotFoundError) -> None:
    """Say that a peer is not installed."""
    print(f"{what} is left out: {error}", file=sys.stderr, flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parts = ("controllers", "simulators", "plans")
    parser.add_argument("parts", nargs="*", default=parts, metavar="PART", help=f"of {', '.join(parts)}; all without any")
    chosen = parser.parse_args().parts
    one_thread()
    warnings.simplefilter("ignore", UserWarning)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    scenario = prepare(RACE)
    lanes = our_steps(scenario, best_numbers())
    tables = {"controllers": lambda: controllers(scenario, lanes), "simulators": lambda: simulators(lanes), "plans": plans}
    print(f"{machine_name()}; {RACE}")
    for part in chosen:
        print()
        try:
            for line in tables[part]():
                print(line, flush=True)
        except ModuleNotFoundError as error:
            left_out(part, error)


if __name__ == "__main__":
    main()

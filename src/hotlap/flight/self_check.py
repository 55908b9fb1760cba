"""Self-check: does a compiled kernel fly what the same source flies in plain Python?

The kernels use internal parts of Numba and LLVM's code for vectors, which another release may change. So, once for each kernel that was
compiled, short flights are flown twice: by the kernel, and in a process whose Numba does not compile (NUMBA_DISABLE_JIT), on float64.
Controller, plant, noise, judge and the refilling of lanes take part, with dead time, drag, two segments and bounds that are reached;
neither a file nor a planner does: a drone is to hover at a place that jumps away, behind a framed window, a tunnel and a pole. A horizon
of few nodes keeps the interpreter's share at about a second; compiling a scalar controller to compare with would take seven.

It says that a kernel is its source, not how well its solver solves. On a plant that is its model `real_time` strays by up to 0.1 m at its
longest horizons, `line_search` by at most 0.013 m, and by 0.035 m in one corner of the weights (docs/controller.md).
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import BytesIO
from typing import Any

import numpy as np
from numba.core.errors import NumbaError
from numpy.typing import NDArray

from hotlap.core.errors import HotlapError
from hotlap.core.parameters import Parameters
from hotlap.core.records import Flights
from hotlap.flight.fly import fly_batch
from hotlap.flight.kernel import worker
from hotlap.flight.kernel_cache import check_file_of
from hotlap.flight.numbers import Numbers
from hotlap.race.battery import Battery
from hotlap.race.controller_kind import Solver, kind_and_solver
from hotlap.race.obstacles import Pole
from hotlap.race.plant_kind import PLAIN, detailed_kind
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import ControllerSettings, GateRule, JudgeSettings, NoiseSettings, Race
from hotlap.race.rate_loop import LIMITS, MotorLag, Output, RateLoop
from hotlap.race.track import Gate, Track
from hotlap.reference.reference import PERIOD, Reference
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentClass, Segments
from hotlap.system import sealed

Floats = NDArray[np.float64]

STEPS, NODES = 24, 4  # control periods of a flight, nodes of the horizon
REFILLED = 3  # flights beyond one a lane
THRUST = (0.1, 20.0)  # m/s^2, less than the rotors have
HORIZON_UNIT, SPREAD = 0.1, 0.3  # [s] of the horizon; of the logarithms of the parameters: half of the commands meet a bound
JUDGED = ("mean_error", "max_error", "rim_distance", "closest_distance", "end_time", "end", "gates_passed", "cause", "cause_index")
TOLERANCES: Mapping[Solver, float] = {Solver.REAL_TIME: 2e-3, Solver.LINE_SEARCH: 2e-2}
"""Of every number in a log, in its unit and relative: single precision stays below 5e-5, and below 7e-3 where it may take another step of a
line search that lowers the cost as well."""
AGREES, DIFFERS = b"agrees", b"differs"
PROGRAM = "import sys; from hotlap.flight.self_check import write_answer; write_answer(*sys.argv[1:])"

DRONE = Quadrotor(
    name="self-check",
    mass=0.85,
    inertia=(1e-3, 1.1e-3, 1.7e-3),
    arm=0.15,
    rotor_thrust=(0.0, 6.9),
    torque_ratio=0.05,
    drag=(0.3, 0.2, 0.1),
    rotor_drag=0.01,
    body_drag=(0.01, 0.01, 0.02),
    torque_damping=0.1,
    delay=0.0225,
    radius=0.05,
    battery=Battery(sag=0.1, sag_per_ampere_hour=20.0, hover_current=20.0),
)
NOISE = NoiseSettings(
    position=0.3,
    velocity=1.0,
    attitude=0.1,
    measured_position=0.01,
    measured_velocity=0.01,
    measured_attitude=0.01,
    wind=1.0,
    steady_wind=0.5,
)
JUMP = (1.0, -1.0, 1.0)  # m; a longer one asks for bang-bang, in which a rounding error may grow
GATES = (
    Gate(position=(-0.05, 0.3, -0.35), yaw=-math.pi / 2, width=0.8, height=0.6, frame=0.1),
    Gate(position=(0.0, 0.2, -0.2), yaw=-math.pi / 2, radius=0.25, depth=0.02),
    Gate(position=JUMP),
)
POLE = Pole(position=(-0.12, 0.075), radius=0.03)  # met by the first flight, which passes two gates before


def agrees(numbers: Numbers, law: str, plant: str = PLAIN) -> bool:
    """Whether a kernel passes its self-check, which runs once; the result is written beside the kernel in the cache.

    Args:
        numbers: kind of number of the kernel.
        law: its control law.
        plant: its kind of plant.

    Raises:
        HotlapError: the interpreter could not be started, or failed.
    """
    result_file = check_file_of(worker(numbers, law, plant))
    if result_file is None:  # there is no compiler that could be wrong
        return True
    kept = sealed.read(result_file)
    if kept in (AGREES, DIFFERS):
        return kept == AGREES
    result = check(numbers, law, plant)
    sealed.write(result_file, AGREES if result else DIFFERS)
    return result


def check(numbers: Numbers, law: str, plant: str = PLAIN) -> bool:
    """Run the self-check of a kernel; one that cannot be compiled does not pass.

    Args:
        numbers: kind of number of the kernel.
        law: its control law.
        plant: its kind of plant.

    Raises:
        HotlapError: the interpreter could not be started, or failed.
    """
    with interpreter(law, numbers.lanes, plant) as running:  # flies while the kernel is compiled
        try:
            flown = fly_compiled(numbers, law, plant)
        except (NumbaError, NotImplementedError, RuntimeError):
            return False
        return same(flown, arrays_of(answer_of(running)), TOLERANCES[kind_and_solver(law)[1]])


def same(flown: Sequence[Floats], expected: Sequence[Floats], tolerance: float = TOLERANCES[Solver.REAL_TIME]) -> bool:
    """Whether two lists of logs and judgements agree."""
    alike = len(flown) == len(expected) and all(a.shape == b.shape for a, b in zip(flown, expected, strict=True))
    return alike and all(np.allclose(a, b, rtol=tolerance, atol=tolerance) for a, b in zip(flown, expected, strict=True))


def compared(lanes: int) -> list[int]:
    """The flights that are flown twice: one of the first in the lanes, and two of those that refill them."""
    return [0, lanes, lanes + REFILLED - 1]


def draw_flights(scenario: Scenario, lanes: int) -> tuple[Parameters, NDArray[np.int64]]:
    """Parameters and seeds of more flights than there are lanes."""
    space, flights, rng = scenario.space, lanes + REFILLED, np.random.default_rng(0)
    steps = SPREAD * space.log_step * rng.standard_normal((flights, len(scenario.segments), space.size))
    return space.clip(space.default * np.exp(steps)), np.arange(flights, dtype=np.int64)


def fly_compiled(numbers: Numbers, law: str, plant: str = PLAIN) -> list[Floats]:
    """Fly all flights with a kernel.

    Returns:
        Logs of the flights that are compared, with the columns of `Job.logs`; and what the judge says of them.
    """
    scenario, rows = make_scenario(law, plant), compared(numbers.lanes)
    parameters, seeds = draw_flights(scenario, numbers.lanes)
    flown, _ = fly_batch(scenario, parameters, seeds, numbers=numbers, threads=1, log=rows)
    return _logged(flown, rows)


def fly_interpreted(law: str, lanes: int, plant: str = PLAIN) -> list[Floats]:
    """Fly the flights that are compared in plain Python, as `fly_compiled`; in a process without a compiler."""
    scenario, rows = make_scenario(law, plant), compared(lanes)
    parameters, seeds = draw_flights(scenario, lanes)
    with np.errstate(over="ignore"):  # hashes overflow
        flown, _ = fly_batch(scenario, parameters[rows], seeds[rows], numbers=Numbers.FLOAT64, threads=1, log=range(len(rows)))
    return _logged(flown, range(len(rows)))


def _logged(flown: Flights, rows: Sequence[int]) -> list[Floats]:
    """Logs of some flights of a record, and what the judge says of each in a row; what there is not is negative."""
    logs = [flown.logs[i] for i in rows]
    judged = np.column_stack([getattr(flown, name)[list(rows)] for name in JUDGED])
    return [*(np.hstack([log.states, log.rotor_thrusts, log.commands]) for log in logs), np.nan_to_num(judged, nan=-9.0)]


@contextmanager
def interpreter(law: str, lanes: int, plant: str = PLAIN) -> Iterator[subprocess.Popen[bytes]]:
    """A process without a compiler that does `fly_interpreted` and writes what it finds to its standard output.

    Raises:
        HotlapError: it cannot be started.
    """
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(path or "." for path in sys.path)}
    try:
        running = subprocess.Popen(
            [sys.executable or "python3", "-P", "-c", PROGRAM, law, str(lanes), plant],  # -P: nothing of the working folder
            env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
    except OSError as error:
        raise HotlapError(f"Python cannot be started to check the compiled flight core: {error.strerror}") from None
    with running:
        try:
            yield running
        finally:
            running.kill()


def answer_of(running: subprocess.Popen[bytes]) -> bytes:
    """Wait for the interpreter; what it has written.

    Raises:
        HotlapError: it failed.
    """
    answer, complaint = running.communicate()
    if running.returncode != 0:
        last = complaint.decode(errors="replace").strip().rpartition("\n")[2]
        raise HotlapError(f"the check of the compiled flight core failed: {last or f'exit status {running.returncode}'}")
    return answer


def arrays_of(answer: bytes) -> list[Floats]:
    """The arrays that the interpreter has written."""
    with np.load(BytesIO(answer), allow_pickle=False) as arrays:
        return [arrays[name] for name in arrays.files]


def write_answer(law: str, lanes: str, plant: str = PLAIN) -> None:
    """The program of the interpreter's process: fly, and write what was flown and judged to the standard output."""
    answer = BytesIO()
    np.savez(answer, *fly_interpreted(law, int(lanes), plant))
    sys.stdout.buffer.write(answer.getvalue())


def detailed_drone(plant: str) -> Quadrotor:
    """The drone of the self-check with everything that its kind of detailed plant computes."""
    mixer, pid, rotors = detailed_kind(plant)
    angles = 2 * math.pi * (np.arange(rotors) + 0.4) / rotors
    listed = [(DRONE.arm * math.cos(angle), DRONE.arm * math.sin(angle), (-1.0) ** k) for k, angle in enumerate(angles)]
    gains: dict[str, Any] = {"p": (0.06, 0.06, 0.1), "i": (0.3, 0.3, 0.3), "d": (3e-4, 3e-4, 3e-4), "d_cutoff": 60.0}
    loop = RateLoop(**gains, limit=LIMITS, output=Output.SPEED, idle=0.05)
    more = {
        "rotors": tuple(listed),
        "rotor_thrust": (0.0, 4 * DRONE.rotor_thrust[1] / rotors),
        "mixer": mixer,
        "rate_loop": loop if pid else None,
        "rate_delay": 0.009,
        "motor_lag": MotorLag.THRUST,
        "rotor_inertia": 1e-6,
        "rotor_speed": 2000.0,
        "inflow": 0.01,
    }
    return DRONE.model_copy(update=more)


def make_scenario(law: str, plant: str = PLAIN) -> Scenario:
    """The scenario of the self-check: hover at a place, which jumps away after half of the time."""
    rows, end = STEPS + 40, PERIOD * STEPS
    position, zeros = np.zeros((rows, 3)), np.zeros((rows, 3))
    position[STEPS // 2 :] = JUMP
    attitude, thrust, unknown = np.tile([1.0, 0.0, 0.0, 0.0], (rows, 1)), np.full(rows, DRONE.gravity), np.full((rows, 4), np.nan)
    reference = Reference(position, attitude, zeros, zeros, thrust, unknown, end - PERIOD * np.array([0.5, 0.25, 0.0]), end)
    track = Track(name="self-check", start=(0.0, 0.0, 0.0), gates=GATES, poles=(POLE,))
    kind, solver = kind_and_solver(law)
    settings = ControllerSettings(kind=kind, solver=solver, nodes=NODES, thrust=THRUST, horizon_unit=HORIZON_UNIT)
    judge = JudgeSettings(rule=GateRule.OPENING, window=(end, 0.0), fly_on=True)
    drone = DRONE if plant == PLAIN else detailed_drone(plant)
    race = Race(name="self-check", track=track, vehicle=drone, controller=settings, noise=NOISE, judge=judge)
    return Scenario(race, reference, Segments(np.array([0.0, end / 4]), (SegmentClass.FLAT, SegmentClass.FLAT), end))

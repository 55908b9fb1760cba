"""Self-check: do compiled lanes fly what the interpreter flies, which shares neither compiler nor kind of number with them?

Lanes lean on inner parts of Numba and on LLVM's code for vectors, which another release may change. So, once for each kernel that was
compiled, short flights are flown twice: by the kernel, and by the same functions uncompiled, in plain Python on float64. Controller,
plant, noise, judge and the refilling of lanes take part, with dead time, drag, two segments and bounds that are reached; neither a
file nor a planner does: a drone is to hover at a place that jumps away. A horizon of few nodes keeps the interpreter's share at about
a second; compiling a scalar controller to compare with would take seven.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from types import CellType, FunctionType, ModuleType, SimpleNamespace
from typing import Any

import numpy as np
from numba.core.errors import NumbaError
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters
from hotlap.flight.fly import fly_batch, prepare, settings_of
from hotlap.flight.judge import new_verdicts
from hotlap.flight.kernel import fly_queue, worker
from hotlap.flight.kernel_cache import remark_on
from hotlap.flight.numbers import Numbers
from hotlap.race.controllers import ControllerKind
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import ControllerSettings, JudgeSettings, NoiseSettings, Race
from hotlap.race.track import Gate, Track
from hotlap.reference.reference import PERIOD, Reference
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentClass, Segments

Floats = NDArray[np.float64]

STEPS, NODES = 24, 4  # control periods of a flight, nodes of the horizon
REFILLED = 3  # flights beyond one a lane
HORIZON_UNIT, SPREAD = 0.1, 0.3  # [s] of the horizon; of the logarithms of the parameters: half of the commands meet a bound
TOLERANCE = 2e-3  # of every number in a log, in its unit and relative: single precision stays below 5e-5
AGREES, DIFFERS = "agrees", "differs"

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
)
NOISE = NoiseSettings(
    position=0.3, velocity=1.0, attitude=0.1, measured_position=0.01, measured_velocity=0.01, measured_attitude=0.01, wind=1.0
)
JUMP = (1.0, -1.0, 1.0)  # m; a longer one asks for bang-bang, in which a rounding error may grow


def agrees(numbers: Numbers, kind: ControllerKind) -> bool:
    """Whether a kernel flies as it should; found out once, then written beside it in the kernel cache.

    Args:
        numbers: kind of number of the kernel.
        kind: its controller.
    """
    remark = remark_on(worker(numbers, kind))
    if remark is None:  # there is no compiler that could be wrong
        return True
    with suppress(OSError, UnicodeDecodeError):
        text = remark.read_text(encoding="ascii")
        if text in (AGREES, DIFFERS):
            return text == AGREES
    result = check(numbers, kind)
    with suppress(OSError):
        remark.parent.mkdir(parents=True, exist_ok=True)
        remark.write_text(AGREES if result else DIFFERS, encoding="ascii")
    return result


def check(numbers: Numbers, kind: ControllerKind) -> bool:
    """Fly both, and compare; a kernel that cannot be compiled does not fly as it should."""
    scenario, flights = make_scenario(kind), numbers.lanes + REFILLED
    space, rng = scenario.space, np.random.default_rng(0)
    steps = SPREAD * space.log_step * rng.standard_normal((flights, len(scenario.segments), space.size))
    parameters, seeds = space.clip(space.default * np.exp(steps)), np.arange(flights, dtype=np.int64)
    repeated = [0, numbers.lanes, flights - 1]  # the interpreter's share
    try:
        flown, _ = fly_batch(scenario, parameters, seeds, numbers=numbers, threads=1, log=repeated)
    except (NumbaError, NotImplementedError, RuntimeError):
        return False
    logs, errors = fly_interpreted(scenario, parameters[repeated], seeds[repeated])
    for k, i in enumerate(repeated):
        log = flown.logs[i]
        found = np.hstack([log.states, log.rotor_thrusts, log.commands])
        if found.shape != logs[k].shape or not np.allclose(found, logs[k], rtol=TOLERANCE, atol=TOLERANCE):
            return False
    return np.allclose(flown.mean_error[repeated], errors, rtol=TOLERANCE, atol=TOLERANCE)


def fly_interpreted(scenario: Scenario, parameters: Parameters, seeds: NDArray[np.int64]) -> tuple[list[Floats], Floats]:
    """Fly in plain Python.

    Returns:
        For each flight, its log with the columns of `Job.logs`; and the mean errors.
    """
    job, gates = prepare(scenario, parameters, seeds, Numbers.FLOAT64, None, range(len(seeds)))
    verdicts = new_verdicts(len(seeds), len(gates.times))
    changed = {"worker": lambda numbers, kind: interpreted(worker(numbers, kind))}
    fly = FunctionType(fly_queue.__code__, {**fly_queue.__globals__, **changed})
    with np.errstate(over="ignore"):  # hashes overflow
        fly(Numbers.FLOAT64, scenario.race.controller.kind, job, settings_of(scenario.race), gates, verdicts)
    return [log[: ticks + 1] for log, ticks in zip(job.logs, verdicts.ticks, strict=True)], verdicts.mean_error


def interpreted(function: Any, known: dict[Any, Callable[..., Any]] | None = None) -> Callable[..., Any]:
    """A function without its compiler, and without that of all that it calls.

    Args:
        function: compiled by Numba.
        known: functions of which there is an uncompiled one already.
    """
    known = {} if known is None else known

    def plain(value: Any) -> Any:
        if isinstance(value, ModuleType) and value.__name__.startswith("hotlap.flight."):
            return SimpleNamespace(**{name: plain(part) for name, part in vars(value).items()})
        return interpreted(value, known) if hasattr(value, "py_func") else value

    if function not in known:
        body, names = getattr(function, "py_func", function), {}
        closure = tuple(CellType(plain(cell.cell_contents)) for cell in body.__closure__ or ())
        known[function] = FunctionType(body.__code__, names, body.__name__, body.__defaults__, closure)
        names.update({name: plain(value) for name, value in body.__globals__.items()})
    return known[function]


def make_scenario(kind: ControllerKind) -> Scenario:
    """Hovering, at a place that jumps away after half the time."""
    rows, half, end = STEPS + 40, PERIOD * STEPS / 2, PERIOD * STEPS
    position, zeros = np.zeros((rows, 3)), np.zeros((rows, 3))
    position[STEPS // 2 :] = JUMP
    attitude, thrust, unknown = np.tile([1.0, 0.0, 0.0, 0.0], (rows, 1)), np.full(rows, DRONE.gravity), np.full((rows, 4), np.nan)
    reference = Reference(position, attitude, zeros, zeros, thrust, unknown, np.array([half - 0.25 * PERIOD, end]), end)
    track = Track(name="self-check", start=(0.0, 0.0, 0.0), gates=(Gate(position=(0.2, 0.1, 0.1)), Gate(position=JUMP)))
    settings, judge = ControllerSettings(kind=kind, nodes=NODES, horizon_unit=HORIZON_UNIT), JudgeSettings(fly_on=True)
    race = Race(name="self-check", track=track, vehicle=DRONE, controller=settings, noise=NOISE, judge=judge)
    return Scenario(race, reference, Segments(np.array([0.0, half / 2]), (SegmentClass.FLAT, SegmentClass.FLAT), end))

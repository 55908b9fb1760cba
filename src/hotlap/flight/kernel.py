"""Simulates closed-loop flights: lanes fly a queue of them, and a lane starts the next flight as soon as its own has ended.

Every control step is done on all lanes at once (controller, plant), and lane by lane (reference, noise, judge). A lane has its own
clock, so that lanes may be at different times of different flights.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.flight import noise
from hotlap.flight.control_loop import ControlLoop, allocate_control_loop, begin_control_loop
from hotlap.flight.job import LOG_COLUMNS, Job, Settings
from hotlap.flight.judge import Gates, Verdicts, judge
from hotlap.flight.kernel_cache import keep
from hotlap.flight.lanes import as_numbers, borrow, fetch_and_add
from hotlap.flight.lending import lend, lend_parts
from hotlap.flight.numbers import COMPILE, INLINE, INNER, Numbers
from hotlap.flight.plant import MASS, THRUST_FACTOR, WIND, VehicleState
from hotlap.flight.plants import plant_functions
from hotlap.flight.registry import CONTROLLERS
from hotlap.flight.segment_switch import FRESH
from hotlap.race.battery import MOST_LOST
from hotlap.race.controllers import ControllerKind
from hotlap.race.plant_kind import PLAIN

Allocate = Callable[[int, type[np.floating[Any]]], Any]

IDLE = -1
HARDLY = 1e-3  # m: a start that lies less below the floor lies on it


class Lane(NamedTuple):
    """State of each lane, raw arrays.

    Attributes:
        flight: (lanes,) index in the batch, or IDLE.
        tick: (lanes,) control steps since its start.
        piece: (lanes,) of the reference that its parameters belong to.
        correlated: (7, lanes) correlated noise: thrust, rates, wind.
        thrust: (2, lanes) factor of the thrust at the start, and share of it that the battery has lost by its charge.
    """

    flight: Any
    tick: Any
    piece: Any
    correlated: Any
    thrust: Any


def allocate_lanes(lanes: int) -> Lane:
    """Lanes without a flight."""
    flight, tick, piece = (np.full(lanes, value, dtype=np.int64) for value in (IDLE, 0, FRESH))
    return Lane(flight, tick, piece, correlated=np.zeros((7, lanes)), thrust=np.zeros((2, lanes)))


def fly_queue(
    numbers: Numbers, law: str, plant: str, allocate: Allocate, job: Job, settings: Settings, gates: Gates, verdicts: Verdicts
) -> NDArray[np.int64]:
    """Fly all flights of a queue in this thread; other threads may fly flights of the same queue meanwhile.

    Args:
        numbers: kind of number to compute in.
        law: of the controller.
        plant: kind of plant.
        allocate: its `plants.allocator`.
        job: flights as plain arrays.
        settings: that they share.
        gates: of the track.
        verdicts: where the judge writes.

    Returns:
        Control steps of all lanes, and of lanes that flew, shape (2,).
    """
    lanes, real, effort = numbers.lanes, numbers.dtype, np.zeros(2, dtype=np.int64)
    commands = max(int(job.delay_periods.max(initial=0)), settings.predicted_periods, settings.acted_periods) + 2
    controller = CONTROLLERS[law].allocate(settings, lanes, real)
    memory = controller, allocate_control_loop(commands, lanes, real), allocate(lanes, real)
    worker(numbers, law, plant)(job, settings, gates, verdicts, *memory, allocate_lanes(lanes), effort)
    return effort


@cache
def worker(numbers: Numbers, law: str = ControllerKind.MPC, plant: str = PLAIN) -> Callable[..., None]:
    """The compiled function (kernel) that flies a queue, for a kind of number, a control law and a kind of plant.

    Several threads may call it for one job.

    Its arguments are those of `work` below; `effort` counts control steps of all lanes, and of lanes that flew, shape (2,).
    """
    width, lanes = numbers.width, numbers.lanes
    begin, aim, control = CONTROLLERS[law].begin, CONTROLLERS[law].aim, CONTROLLERS[law].control
    settle, fly_period = plant_functions(plant)

    def work(
        job: Job,
        s: Settings,
        gates: Gates,
        verdicts: Verdicts,
        memory: Any,
        loop: ControlLoop,
        vehicle_state: VehicleState,
        lane: Lane,
        effort: np.ndarray,
    ) -> None:
        job, gates, verdicts = borrow(job), lend_parts(gates), lend(verdicts)
        memory, loop, vehicle_state, lane = borrow(memory), borrow(loop), borrow(vehicle_state), borrow(lane)
        m, p, c = as_numbers(memory, width), as_numbers(loop, width), as_numbers(vehicle_state, width)
        noisy = s.measured_position + s.measured_velocity + s.measured_attitude > 0
        busy = 0
        for k in range(lanes):
            busy += start_next_flight(job, s, gates.floor, loop, vehicle_state, lane, k)
            begin(job, s, memory, k)
            settle(vehicle_state, k)
        while busy > 0:
            effort[0] += lanes
            effort[1] += busy
            for i in range(10):
                p.seen[i] = c.state[i]
            for k in range(lanes):
                if lane.flight[k] != IDLE:
                    if noisy:
                        add_measurement_noise(job, s, loop, lane, k)
                    lane.piece[k] = aim(job, s, memory, loop, k, lane.flight[k], lane.piece[k], lane.tick[k] * s.period, s.period)
            control(s, m, p)
            for k in range(lanes):
                if lane.flight[k] != IDLE:
                    actuate(job, s, loop, vehicle_state, lane, k)
            fly_period(c, s.steps)
            for k in range(lanes):
                if lane.flight[k] != IDLE and vehicle_state.state[2, k] < gates.floor:
                    _stand(gates, verdicts, vehicle_state, lane, k)
                if lane.flight[k] != IDLE and judge_period(job, s, gates, verdicts, loop, vehicle_state, lane, k):
                    busy += start_next_flight(job, s, gates.floor, loop, vehicle_state, lane, k) - 1
                    begin(job, s, memory, k)
                    settle(vehicle_state, k)

    return keep(njit(**COMPILE)(work), f"{law}-{numbers}" if plant == PLAIN else f"{law}-{numbers}-{plant}")


@njit(**COMPILE)
def start_next_flight(job: Job, s: Settings, floor: float, loop: ControlLoop, vehicle_state: VehicleState, lane: Lane, k: int) -> int:
    """Begin the next flight of the queue in a lane; 0 if there is none."""
    i = fetch_and_add(job.queue)
    if i >= len(job.seeds):
        lane.flight[k] = IDLE
        return 0
    start_flight(job, s, floor, loop, vehicle_state, lane, k, i)
    return 1


@njit(**COMPILE)
def start_flight(job: Job, s: Settings, floor: float, loop: ControlLoop, vehicle_state: VehicleState, lane: Lane, k: int, i: int) -> None:
    """Begin flight i in a lane."""
    lane.flight[k], lane.tick[k], lane.piece[k] = i, 0, FRESH
    vehicle, seed = min(i, len(job.vehicles) - 1), job.seeds[i]
    for n in range(len(vehicle_state.vehicle)):
        vehicle_state.vehicle[n, k] = job.vehicles[vehicle, n]
    for n in range(len(vehicle_state.autopilot)):
        vehicle_state.autopilot[n, k] = job.autopilot[n]
    vehicle_state.older_steps[0, k], vehicle_state.step[0, k] = job.delay_steps[vehicle], s.plant_step
    vehicle_state.disturbance[:, k] = 0
    vehicle_state.disturbance[THRUST_FACTOR, k] = 1 + s.thrust_bias * noise.normal(seed, 0, noise.BIAS)
    lane.thrust[0, k], lane.thrust[1, k] = 1 + s.thrust_bias * noise.normal(seed, 0, noise.BIAS), 0
    _place(job, s, floor, vehicle_state, k, seed, job.vehicles[vehicle, MASS])
    begin_control_loop(job, s, loop, k)
    lane.correlated[:, k] = 0
    vehicle_state.acting[:, k] = 0
    vehicle_state.acting[0, k] = s.gravity


@njit(**COMPILE)
def _place(job: Job, s: Settings, floor: float, vehicle_state: VehicleState, k: int, seed: int, mass: float) -> None:
    """Put a lane's drone near the start of the reference, hovering, and not under the floor."""
    for i in range(10):
        vehicle_state.state[i, k] = job.table[0, i]
    for i in range(3):
        vehicle_state.state[i, k] += s.position * noise.normal(seed, 0, noise.POSITION + i)
        vehicle_state.state[7 + i, k] += s.velocity * noise.normal(seed, 0, noise.VELOCITY + i)
        vehicle_state.state[4 + i, k] += s.attitude * noise.normal(seed, 0, noise.ATTITUDE + i)
        vehicle_state.state[10 + i, k] = 0
    if vehicle_state.state[2, k] < floor <= job.table[0, 2] + HARDLY:
        vehicle_state.state[2, k] = floor
    norm = math.sqrt(
        vehicle_state.state[3, k] ** 2 + vehicle_state.state[4, k] ** 2 + vehicle_state.state[5, k] ** 2 + vehicle_state.state[6, k] ** 2
    )
    for i in range(3, 7):
        vehicle_state.state[i, k] /= norm
    for i in range(13, 17):
        vehicle_state.state[i, k] = math.sqrt(s.gravity * mass / 4)


@njit(**INLINE)
def add_measurement_noise(job: Job, s: Settings, loop: ControlLoop, lane: Lane, k: int) -> None:
    """Add measurement noise to the state that the controller sees."""
    seed, step, seen = job.seeds[lane.flight[k]], lane.tick[k] + 1, loop.seen
    for i in range(3):
        seen[i, k] += s.measured_position * noise.normal(seed, step, noise.MEASURED + i)
        seen[7 + i, k] += s.measured_velocity * noise.normal(seed, step, noise.MEASURED + 3 + i)
        seen[4 + i, k] += s.measured_attitude * noise.normal(seed, step, noise.MEASURED + 6 + i)
    norm = math.sqrt(seen[3, k] ** 2 + seen[4, k] ** 2 + seen[5, k] ** 2 + seen[6, k] ** 2)
    for i in range(3, 7):
        seen[i, k] /= norm


@njit(**INLINE)
def actuate(job: Job, s: Settings, loop: ControlLoop, vehicle_state: VehicleState, lane: Lane, k: int) -> None:
    """Set the command that acts from now on, with actuation noise, which is correlated from step to step; the wind; and the log."""
    i, step = lane.flight[k], lane.tick[k] + 1
    seed, delay = job.seeds[i], job.delay_periods[min(i, len(job.delay_periods) - 1)]
    fresh = math.sqrt(1 - s.noise_memory**2)
    for a in range(4):
        lane.correlated[a, k] = s.noise_memory * lane.correlated[a, k] + fresh * noise.normal(seed, step, noise.THRUST + a)
        vehicle_state.older[a, k], vehicle_state.acting[a, k] = vehicle_state.acting[a, k], loop.history[delay, a, k]
    vehicle_state.acting[0, k] *= 1 + s.thrust_noise * lane.correlated[0, k]
    for a in range(1, 4):
        vehicle_state.acting[a, k] += s.rate_noise * lane.correlated[a, k]
    if s.wind > 0:
        fresh = math.sqrt(1 - s.wind_memory**2)
        for a in range(3):
            lane.correlated[4 + a, k] = s.wind_memory * lane.correlated[4 + a, k] + fresh * noise.normal(seed, step, noise.WIND + a)
            vehicle_state.disturbance[WIND + a, k] = s.wind * lane.correlated[4 + a, k]
    if s.steady_wind > 0:
        _add_steady_wind(s, vehicle_state, seed, k)
    if s.sagging:
        _draw_battery(job, s, vehicle_state, lane, k)
    _log(job, s, loop, vehicle_state, lane, k)


@njit(**INNER)
def _add_steady_wind(s: Settings, vehicle_state: VehicleState, seed: int, k: int) -> None:
    """Add the steady wind to a lane's gusts: level, from a direction that depends on the flight's seed."""
    x, y = noise.normal(seed, 0, noise.HEADING), noise.normal(seed, 0, noise.HEADING + 1)
    size = math.sqrt(x * x + y * y)
    if s.wind <= 0:
        vehicle_state.disturbance[WIND, k], vehicle_state.disturbance[WIND + 1, k] = 0, 0
    if size > 0:
        vehicle_state.disturbance[WIND, k] += s.steady_wind * x / size
        vehicle_state.disturbance[WIND + 1, k] += s.steady_wind * y / size


@njit(**INNER)
def _draw_battery(job: Job, s: Settings, vehicle_state: VehicleState, lane: Lane, k: int) -> None:
    """Take from a lane's thrust what the battery has lost up to the beginning of this period; see `hotlap.race.battery`."""
    i, passed = min(lane.flight[k], len(job.sags) - 1), min(lane.tick[k] * s.period / s.duration, 1.0)
    lost = min(job.sags[i, 0] * passed + lane.thrust[1, k], MOST_LOST)
    vehicle_state.disturbance[THRUST_FACTOR, k] = lane.thrust[0, k] * (1 - lost)
    newtons = 0.0
    for n in range(13, 17):
        newtons += float(vehicle_state.state[n, k]) ** 2
    for n in range(17, 13 + s.rotors):
        newtons += float(vehicle_state.state[n, k]) ** 2
    lane.thrust[1, k] += job.sags[i, 1] * newtons * math.sqrt(newtons) * s.period


@njit(**INLINE)
def _log(job: Job, s: Settings, loop: ControlLoop, vehicle_state: VehicleState, lane: Lane, k: int) -> None:
    """Write state and command of a flight that is logged."""
    row, tick = job.log_rows[lane.flight[k]], lane.tick[k]
    if row >= 0:
        for n in range(13):
            job.logs[row, tick, n] = vehicle_state.state[n, k]
        for n in range(4):
            job.logs[row, tick, 13 + n] = loop.history[0, n, k]
            job.logs[row, tick, 17 + n] = loop.estimate[n, k]
        for n in range(s.rotors):
            job.logs[row, tick, LOG_COLUMNS + n] = vehicle_state.state[13 + n, k] ** 2


@njit(**INNER)
def _stand(gates: Gates, verdicts: Verdicts, vehicle_state: VehicleState, lane: Lane, k: int) -> None:
    """Keep a lane's drone on the ground until it takes off."""
    if verdicts.airborne[lane.flight[k]] == 0:
        vehicle_state.state[2, k] = gates.floor
        vehicle_state.state[9, k] = max(float(vehicle_state.state[9, k]), 0.0)


@njit(**INLINE)
def judge_period(
    job: Job, s: Settings, gates: Gates, verdicts: Verdicts, loop: ControlLoop, vehicle_state: VehicleState, lane: Lane, k: int
) -> bool:
    """Judge the control period that a lane has flown; returns whether its flight is over."""
    start = lane.tick[k] * s.period
    lane.tick[k] += 1
    time = lane.tick[k] * s.period
    place = time / s.table_period
    row = min(int(place), len(job.table) - 2)
    share = min(place - row, 1.0)
    reference = (
        job.table[row, 0] + share * (job.table[row + 1, 0] - job.table[row, 0]),
        job.table[row, 1] + share * (job.table[row + 1, 1] - job.table[row, 1]),
        job.table[row, 2] + share * (job.table[row + 1, 2] - job.table[row, 2]),
    )
    before, now = _position(vehicle_state.before, k), _position(vehicle_state.state, k)
    fastest = max(abs(float(vehicle_state.state[10, k])), abs(float(vehicle_state.state[11, k])), abs(float(vehicle_state.state[12, k])))
    over = judge(verdicts, lane.flight[k], gates, start, before, time, now, reference, fastest)
    if over:
        _log(job, s, loop, vehicle_state, lane, k)
    return over


@njit(**INLINE)
def _position(state: np.ndarray, k: int) -> Any:
    return (float(state[0, k]), float(state[1, k]), float(state[2, k]))

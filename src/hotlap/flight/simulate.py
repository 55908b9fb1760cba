"""Closed-loop flights: a queue of them flown by lanes that take the next one as soon as theirs has ended.

Every control step is done on all lanes at once (controller, plant), and lane by lane (reference, noise, judge). A lane has its own
clock, so that flights of one group may be at different times of different flights.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from hotlap.flight import noise
from hotlap.flight.judge import Gates, Verdicts, judge
from hotlap.flight.kernel_cache import keep
from hotlap.flight.lanes import as_numbers, number, take
from hotlap.flight.mpc import Mpc, allocate_mpc, propagate, solve
from hotlap.flight.numbers import COMPILE, Numbers
from hotlap.flight.plant import Craft, allocate_craft, fly_period
from hotlap.flight.tracking import hover_inputs, plan_as_reference, read_reference, respace_plan

LOG_COLUMNS = 21  # p q v w, rotor thrusts, command
IDLE = -1


class Settings(NamedTuple):
    """What all flights share, as plain numbers; see `ControllerSettings` and `NoiseSettings`.

    Attributes:
        nodes, sweeps: of the controller.
        period: [s] of the control loop.
        steps: of the plant in each period.
        plant_step: [s].
        table_period: [s] between rows of the reference.
        lead: [s] by which the reference that the controller compares with lies ahead.
        predicted_periods, predicted_rest: whole periods, and the rest [s], over which it predicts the state.
        feed_forward: the reference's inputs, else hover.
        gravity: [m/s^2] of the controller's model.
        thrust_noise, rate_noise, noise_memory: actuation; the memory is that of one period.
        thrust_bias, position, velocity, attitude: of a flight's beginning.
        measured_position, measured_velocity, measured_attitude: what the controller sees.
        wind, wind_memory: gusts.
    """

    nodes: int
    sweeps: int
    period: float
    steps: int
    plant_step: float
    table_period: float
    lead: float
    predicted_periods: int
    predicted_rest: float
    feed_forward: bool
    gravity: float
    thrust_noise: float
    rate_noise: float
    noise_memory: float
    thrust_bias: float
    position: float
    velocity: float
    attitude: float
    measured_position: float
    measured_velocity: float
    measured_attitude: float
    wind: float
    wind_memory: float


class Job(NamedTuple):
    """B flights over S segments that are to be flown.

    Attributes:
        table: (rows, 14) reference: p q v, thrust per mass, rates; its kind of float is that of the flights.
        row_segments: (rows,) segment at each row.
        parameters: (B, S, 5) Q of p_xy, p_z, attitude, velocity; spacing of the nodes [s].
        seeds: (B,).
        input_weights: (4,) R.
        low, high: (4,) bounds of the inputs.
        vehicles: (B or 1, V) as `plant.vehicle_numbers` gives them.
        delay_periods, delay_steps: (B or 1,) dead time in control periods and, beyond them, in steps of the plant.
        autopilot: (A,).
        log_rows: (B,) row in `logs`, -1 for a flight that is not logged.
        logs: (L, periods + 1, 21).
        queue: (1,) next flight that nobody flies yet.
    """

    table: Any
    row_segments: Any
    parameters: Any
    seeds: Any
    input_weights: Any
    low: Any
    high: Any
    vehicles: Any
    delay_periods: Any
    delay_steps: Any
    autopilot: Any
    log_rows: Any
    logs: Any
    queue: Any


class Lane(NamedTuple):
    """Memory of the lanes besides controller and vehicle, raw.

    Attributes:
        flight: (lanes,) index in the batch, or IDLE.
        tick: (lanes,) control steps since its start.
        segment: (lanes,) that its weights are of; -1 before the first step.
        chance: (7, lanes) correlated noise: thrust, rates, wind.
        history: (H, 4, lanes) commands, the newest first.
        shift: (1, lanes) share of a node by which the plan moves on.
        span: (1, lanes) [s] of a prediction.
        predicted: (10, lanes).
    """

    flight: Any
    tick: Any
    segment: Any
    chance: Any
    history: Any
    shift: Any
    span: Any
    predicted: Any


@njit(**COMPILE)
def allocate_lane(commands: int, lanes: int, like: np.ndarray) -> Lane:
    """Memory for lanes that have no flight."""
    kind = like.dtype
    return Lane(
        np.full(lanes, IDLE, np.int64),
        np.zeros(lanes, np.int64),
        np.full(lanes, -1, np.int64),
        np.zeros((7, lanes), np.float64),
        np.zeros((commands, 4, lanes), kind),
        np.zeros((1, lanes), kind),
        np.zeros((1, lanes), kind),
        np.zeros((10, lanes), kind),
    )


@cache
def worker(numbers: Numbers) -> Callable[[Job, Settings, Gates, Verdicts, np.ndarray], None]:
    """The function that flies a queue to its end, for one kind of number; several threads may call it for the same job.

    Its last argument counts control steps of all lanes, and of lanes that flew, shape (2,).
    """
    width, lanes = numbers.width, numbers.lanes

    def work(job: Job, s: Settings, gates: Gates, verdicts: Verdicts, effort: np.ndarray) -> None:
        commands = max(job.delay_periods.max() + 2, s.predicted_periods + 2)
        mpc, craft, lane = (
            allocate_mpc(s.nodes, lanes, job.table),
            allocate_craft(lanes, job.table),
            allocate_lane(commands, lanes, job.table),
        )
        m, c = as_numbers(mpc, width), as_numbers(craft, width)
        history, shift = as_numbers(lane.history, width), as_numbers(lane.shift, width)
        span, predicted = as_numbers(lane.span, width), as_numbers(lane.predicted, width)
        busy = 0
        for k in range(lanes):
            busy += _take_flight(job, s, mpc, craft, lane, k)
        while busy > 0:
            effort[0] += lanes
            effort[1] += busy
            for k in range(lanes):
                if lane.flight[k] != IDLE:
                    _aim(job, s, mpc, lane, k)
            _move_on(m, shift)
            for i in range(10):
                m.X[0, i] = c.state[i]
            if s.measured_position + s.measured_velocity + s.measured_attitude > 0:
                for k in range(lanes):
                    _measure(job, s, mpc, lane, k)
            _predict(s, m, history, span, predicted)
            solve(m, s.sweeps)
            _issue(m, history)
            for k in range(lanes):
                if lane.flight[k] != IDLE:
                    _actuate(job, s, craft, lane, k)
            fly_period(c, s.steps)
            for k in range(lanes):
                if lane.flight[k] != IDLE and _rule(job, s, gates, verdicts, craft, lane, k):
                    busy += _take_flight(job, s, mpc, craft, lane, k) - 1

    return keep(njit(**COMPILE)(work), numbers)


@njit(**COMPILE)
def _take_flight(job: Job, s: Settings, mpc: Mpc, craft: Craft, lane: Lane, k: int) -> int:
    """Begin the next flight of the queue in a lane; 0 if there is none."""
    i = take(job.queue)
    if i >= len(job.seeds):
        lane.flight[k] = IDLE
        return 0
    lane.flight[k], lane.tick[k], lane.segment[k] = i, 0, -1
    vehicle, seed = min(i, len(job.vehicles) - 1), job.seeds[i]
    for n in range(len(craft.vehicle)):
        craft.vehicle[n, k] = job.vehicles[vehicle, n]
    for n in range(len(craft.autopilot)):
        craft.autopilot[n, k] = job.autopilot[n]
    craft.older_steps[0, k], craft.step[0, k] = job.delay_steps[vehicle], s.plant_step
    craft.disturbance[:, k] = 0
    craft.disturbance[0, k] = 1 + s.thrust_bias * noise.normal(seed, 0, noise.BIAS)
    _place(job, s, craft, k, seed, job.vehicles[vehicle, 0])
    for n in range(4):
        mpc.input_weights[n, k], mpc.low[n, k], mpc.high[n, k] = job.input_weights[n], job.low[n], job.high[n]
    mpc.gravity[0, k] = s.gravity
    lane.chance[:, k] = 0
    lane.history[:, :, k] = 0
    lane.history[:, 0, k] = s.gravity
    craft.acting[:, k] = 0
    craft.acting[0, k] = s.gravity
    return 1


@njit(**COMPILE)
def _place(job: Job, s: Settings, craft: Craft, k: int, seed: int, mass: float) -> None:
    """Put a lane's drone near the start of the reference, hovering."""
    for i in range(10):
        craft.state[i, k] = job.table[0, i]
    for i in range(3):
        craft.state[i, k] += s.position * noise.normal(seed, 0, noise.POSITION + i)
        craft.state[7 + i, k] += s.velocity * noise.normal(seed, 0, noise.VELOCITY + i)
        craft.state[4 + i, k] += s.attitude * noise.normal(seed, 0, noise.ATTITUDE + i)
        craft.state[10 + i, k] = 0
    norm = math.sqrt(craft.state[3, k] ** 2 + craft.state[4, k] ** 2 + craft.state[5, k] ** 2 + craft.state[6, k] ** 2)
    for i in range(3, 7):
        craft.state[i, k] /= norm
    for i in range(13, 17):
        craft.state[i, k] = math.sqrt(s.gravity * mass / 4)


@njit(**COMPILE)
def _aim(job: Job, s: Settings, mpc: Mpc, lane: Lane, k: int) -> None:
    """Reference and weights of a lane's control step, and how its plan moves on."""
    time = lane.tick[k] * s.period + s.lead
    segment = job.row_segments[min(int(time / s.table_period + 1e-6), len(job.row_segments) - 1)]
    before = lane.segment[k]
    parameters = job.parameters[lane.flight[k], segment]
    spacing = parameters[4]
    read_reference(mpc, k, job.table, s.table_period, time, spacing)
    if not s.feed_forward:
        hover_inputs(mpc, k)
    lane.shift[0, k] = 0
    if before == segment:
        lane.shift[0, k] = min(s.period / spacing, 1.0)
        return
    if before < 0:
        plan_as_reference(mpc, k)
    else:
        respace_plan(mpc, k, job.parameters[lane.flight[k], before, 4], spacing, s.period)
    for n in range(4):
        mpc.weights[n, k] = parameters[n]
    mpc.spacing[0, k] = spacing
    lane.segment[k] = segment


@njit(**COMPILE)
def _move_on(m: Mpc, shift: Any) -> None:
    """Move the plan on by a share of a node: the warm start."""
    for n in range(len(m.U)):
        for i in range(10):
            m.X[n, i] += shift[0] * (m.X[n + 1, i] - m.X[n, i])
    for n in range(len(m.U) - 1):
        for a in range(4):
            m.U[n, a] += shift[0] * (m.U[n + 1, a] - m.U[n, a])


@njit(**COMPILE)
def _measure(job: Job, s: Settings, mpc: Mpc, lane: Lane, k: int) -> None:
    """Add what sensors get wrong to the state that the controller sees."""
    if lane.flight[k] == IDLE:
        return
    seed, step = job.seeds[lane.flight[k]], lane.tick[k] + 1
    for i in range(3):
        mpc.X[0, i, k] += s.measured_position * noise.normal(seed, step, noise.MEASURED + i)
        mpc.X[0, 7 + i, k] += s.measured_velocity * noise.normal(seed, step, noise.MEASURED + 3 + i)
        mpc.X[0, 4 + i, k] += s.measured_attitude * noise.normal(seed, step, noise.MEASURED + 6 + i)
    norm = math.sqrt(mpc.X[0, 3, k] ** 2 + mpc.X[0, 4, k] ** 2 + mpc.X[0, 5, k] ** 2 + mpc.X[0, 6, k] ** 2)
    for i in range(3, 7):
        mpc.X[0, i, k] /= norm


@njit(**COMPILE)
def _predict(s: Settings, m: Mpc, history: Any, span: Any, predicted: Any) -> None:
    """Where the drone will be when the command acts: through the commands on their way, by the controller's own model."""
    for n in range(s.predicted_periods, -1, -1):
        duration = s.predicted_rest if n == s.predicted_periods else s.period
        if duration > 0:
            span[0] = number(m.X[0, 0], duration)
            propagate(m.X[0], history[n], span, m.gravity, predicted)
            for i in range(10):
                m.X[0, i] = predicted[i]


@njit(**COMPILE)
def _issue(m: Mpc, history: Any) -> None:
    """Remember the command of this step."""
    for n in range(len(history) - 1, 0, -1):
        for a in range(4):
            history[n, a] = history[n - 1, a]
    for a in range(4):
        history[0, a] = m.U[0, a]


@njit(**COMPILE)
def _actuate(job: Job, s: Settings, craft: Craft, lane: Lane, k: int) -> None:
    """The command that acts from now on, with its noise, which is correlated from step to step; gusts; and the log."""
    i, step = lane.flight[k], lane.tick[k] + 1
    seed, delay = job.seeds[i], job.delay_periods[min(i, len(job.delay_periods) - 1)]
    fresh = math.sqrt(1 - s.noise_memory**2)
    for a in range(4):
        lane.chance[a, k] = s.noise_memory * lane.chance[a, k] + fresh * noise.normal(seed, step, noise.THRUST + a)
        craft.older[a, k], craft.acting[a, k] = craft.acting[a, k], lane.history[delay, a, k]
    craft.acting[0, k] *= 1 + s.thrust_noise * lane.chance[0, k]
    for a in range(1, 4):
        craft.acting[a, k] += s.rate_noise * lane.chance[a, k]
    if s.wind > 0:
        fresh = math.sqrt(1 - s.wind_memory**2)
        for a in range(3):
            lane.chance[4 + a, k] = s.wind_memory * lane.chance[4 + a, k] + fresh * noise.normal(seed, step, noise.WIND + a)
            craft.disturbance[1 + a, k] = s.wind * lane.chance[4 + a, k]
    _log(job, craft, lane, k)


@njit(**COMPILE)
def _log(job: Job, craft: Craft, lane: Lane, k: int) -> None:
    """Keep state and command of a flight that is logged."""
    row, tick = job.log_rows[lane.flight[k]], lane.tick[k]
    if row >= 0:
        for n in range(13):
            job.logs[row, tick, n] = craft.state[n, k]
        for n in range(4):
            job.logs[row, tick, 13 + n] = craft.state[13 + n, k] ** 2
            job.logs[row, tick, 17 + n] = lane.history[0, n, k]


@njit(**COMPILE)
def _rule(job: Job, s: Settings, gates: Gates, verdicts: Verdicts, craft: Craft, lane: Lane, k: int) -> bool:
    """Judge the period that a lane has flown; whether its flight is over."""
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
    before, now = _position(craft.before, k), _position(craft.state, k)
    fastest = max(abs(float(craft.state[10, k])), abs(float(craft.state[11, k])), abs(float(craft.state[12, k])))
    over = judge(verdicts, lane.flight[k], gates, start, before, time, now, reference, fastest)
    if over:
        _log(job, craft, lane, k)
    return over


@njit(**COMPILE)
def _position(state: np.ndarray, k: int) -> Any:
    return (float(state[0, k]), float(state[1, k]), float(state[2, k]))

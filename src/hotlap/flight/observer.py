"""The observer of offset-free control: what the controller learns in flight about a vehicle that is not its model.

A controller without integral action keeps an error wherever its model is wrong. Offset-free MPC adds what the model leaves out as
states that do not change by themselves, estimates them with an observer, and corrects model and target for them (Muske, Badgwell,
J. Process Control 12, 2002; Pannocchia, Rawlings, AIChE J. 49, 2003; Maeder, Borrelli, Morari, Automatica 45, 2009). Here these are k,
the thrust effectiveness, and d, an acceleration (world); velocity v and body z from the measured state tell about them:

    v- = v + h (k T z - g e3 - drag + d),   e = v_measured - v-
    v  = v- + (1 - r^2) e,   d += (1 - r_d)^2 / h e,   k += (1 - r_k)^2 / h (z . e) T / (T^2 + T_0^2),   r = exp(-bandwidth h)

T is the thrust that was commanded a known dead time ago, within the rotors' limits and behind the motors' lag. At full thrust k is
not learnt: rotors that can give no more say nothing about the thrust of a command.

The controller plans effective thrust: it commands T / k, may plan up to k times what may be commanded, and predicts with k times what was
commanded. At each node of the horizon a = d - drag, of the last plan, acts besides the model, and the node's target makes up for it:
thrust and body z of T z = T_ref z_ref - a, by the least tilt, where the table of the reference has no drag (`drag_free`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.dynamics.parameter_layout import MODEL
from hotlap.flight.compile import compiled, compiled_dynamics
from hotlap.flight.job import Settings
from hotlap.flight.lanes import number, select
from hotlap.flight.numbers import INLINE
from hotlap.flight.program import Number, Program, Tape, dot
from hotlap.race.controllers import ControllerKind
from hotlap.race.race import Race
from hotlap.reference.attitude import product, thrust_axis
from hotlap.reference.reference import Reference

Floats = NDArray[np.float64]

EFFECTIVENESS, DISTURBANCE, VELOCITY, AXIS, ROOT, FRESH = 0, 1, 4, 7, 10, 11
"""Places in an estimate: k, d, v, body z at the step before, square root of the thrust, and whether it has seen no state yet."""
ESTIMATE_SIZE = 12
PERIOD, GRAVITY, LEAST, MOST, SPEED_GAIN, DISTURBANCE_GAIN, EFFECTIVENESS_GAIN, SPIN_UP, SPIN_DOWN = range(9)
"""Places in the observer's numbers: h, g, the rotors' least and largest thrust per mass, gains, shares of the motors' lag in a period."""
OBSERVER_SIZE = 9
EFFECTIVENESS_LIMITS = (0.6, 1.4)
LARGEST_DISTURBANCE = 12.0  # m/s^2, along each axis
FULL = 0.97  # share of the rotors' thrust from which on k is not learnt
EASY = 2.0  # m/s^2, T_0: below it the thrust says little about k; a target that is weaker has no direction
LONGEST_STEP = 2.5  # control periods, over which an observation counts


def observer_numbers(race: Race, elapsed: float | None = None) -> Floats:
    """What the observer computes with, shape (G,), at the places above.

    Args:
        race: whose controller.
        elapsed: [s] over which it observes. None: a control period.
    """
    controller, model = race.controller, race.control_model
    h, settings = controller.period if elapsed is None else elapsed, controller.observer
    fastest, acceleration, thrust = (
        math.exp(-bandwidth * h) for bandwidth in (max(settings.thrust, settings.acceleration), settings.acceleration, settings.thrust)
    )
    least, most = (model.rotor_count * thrust / model.mass for thrust in model.rotor_thrust)
    up, down = (1 - math.exp(-h / time) if time > 0 else 1.0 for time in model.motor_time)
    return np.array([h, model.gravity, least, most, 1 - fastest**2, (1 - acceleration) ** 2 / h, (1 - thrust) ** 2 / h, up, down])


def known_drag(race: Race, model_numbers: Floats) -> Floats:
    """The control model's parameters, shape (M,), with drags where the controller knows of them."""
    if race.controller.reference_drag or race.controller.kind is ControllerKind.MPC_DRAG:
        return model_numbers
    names = [name for name, size in MODEL.items() for _ in range(size)]
    return np.where([name in ("gravity", "mass") for name in names], model_numbers, 0.0)


def drag_free(reference: Reference, gravity: float) -> Floats:
    """The reference's table, shape (rows, 14), with thrust and attitude as a vehicle without drag needs them for its accelerations.

    Attitudes are turned by the least tilt, and kept where the thrust is weak or would turn over.
    """
    table = reference.table
    wanted = np.gradient(table[:, 7:10], reference.period, axis=0) + np.array([0.0, 0.0, gravity])
    size = np.linalg.norm(wanted, axis=1, keepdims=True)
    axis, z = wanted / np.maximum(size, EASY), thrust_axis(table[:, 3:7])
    along = np.einsum("ij,ij->i", axis, z)[:, None]
    turn = np.hstack([1 + along, np.cross(z, axis)])
    turned = product(turn / np.maximum(np.linalg.norm(turn, axis=1, keepdims=True), 1e-9), table[:, 3:7])
    clear = (size > EASY) & (along > 0)
    table[:, 3:7] = np.where(clear, turned, table[:, 3:7])
    table[:, 10:11] = np.where(clear, size, table[:, 10:11])
    return table


air_drag = compiled_dynamics("air_drag")


def body_z(q: Sequence[Number]) -> list[Any]:
    """R(q) e3."""
    w, x, y, z = q
    return [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)]


def observation_stage() -> Program:
    """(estimate, state measured, thrust that acted, drag, numbers) -> estimate after it: one step of the observer."""
    tape = Tape()
    before, x, (sent,), drag, numbers = (tape.array(k, size) for k, size in enumerate((ESTIMATE_SIZE, 10, 1, 3, OBSERVER_SIZE)))
    h, fresh, now = numbers[PERIOD], before[FRESH] > 0.5, body_z(x[3:7])
    full = sent > FULL * numbers[MOST]
    gap = sent.maximum(numbers[LEAST]).minimum(numbers[MOST]).square_root() - before[ROOT]
    root = before[ROOT] + (gap > 0.0).where(numbers[SPIN_UP] * gap, numbers[SPIN_DOWN] * gap)
    thrust = 0.5 * (root * root + before[ROOT] * before[ROOT])
    axis = [0.5 * (a + b) for a, b in zip(before[AXIS:ROOT], now, strict=True)]
    known = [before[DISTURBANCE + i] - drag[i] - (numbers[GRAVITY] if i == 2 else 0.0) for i in range(3)]
    ahead = [before[VELOCITY + i] + h * (before[EFFECTIVENESS] * thrust * axis[i] + known[i]) for i in range(3)]
    error = [fresh.where(0.0, x[7 + i] - ahead[i]) for i in range(3)]
    along = full.where(0.0, dot(axis, error)) * thrust / (thrust * thrust + EASY**2)
    after = [_within(before[EFFECTIVENESS] + numbers[EFFECTIVENESS_GAIN] * along, *EFFECTIVENESS_LIMITS)]
    learnt = (before[DISTURBANCE + i] + numbers[DISTURBANCE_GAIN] * error[i] for i in range(3))
    after += [_within(value, -LARGEST_DISTURBANCE, LARGEST_DISTURBANCE) for value in learnt]
    after += [fresh.where(x[7 + i], ahead[i] + numbers[SPEED_GAIN] * error[i]) for i in range(3)]
    tape.store(5, [*after, *now, fresh.where(before[ROOT], root), 0.0])
    return tape.program


def _within(value: Number, low: float, high: float) -> Number:
    return value.maximum(low).minimum(high)


def target_stage() -> Program:
    """(target, acceleration) -> target with thrust vector T z - acceleration, by the least tilt; kept where it is weak or turns over."""
    tape = Tape()
    target, acceleration = tape.array(0, 14), tape.array(1, 3)
    q, z = target[3:7], body_z(target[3:7])
    wanted = [target[10] * z[i] - acceleration[i] for i in range(3)]
    size = (dot(wanted, wanted) + 1e-6).square_root()
    axis = [part / size for part in wanted]
    along = dot(axis, z)
    clear = (along > 0.0) & (size > EASY)
    a, b, c, d = 1.0 + along, *(z[i - 2] * axis[i - 1] - z[i - 1] * axis[i - 2] for i in range(3))
    scale = 1.0 / (a * a + b * b + c * c + d * d).square_root()
    w, i, j, k = q
    turned = [
        a * w - b * i - c * j - d * k,
        a * i + b * w + c * k - d * j,
        a * j - b * k + c * w + d * i,
        a * k + b * j - c * i + d * w,
    ]
    attitude = [clear.where(part * scale, before) for part, before in zip(turned, q, strict=True)]
    thrust = clear.where(size, target[10])
    tape.store(2, attitude, start=3)
    tape.store(2, [thrust], start=10)
    return tape.program


observe_motion, turn_target = compiled(observation_stage), compiled(target_stage)


@njit(**INLINE)
def observe(s: Settings, p: Any) -> None:
    """Take the state seen into the estimates of all lanes.

    Args:
        s: settings.
        p: the control loop's memory, as numbers; `acted` is the command that acted until now, as the model understands it.
    """
    n = s.acted_periods
    p.sent[0] = p.history[n, 0] + s.acted_rest * (p.history[n + 1, 0] - p.history[n, 0])
    p.acted[0] = p.estimate[EFFECTIVENESS] * p.sent[0]
    if s.offset_free:
        air_drag(p.seen, p.acted, p.known_drag, p.drag)
        observe_motion(p.estimate, p.seen, p.sent, p.drag, p.observer, p.estimate)


@njit(**INLINE)
def push_of(p: Any, state: Any, command: Any, push: Any) -> None:
    """The acceleration that acts besides gravity and thrust in a state with an input, (3,): d - drag."""
    air_drag(state, command, p.known_drag, p.drag)
    for i in range(3):
        push[i] = p.estimate[DISTURBANCE + i] - p.drag[i]


@njit(**INLINE)
def disturbance_of(p: Any, push: Any) -> None:
    """The acceleration that acts besides a model with drag, (3,): d."""
    for i in range(3):
        push[i] = p.estimate[DISTURBANCE + i]


@njit(**INLINE)
def push(state: Any, acceleration: Any, duration: Any, speed: int) -> None:
    """Add what a constant acceleration does in a duration to a state or a deviation, whose velocity begins at an index."""
    for i in range(3):
        gained = duration * acceleration[i]
        state[i] += 0.5 * duration * gained
        state[speed + i] += gained


@njit(**INLINE)
def plan_bounds(s: Settings, p: Any, low: Any, high: Any) -> None:
    """Bounds of the thrust that is planned: what may be commanded, times k, and the controller's limit."""
    low[0] = s.least_thrust * p.estimate[EFFECTIVENESS]
    room = s.largest_thrust * p.estimate[EFFECTIVENESS]
    high[0] = select(room > s.thrust_limit, number(room, s.thrust_limit), room)


@njit(**INLINE)
def thrust_command(s: Settings, p: Any, planned: Any) -> Any:
    """The command that gives a planned thrust, T / k within its bounds."""
    command = planned / p.estimate[EFFECTIVENESS]
    command = select(command < s.least_thrust, number(command, s.least_thrust), command)
    return select(command > s.largest_thrust, number(command, s.largest_thrust), command)


@njit(**INLINE)
def begin_observer(p: Any, numbers: Any, drag: Any, k: int) -> None:
    """Prepare the estimates of a lane, raw memory, for a new flight: nothing is known."""
    p.estimate[:, k] = 0
    p.estimate[EFFECTIVENESS, k] = 1
    p.estimate[ROOT, k] = math.sqrt(numbers[GRAVITY])
    p.estimate[FRESH, k] = 1
    for i in range(len(numbers)):
        p.observer[i, k] = numbers[i]
    for i in range(len(drag)):
        p.known_drag[i, k] = drag[i]


def begin_with(p: Any, start: Floats, gravity: float) -> None:
    """Let the estimates of the first lane begin with known values k and d, shape (4,), for a vehicle that has been hovering with them."""
    p.estimate[EFFECTIVENESS:VELOCITY, 0] = start
    p.history[:, 0, 0] = gravity / start[EFFECTIVENESS]
    p.estimate[ROOT, 0] = math.sqrt(gravity / start[EFFECTIVENESS])


def follow_clock(p: Any, race: Race, elapsed: float) -> None:
    """Let the first lane observe over the time [s] that has passed; after a pause it begins with the velocity that it sees."""
    p.observer[:, 0] = observer_numbers(race, elapsed)
    if elapsed > LONGEST_STEP * race.controller.period:
        p.estimate[FRESH, 0] = 1

"""The geometric controller: position and velocity errors tilt the thrust, an attitude error turns the body.

    f = a_ref + g e3 + K_p (p_ref - p) + K_v (v_ref - v)       thrust per mass that is wanted (world)
    T = f . R e3,   w = w_ref + K_R tangent(q, q_des)           command

q_des is the reference's attitude, turned by the shortest way until its body z points along f. After Lee, Leok, McClamroch, "Geometric
tracking control of a quadrotor UAV on SE(3)", CDC 2010; the rate loop stands in for their torques, and the reference's acceleration
and body rates are fed forward.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from hotlap.core.parameters import Parameters
from hotlap.flight.compile import compiled
from hotlap.flight.control_loop import ControlLoop, issue, predict
from hotlap.flight.job import Job, Settings
from hotlap.flight.mpc_reference import hover_inputs, read_reference
from hotlap.flight.numbers import INLINE, aligned_zeros
from hotlap.flight.observer import body_z, observe, plan_bounds, push_of
from hotlap.flight.program import Number, Program, Tape, dot
from hotlap.flight.segment_switch import piece_flown
from hotlap.race.controllers import TUNABLE, ControllerKind
from hotlap.race.race import ControllerSettings

_NAMES = TUNABLE[ControllerKind.GEOMETRIC].names
GAINS = tuple(_NAMES.index(name) for name in ("k_pos_xy", "k_pos_z", "k_vel_xy", "k_vel_z", "k_attitude", "k_yaw"))
OPPOSITE = 1e-3  # least 1 + cos of the angle that is turned: at 180 degrees every way is the shortest


class Geometric(NamedTuple):
    """Memory of the controller; raw floats (..., lanes), or numbers (...).

    Attributes:
        reference: (1, 14) p q v, inputs.
        acceleration: (3,) [m/s^2] (world) of the reference; less the push, where that is known.
        gains: (6,) k_pos_xy, k_pos_z, k_vel_xy, k_vel_z, k_attitude, k_yaw.
        low, high: (4,) bounds of the inputs.
        gravity: (1,) [m/s^2].
        command: (4,) thrust per mass, body rates.
    """

    reference: Any
    acceleration: Any
    gains: Any
    low: Any
    high: Any
    gravity: Any
    command: Any


def gains_of(_: ControllerSettings, parameters: Parameters) -> Parameters:
    """The tuned gains as they are; a copy."""
    return np.array(parameters, dtype=np.float64, order="C")


def steering_stage() -> Program:
    """(state, reference, acceleration, gains, low, high, gravity) -> command."""
    tape = Tape()
    sizes = (10, 14, 3, len(GAINS), 4, 4, 1)
    x, reference, acceleration, gains, low, high, (gravity,) = (tape.array(k, size) for k, size in enumerate(sizes))
    position, velocity = (gains[0], gains[0], gains[1]), (gains[2], gains[2], gains[3])
    wanted = [acceleration[i] + position[i] * (reference[i] - x[i]) + velocity[i] * (reference[7 + i] - x[7 + i]) for i in range(3)]
    wanted[2] = wanted[2] + gravity
    size = dot(wanted, wanted).maximum(1e-6).square_root()
    target = _tilt(reference[3:7], [part / size for part in wanted])
    error = _product([x[3], -x[4], -x[5], -x[6]], target)
    sign = (error[0] < 0.0).where(-2.0, 2.0)  # q and -q are one attitude
    turns = [sign * error[1 + i] * gains[4 if i < 2 else 5] for i in range(3)]
    command = [dot(wanted, body_z(x[3:7])), *(reference[11 + i] + turns[i] for i in range(3))]
    tape.store(7, [command[a].maximum(low[a]).minimum(high[a]) for a in range(4)])
    return tape.program


def _product(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """a o b, Hamilton's product."""
    return [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]


def _tilt(q: Sequence[Number], axis: Sequence[Number]) -> list[Any]:
    """An attitude turned by the shortest way until its body z is an axis."""
    z = body_z(q)
    across = [z[1] * axis[2] - z[2] * axis[1], z[2] * axis[0] - z[0] * axis[2], z[0] * axis[1] - z[1] * axis[0]]
    turn = [(1.0 + dot(z, axis)).maximum(OPPOSITE), *across]
    scale = 1.0 / dot(turn, turn).square_root()
    return _product([part * scale for part in turn], q)


steer = compiled(steering_stage)


def allocate_geometric(nodes: int, lanes: int, kind: type[np.floating[Any]]) -> Geometric:  # noqa: ARG001  it has no horizon
    """Raw memory, of one kind of float."""
    sizes = ((1, 14), (3,), (len(GAINS),), (4,), (4,), (1,), (4,))
    memory = Geometric(*(aligned_zeros((*size, lanes), kind) for size in sizes))
    memory.reference[:, 3].fill(1)
    return memory


@njit(**INLINE)
def begin_geometric(job: Job, s: Settings, g: Geometric, k: int) -> None:
    """Prepare a lane for a new flight."""
    for n in range(4):
        g.low[n, k], g.high[n, k] = job.low[n], job.high[n]
    g.gravity[0, k] = s.gravity


@njit(**INLINE)
def aim_geometric(
    job: Job,
    s: Settings,
    g: Geometric,
    loop: ControlLoop,
    k: int,
    flight: int,
    before: int,
    time: float,
    elapsed: float,  # noqa: ARG001
) -> int:
    """Reference and gains of a lane's control step; as `mpc_step.aim`."""
    ahead = time + s.lead
    piece = piece_flown(job, s, loop.seen, k, before, ahead)
    read_reference(g, k, job.table, s.table_period, ahead, 0.0)
    if not s.feed_forward:
        hover_inputs(g, k, s.gravity)
    row = min(int(ahead / s.table_period + 1e-6), len(job.table) - 2)
    for i in range(3):
        g.acceleration[i, k] = (job.table[row + 1, 7 + i] - job.table[row, 7 + i]) / s.table_period
    for n in range(len(GAINS)):
        g.gains[n, k] = job.parameters[flight, job.piece_segments[piece], GAINS[n]]
    return piece


@njit(**INLINE)
def control_geometric(s: Settings, g: Geometric, p: ControlLoop) -> None:
    """One control step on all lanes: from the state seen to the command, `history[0]`."""
    if s.corrected:
        observe(s, p)
        push_of(p, p.seen, p.acted, p.push)
        for i in range(3):
            g.acceleration[i] = g.acceleration[i] - p.push[i]
        if s.offset_free:
            plan_bounds(s, p, g.low, g.high)
    predict(s, g.gravity, p)
    steer(p.seen, g.reference[0], g.acceleration, g.gains, g.low, g.high, g.gravity, g.command)
    issue(s, p, g.command)

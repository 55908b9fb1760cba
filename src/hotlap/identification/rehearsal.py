"""Rehearsal: the suggested minute flown in a simulator, with sensors that are noisy, as a log."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from hotlap.core.records import Floats
from hotlap.identification.manoeuvre import SECONDS, STRAIGHTS, one_minute
from hotlap.logs.flight_log import FlightLog, Signal
from hotlap.logs.hotlap_csv import FULL_THRUST
from hotlap.race.quadrotor import Quadrotor
from hotlap.reference.attitude import rotation_matrices
from hotlap.worlds.simulator import Simulator, Start

HEIGHT = 30.0  # m
DISTANCE, LEG = 14.0, 2.25  # m and s of a straight
POSITION_GAIN, VELOCITY_GAIN, ATTITUDE_GAIN, HEADING_GAIN = 0.8, 1.6, 4.0, 1.0  # 1/s
STEEPEST, SLOWEST = 1.0, 0.3  # most tilt [-] as acceleration over g; least thrust as a share of the weight
MOST_RATE = 4.0  # rad/s that attitude errors ask for


@dataclass(frozen=True)
class Noise:
    """Standard deviations of what sensors add, and how much of it.

    Attributes:
        rates: [rad/s].
        acceleration: [m/s^2] of an accelerometer.
        velocity: [m/s].
        attitude: [rad].
        position: [m].
    """

    rates: float = 0.03
    acceleration: float = 0.5
    velocity: float = 0.03
    attitude: float = 0.005
    position: float = 0.01


QUIET = Noise(0.0, 0.0, 0.0, 0.0, 0.0)


def rehearse(
    simulator: Simulator,
    quadrotor: Quadrotor,
    *,
    seed: int = 0,
    noise: Noise = Noise(),
    period: float = 0.01,
    delay: float = 0.0,
    seconds: float = SECONDS,
    accelerometer: bool = False,
    pushes: bool = True,
) -> FlightLog:
    """Fly it under a plain controller of position and attitude.

    Args:
        simulator: its first drone flies.
        quadrotor: as its pilot knows it: of its mass, gravity and largest thrust the commands are made.
        seed: of the noise.
        noise: of the sensors; the controller is told the noisy values, too.
        period: [s] of control and log.
        delay: [s] of dead time, in whole steps of the simulator, besides its own.
        seconds: of flight.
        accelerometer: whether the log has one, and no velocity that a fit would use in its place.
        pushes: doublets and thrust steps; False: nothing but hover.

    Returns:
        The log; thrust commands are shares of the quadrotor's largest thrust per mass.

    Raises:
        SimulatorError: the simulator is lost.
    """
    random, count = np.random.default_rng(seed), round(seconds / period)
    simulator.reset(0, Start(np.array([0.0, 0.0, HEIGHT, 1.0, *np.zeros(9)])))
    whole = round(period / simulator.step)
    late = round(delay / simulator.step)
    hover = np.array([quadrotor.gravity, 0.0, 0.0, 0.0])
    waiting = deque([hover] * late)
    measured, commands, forces = np.empty((count, 13)), np.empty((count, 4)), np.empty((count, 3))
    before = simulator.states()[0].copy()
    force = np.array([0.0, 0.0, quadrotor.gravity])
    for k in range(count):
        state = simulator.states()[0]
        measured[k] = _measure(state, noise, random)
        forces[k] = force + noise.acceleration * random.standard_normal(3)
        commands[k] = _command(k * period, measured[k], quadrotor, pushes=pushes)
        for s in range(whole):
            waiting.append(commands[k])
            if s == whole - 1:
                before = simulator.states()[0].copy()
            simulator.advance(np.tile(waiting.popleft(), (simulator.lanes, 1)), simulator.step)
        after = simulator.states()[0]
        world = (after[7:10] - before[7:10]) / simulator.step + [0.0, 0.0, quadrotor.gravity]
        force = (rotation_matrices(after[3:7]) + rotation_matrices(before[3:7])).T / 2 @ world
    times, full = period * np.arange(count, dtype=np.float64), quadrotor.max_acceleration
    rows = {"position": measured[:, :3], "attitude": measured[:, 3:7], "velocity": measured[:, 7:10], "rates": measured[:, 10:]}
    rows |= {"rate_command": commands[:, 1:], "thrust_command": commands[:, :1] / full}
    if accelerometer:
        rows["acceleration"] = forces
    return FlightLog("rehearsal", "a rehearsed flight", {name: Signal(times, values) for name, values in rows.items()}, {FULL_THRUST: full})


def _measure(state: Floats, noise: Noise, random: np.random.Generator) -> Floats:
    """A state as sensors see it."""
    found = state.copy()
    found[:3] += noise.position * random.standard_normal(3)
    w, x, y, z = state[3:7]
    a, b, c = noise.attitude / 2 * random.standard_normal(3)
    turned = np.array([w - x * a - y * b - z * c, x + w * a + y * c - z * b, y + w * b + z * a - x * c, z + w * c + x * b - y * a])
    found[3:7] = turned / np.linalg.norm(turned)
    found[7:10] += noise.velocity * random.standard_normal(3)
    found[10:] += noise.rates * random.standard_normal(3)
    return found


def _target(time: float) -> Floats:
    """Where the controller goes: home, and from the straights on there and back along each axis."""
    leg = math.floor((time - STRAIGHTS) / LEG)
    places = [(1, 0), (0, 0), (-1, 0), (0, 0), (0, 1), (0, 0), (0, -1), (0, 0)]
    x, y = places[leg] if 0 <= leg < len(places) else (0, 0)
    return np.array([DISTANCE * x, DISTANCE * y, HEIGHT])


def _command(time: float, state: Floats, quadrotor: Quadrotor, *, pushes: bool) -> Floats:
    """Thrust per mass and body rates: a cascade of proportional controllers, and what is pushed."""
    gravity = quadrotor.gravity
    wanted = VELOCITY_GAIN * (POSITION_GAIN * (_target(time) - state[:3]) - state[7:10])
    wanted[:2] *= min(1.0, STEEPEST * gravity / max(float(np.hypot(*wanted[:2])), 1e-9))
    push = wanted + np.array([0.0, 0.0, gravity])
    push[2] = max(push[2], SLOWEST * gravity)
    rotation = rotation_matrices(state[3:7])
    thrust = max(float(push @ rotation[:, 2]), SLOWEST * gravity)
    across = np.cross(rotation[:, 2], push / np.linalg.norm(push))
    rates = ATTITUDE_GAIN * (rotation.T @ across)
    rates = np.clip(rates, -MOST_RATE, MOST_RATE)
    rates[2] = -HEADING_GAIN * math.atan2(rotation[1, 0], rotation[0, 0])
    command = np.array([thrust, *rates])
    for one in one_minute() if pushes else ():
        if one.begin <= time < one.end:
            command[one.axis] = gravity * (1 + one.size) if one.axis == 0 else one.size
    command[0] = min(command[0], 0.95 * quadrotor.max_acceleration)
    return command

"""Evidence: a flight log laid out for a fit: inputs that are held, outputs by channel, and which samples count."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.core.records import Floats
from hotlap.identification.ground import ground
from hotlap.identification.held import Held
from hotlap.identification.usable import SHORTEST, usable
from hotlap.logs.flight_log import GAP, FlightLog, Signal
from hotlap.race.race import PLANT_STEP
from hotlap.reference.attitude import continuous, rotation_matrices

Mask = NDArray[np.bool_]

FINEST = 200.0  # samples a second that are kept; more are averaged
COMMANDS = ("rate_command", "thrust_command")
MADE_OF = {  # signals without which an output is not known, or not predicted
    "rates": ("rates", *COMMANDS),
    "force": ("acceleration", *COMMANDS, "battery", "velocity", "attitude"),
    "velocity": ("velocity", *COMMANDS, "battery", "attitude"),
}
SLOW = 2.0  # s without a sample of a battery, which changes slowly, that are a gap
LEAST = 4.0  # s that count: as many as one of which every second is held out
SETTLING = 0.5  # s after a gap, and after the start, that do not count


@dataclass(frozen=True)
class Evidence:
    """One log, ready for a fit.

    Attributes:
        name: of the log.
        grid: shape (N + 1,) [s] edges of the steps of the plant.
        rate_command: [rad/s].
        thrust_command: with the battery's voltage beside it, [-] and [V]; None where the log has none.
        rates: what the gyroscope measured.
        force: specific force [m/s^2] (body); None where the log has none, or no thrust.
        velocity: [m/s] (world), where the force is not measured.
        rotations: shape (N + 1, 3, 3) from body to world at the edges; None where the log has no attitude.
        air: shape (N + 1, 3) [m/s] velocity (body); None where the log has none.
        counts: for rates, force and velocity, which samples count.
        ground: shape (G, 2) [s] stretches on the ground between the first take-off and the last landing.
        notes: what was left out, a line each.
    """

    name: str
    grid: Floats
    rate_command: Held
    thrust_command: Held | None
    rates: Signal
    force: Signal | None
    velocity: Signal | None
    rotations: Floats | None
    air: Floats | None
    counts: dict[str, Mask]
    ground: Floats
    notes: tuple[str, ...] = ()

    @property
    def seconds(self) -> float:
        """Of flight."""
        return float(self.grid[-1] - self.grid[0] - np.diff(self.ground, axis=1).sum())

    def flown(self, held: Held) -> Floats:
        """What a command was in flight, shape (samples, D)."""
        inside = (held.times >= self.grid[0]) & (held.times <= self.grid[-1])
        for begin, end in self.ground:
            inside &= (held.times < begin) | (held.times > end)
        return held.values[inside]

    @property
    def has_battery(self) -> bool:
        """Whether the battery's voltage is known."""
        return self.thrust_command is not None and bool(np.isfinite(self.thrust_command.values[:, 1]).all())

    @property
    def output(self) -> Signal | None:
        """What tells of forces."""
        return self.force or self.velocity


def lay_out(log: FlightLog) -> Evidence:
    """A log, checked and laid out.

    Raises:
        InputError: it lacks what no identification can do without, or cannot be right.
    """
    signals, left_out = usable(log)
    needed = [signals[name] for name in ("rates", "rate_command", "thrust_command") if name in signals]
    start, end = max(float(one.times[0]) for one in needed), min(float(one.times[-1]) for one in needed)
    standing = ground(signals, start, end)
    start, end, within = _airborne(start, end, standing)
    if end - start - np.diff(within, axis=1).sum() < SHORTEST:
        apart = f", and {np.diff(standing, axis=1).sum():.1f} s on the ground" if len(standing) else ""
        raise InputError(log.name, "", f"{max(end - start, 0.0):.1f} s with commands and rates{apart}; at least {SHORTEST:g} s are needed")
    grid = start + PLANT_STEP * np.arange(round((end - start) / PLANT_STEP) + 1, dtype=np.float64)
    rotations, air = _motion(signals, grid)
    rates, command = _within(signals["rates"], grid), _held(signals["rate_command"])
    force = velocity = None
    if "thrust_command" in signals:
        if "acceleration" in signals:
            force = _within(signals["acceleration"], grid)
        elif rotations is not None and "velocity" in signals:
            velocity = _within(signals["velocity"], grid)
    always = np.concatenate([[[start, start]], within])
    counts, few = _counts(log.name, signals, {"rates": rates, "force": force, "velocity": velocity}, always, (start, end))
    force, velocity = force if "force" in counts else None, velocity if "velocity" in counts else None
    notes = (*left_out, *_on_the_ground(log.name, standing), *few)
    return Evidence(log.name, grid, command, _thrust(signals), rates, force, velocity, rotations, air, counts, within, notes)


def _counts(
    label: str, signals: Mapping[str, Signal], outputs: Mapping[str, Signal | None], always: Floats, span: tuple[float, float]
) -> tuple[dict[str, Mask], list[str]]:
    """Which samples of each output count, and notes of outputs of which too few do: these have none.

    Args:
        label: of the log.
        signals: of it.
        outputs: by name of `MADE_OF`.
        always: shape (G, 2) [s] gaps of all of them.
        span: [s] of the flight.

    Raises:
        InputError: too few samples of the rates count.
    """
    counts, notes = dict[str, Mask](), list[str]()
    for name, one in outputs.items():
        if one is None:
            continue
        made_of = [signals[made] for made in MADE_OF[name] if made in signals]
        missing = [_gaps(part, SLOW if part is signals.get("battery") else GAP, *span) for part in made_of]
        counted = _counting(one, np.concatenate([always, *missing]))
        seconds = float(counted.sum()) * one.step if counted.any() else 0.0
        if seconds >= LEAST:
            counts[name] = counted
        elif name == "rates":
            raise InputError(label, "", f"{seconds:.1f} s with commands and rates, without gaps; at least {LEAST:g} s are needed")
        else:
            notes.append(f"{label}: {name}: {seconds:.1f} s without gaps are too few: it was left out")
    return counts, notes


def _airborne(start: float, end: float, standing: Floats) -> tuple[float, float, Floats]:
    """Take-off, landing, and the stretches on the ground in between."""
    if len(standing) and standing[0, 0] <= start:
        start, standing = float(standing[0, 1]), standing[1:]
    if len(standing) and standing[-1, 1] >= end:
        end, standing = float(standing[-1, 0]), standing[:-1]
    return start, end, standing


def _on_the_ground(name: str, standing: Floats) -> Iterator[str]:
    """What is left out, in words."""
    if len(standing):
        when = ", ".join(f"{begin:.1f} to {end:.1f}" for begin, end in standing)
        yield f"{name}: {np.diff(standing, axis=1).sum():.1f} s on the ground were left out ({when} s)"


def _held(signal: Signal) -> Held:
    return Held(signal.times, signal.values)


def _thrust(signals: Any) -> Held | None:
    """Thrust with voltage."""
    if "thrust_command" not in signals:
        return None
    thrust = signals["thrust_command"]
    voltage = np.full(len(thrust.times), np.nan)
    if "battery" in signals:
        battery = signals["battery"]
        voltage = np.interp(thrust.times, battery.times, battery.values[:, 0])
    return Held(thrust.times, np.column_stack([thrust.values[:, 0], voltage]))


def _within(signal: Signal, grid: Floats) -> Signal:
    """The samples within the grid, averaged where there are more than needed."""
    inside = (signal.times >= grid[0]) & (signal.times <= grid[-1])
    times, values = signal.times[inside], signal.values[inside]
    every = max(int(signal.rate / FINEST + 1e-6), 1)
    if every > 1:
        whole = len(times) // every * every
        times = times[:whole].reshape(-1, every).mean(axis=1)
        values = values[:whole].reshape(-1, every, values.shape[1]).mean(axis=1)
    return Signal(times, values)


def _motion(signals: Any, grid: Floats) -> tuple[Floats | None, Floats | None]:
    """Attitudes as matrices, and velocities in the body, at the edges of the grid."""
    if "attitude" not in signals:
        return None, None
    attitude = signals["attitude"]
    q = Signal(attitude.times, continuous(attitude.values)).at(np.clip(grid, attitude.times[0], attitude.times[-1]))
    rotations = rotation_matrices(q / np.linalg.norm(q, axis=1, keepdims=True))
    if "velocity" not in signals:
        return rotations, None
    velocity = signals["velocity"]
    world = velocity.at(np.clip(grid, velocity.times[0], velocity.times[-1]))
    return rotations, np.einsum("kji,kj->ki", rotations, world)


def _gaps(signal: Signal, least: float, start: float, end: float) -> Floats:
    """Begin and end of each gap between two times, shape (G, 2) [s], also where a signal begins later or ends earlier."""
    outside = [(start, signal.times[0]), (signal.times[-1], end)]
    return np.array([*signal.gaps(least).tolist(), *((a, b) for a, b in outside if b - a > least)], dtype=np.float64).reshape(-1, 2)


def _counting(signal: Signal, gaps: Floats) -> Mask:
    """Samples that are neither in a gap nor soon after one."""
    counts = np.ones(len(signal.times), dtype=bool)
    for begin, end in gaps:
        counts &= ~((signal.times >= begin) & (signal.times < end + SETTLING))
    return counts


def stretches(counts: Mask) -> NDArray[np.int64]:
    """The number of the stretch without a gap that each sample lies in, shape (N,), from 0 on; a gap belongs to the one before."""
    resumed = np.concatenate([[False], counts[1:] & ~counts[:-1]])
    return np.maximum(np.cumsum(resumed) - int(not counts[0]), 0)

"""Flights with time on the ground around them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hotlap.logs.flight_log import FlightLog, Signal

AT_REST = {"attitude": [1.0, 0, 0, 0], "acceleration": [0, 0, 9.81], "position": [0.0, 0, 30.0]}


def standing(log: FlightLog, before: float = 0.0, after: float = 0.0, idle: float = 0.0, noise: float = 0.02) -> FlightLog:
    """A log whose drone stands still before its flight and after it; its clock begins at 0.

    Args:
        log: of the flight.
        before: [s] on the ground.
        after: likewise.
        idle: throttle there.
        noise: of the sensors.
    """
    random, signals = np.random.default_rng(5), {}
    for name, signal in log.signals.items():
        step = float(np.median(np.diff(signal.times)))
        rest = np.full(signal.values.shape[1], 0.0) + AT_REST.get(name, 0.0) + (idle if name == "thrust_command" else 0.0)
        if name == "battery":
            rest = signal.values[0]
        ends = [step * np.arange(round(before / step)), before + signal.times[-1] + step * np.arange(1, round(after / step) + 1)]
        pads = [np.tile(rest, (len(one), 1)) for one in ends]
        if name in {"rates", "acceleration", "velocity"}:
            pads = [pad + noise * random.standard_normal(pad.shape) for pad in pads]
        times = np.concatenate([ends[0], before + signal.times, ends[1]])
        signals[name] = Signal(times, np.vstack([pads[0], signal.values, pads[1]]))
    return replace(log, signals=signals)

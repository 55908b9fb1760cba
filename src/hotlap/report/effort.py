"""Effort: how hard a flight drives its rotors and how much it shakes, so that a good result cannot hide a controller about to fail."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.race.race import ControllerSettings
from hotlap.reference.scenario import Scenario
from hotlap.report.scene import Trace

Floats = NDArray[np.float64]

QUICK = 3.0  # Hz above which a command serves no manoeuvre
AT_LIMIT = 0.995  # share of a limit that counts as all of it


@dataclass(frozen=True)
class Effort:
    """What a series of commands asks of a drone.

    Attributes:
        thrust_activity: [m/s^3] rms change of the thrust per mass in a second.
        rate_activity: [rad/s^2] rms change of the body rates in a second.
        saturated: share of the time at a limit, 0 to 1.
        frequency: [Hz] strongest part of the rates above `QUICK`; 0 where there is none.
        share: of the power of the rates that lies above `QUICK`, 0 to 1.
    """

    thrust_activity: float
    rate_activity: float
    saturated: float
    frequency: float
    share: float


def effort_of(trace: Trace, scenario: Scenario) -> tuple[Effort, Effort]:
    """Effort of a flight's commands, and of the inputs of the reference over the same time."""
    reference, settings = scenario.reference, scenario.race.controller
    flown = reference.times <= trace.times.max(initial=0.0)
    inputs = np.column_stack([reference.thrust, reference.rates])[flown]
    return measure(trace.commands, settings.period, settings), measure(inputs, reference.period, settings)


def measure(inputs: Floats, period: float, settings: ControllerSettings) -> Effort:
    """Effort of a series of inputs.

    Args:
        inputs: shape (n, 4): thrust per mass [m/s^2] and rates [rad/s]; rows that are no numbers are left out.
        period: [s] between rows.
        settings: the controller's, for its limits.
    """
    inputs = inputs[np.isfinite(inputs).all(axis=1)]
    if len(inputs) < 2:
        return Effort(0.0, 0.0, 0.0, 0.0, 0.0)
    change = np.diff(inputs, axis=0) / period
    frequency, share = _oscillation(inputs[:, 1:], period)
    return Effort(
        thrust_activity=float(np.sqrt(np.mean(change[:, 0] ** 2))),
        rate_activity=float(np.sqrt(np.mean((change[:, 1:] ** 2).sum(axis=1)))),
        saturated=float(_at_limit(inputs, settings).mean()),
        frequency=frequency,
        share=share,
    )


def _at_limit(inputs: Floats, settings: ControllerSettings) -> NDArray[np.bool_]:
    """Which rows ask for as much as may be asked for, shape (n,)."""
    low, high = settings.thrust
    slack = (1 - AT_LIMIT) * (high - low)
    thrust = (inputs[:, 0] <= low + slack) | (inputs[:, 0] >= high - slack)
    return thrust | (np.abs(inputs[:, 1:]) >= AT_LIMIT * np.array(settings.rates)).any(axis=1)


def _oscillation(rates: Floats, period: float) -> tuple[float, float]:
    """Strongest frequency [Hz] above `QUICK`, and the share of the power there; of the sum of the three spectra.

    Args:
        rates: shape (n, 3) [rad/s].
        period: [s]
    """
    window = np.hanning(len(rates))[:, None]
    power = (np.abs(np.fft.rfft((rates - rates.mean(axis=0)) * window, axis=0)) ** 2).sum(axis=1)
    frequencies = np.fft.rfftfreq(len(rates), period)
    quick, whole = frequencies > QUICK, float(power[1:].sum())
    if whole <= 1e-12 or not quick.any():
        return 0.0, 0.0
    return float(frequencies[quick][power[quick].argmax()]), float(power[quick].sum()) / whole

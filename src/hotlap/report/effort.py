"""Effort: how fast the commands change, how long they are at a limit and how they oscillate; a high success rate can hide all three."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.race.race import ControllerSettings
from hotlap.reference.scenario import Scenario
from hotlap.report.scene import Trace

Floats = NDArray[np.float64]

QUICK = 3.0  # Hz: no manoeuvre of a race needs rate commands of a higher frequency
AT_LIMIT = 0.995  # share of a limit that counts as all of it


@dataclass(frozen=True)
class Effort:
    """How demanding a series of commands is.

    Attributes:
        thrust_activity: [m/s^3] root mean square of the rate of change of the thrust per mass.
        rate_activity: [rad/s^2] root mean square of the rate of change of the commanded body rates.
        saturated: share of the time at a limit, 0 to 1.
        frequency: [Hz] of the largest spectral line of the rates above `QUICK`; 0 where there is none.
        share: of the power of the rates at frequencies above `QUICK`, 0 to 1.
    """

    thrust_activity: float
    rate_activity: float
    saturated: float
    frequency: float
    share: float


def effort_of(trace: Trace, scenario: Scenario) -> tuple[Effort, Effort]:
    """The effort of a flight's commands, and that of the reference's inputs over the same time."""
    reference, settings = scenario.reference, scenario.race.controller
    flown = reference.times <= trace.times.max(initial=0.0)
    inputs = np.column_stack([reference.thrust, reference.rates])[flown]
    return measure(trace.commands, settings.period, settings), measure(inputs, reference.period, settings)


def measure(inputs: Floats, period: float, settings: ControllerSettings) -> Effort:
    """The effort of a series of inputs.

    Args:
        inputs: shape (n, 4): thrust per mass [m/s^2] and rates [rad/s]; rows with NaN are left out.
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
    """Which rows have an input at one of its limits, shape (n,)."""
    low, high = settings.thrust
    slack = (1 - AT_LIMIT) * (high - low)
    thrust = (inputs[:, 0] <= low + slack) | (inputs[:, 0] >= high - slack)
    return thrust | (np.abs(inputs[:, 1:]) >= AT_LIMIT * np.array(settings.rates)).any(axis=1)


def _oscillation(rates: Floats, period: float) -> tuple[float, float]:
    """Frequency [Hz] of the largest line above `QUICK` in the sum of the three power spectra, and the share of the power above `QUICK`.

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

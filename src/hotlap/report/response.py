"""Response: how the rate commands of a flight are spread over frequencies, and how the vehicle answers a step of them.

The step response is estimated from the flight itself. The rate is a sum of past commands, rate[t] = sum_k h[k] command[t - k], and h has a
Gaussian prior that makes it smooth and lets it decay, Cov(h[i], h[j]) = c w[i] w[j] b^max(i, j) (the "tuned, correlated" kernel of Chen,
Ohlsson and Ljung, Automatica 48, 2012; w rises from 0: motors answer nothing at once); c, b and the noise have the largest marginal
likelihood. What the flight does not excite has a wide deviation; what no sum of past commands explains, as rotors at their limits, a small
share `explained`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.report.scene import Trace

Floats = NDArray[np.float64]

WINDOW = 2.56  # s of a piece of the spectrum: a line every 0.4 Hz
LAG = 0.4  # s of the step response
FEWEST = 3  # times the lag: what a flight must last for a step response
DECAYS = (0.6, 0.7, 0.8, 0.87, 0.92, 0.95)  # b, per 10 ms
RATIOS = 10.0 ** np.arange(-4.0, 7.0)  # c over the variance of the noise
ONSET = 0.02  # s within which an answer may begin
STEP = 0.01  # s that `DECAYS` are meant for
MOST_ALIKE = 0.999  # of what is left from row to row
STILL = 1e-6  # rad/s: an axis that is commanded less has no response


@dataclass(frozen=True)
class Response:
    """Spectra and step responses of the three body rates of one flight.

    Attributes:
        frequencies: shape (F,) [Hz].
        commanded: shape (F, 3) power density of the rate commands [(rad/s)^2/Hz].
        measured: shape (F, 3) the same of the body rates.
        lags: shape (L,) [s] after the step.
        steps: shape (L, 3) body rate after a unit step of its command; NaN where it cannot be told.
        deviations: shape (L, 3) standard deviation of `steps`; NaN likewise.
        explained: shape (3,) share of the power of each body rate that its past commands explain; NaN likewise.
    """

    frequencies: Floats
    commanded: Floats
    measured: Floats
    lags: Floats
    steps: Floats
    deviations: Floats
    explained: Floats


def respond(trace: Trace) -> Response | None:
    """The response of a flight; None where it is too short."""
    rows = np.isfinite(trace.commands).all(axis=1) & np.isfinite(trace.rates).all(axis=1)
    commands, rates, times = trace.commands[rows, 1:], trace.rates[rows], trace.times[rows]
    if len(times) < 16:
        return None
    period = float(np.median(np.diff(times)))
    frequencies, commanded = density(commands, period)
    lags = np.linspace(0.0, round(LAG / period) * period, round(LAG / period) + 1)
    answers = [step_response(commands[:, axis], rates[:, axis], period) for axis in range(3)]
    return Response(
        frequencies,
        commanded,
        density(rates, period)[1],
        lags,
        np.column_stack([step for step, _, _ in answers]),
        np.column_stack([deviation for _, deviation, _ in answers]),
        np.array([explained for _, _, explained in answers]),
    )


def density(values: Floats, period: float) -> tuple[Floats, Floats]:
    """Power density of some series by Welch's method: the mean over pieces that overlap by half.

    Each piece is taken without its mean, under Hann's window.

    Args:
        values: shape (n, k).
        period: [s] between rows.

    Returns:
        Frequencies, shape (F,) [Hz], and densities, shape (F, k) [unit^2/Hz]; their sum over the frequencies is the variance.
    """
    length = min(len(values), round(WINDOW / period))
    window = np.hanning(length)[:, None]
    starts = range(0, len(values) - length + 1, max(1, length // 2))
    pieces = np.stack([values[start : start + length] for start in starts])
    pieces = (pieces - pieces.mean(axis=1, keepdims=True)) * window
    power = (np.abs(np.fft.rfft(pieces, axis=1)) ** 2).mean(axis=0) * period / (window**2).sum()
    power[1 : (length + 1) // 2] *= 2  # both signs of the frequency
    return np.arange(length // 2 + 1, dtype=np.float64) / (length * period), power


def step_response(command: Floats, rate: Floats, period: float) -> tuple[Floats, Floats, float]:
    """What a rate does after a unit step of its command, estimated from a flight.

    Args:
        command: shape (n,) [rad/s].
        rate: shape (n,) [rad/s].
        period: [s] between rows.

    Returns:
        Response, shape (L,), its standard deviation, and the share of the rate's power that is explained; all NaN where the flight is too
        short or the axis is not commanded.
    """
    size = round(LAG / period) + 1
    if len(command) < FEWEST * size or np.ptp(command) < STILL or np.ptp(rate) < STILL:
        return np.full(size, np.nan), np.full(size, np.nan), np.nan
    past = np.lib.stride_tricks.sliding_window_view(command, size)[:, ::-1]  # rows t, columns command[t - k]
    answer, power = rate[size - 1 :], float(rate[size - 1 :] @ rate[size - 1 :])
    onset = 1 - np.exp(-np.arange(size) * period / ONSET)
    found = min((_fit(past, answer, decay ** (period / STEP), onset) for decay in DECAYS), key=lambda one: one[0])
    _, impulse, covariance = found
    summed = np.tri(size)  # a step is the sum of impulses
    deviation = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", summed, covariance, summed), 0))
    rest = answer - past @ impulse
    alike = min(max(float(rest[1:] @ rest[:-1]) / max(float(rest @ rest), 1e-300), 0.0), MOST_ALIKE)
    deviation *= np.sqrt((1 + alike) / (1 - alike))  # what is left is no white noise: so many rows tell as much as one
    return np.cumsum(impulse), deviation, 1 - float(rest @ rest) / power


def _fit(past: Floats, answer: Floats, decay: float, onset: Floats) -> tuple[float, Floats, Floats]:
    """The impulse response under the kernel with a decay, at the ratio of prior to noise that is likeliest.

    Args:
        past: shape (n, L).
        answer: shape (n,).
        decay: b of the kernel, per row.
        onset: w of the kernel, shape (L,).

    Returns:
        Minus twice the logarithm of the marginal likelihood but for a constant, the impulse response, shape (L,), and its covariance.
    """
    count, size = past.shape
    index = np.arange(size)
    root = onset[:, None] * np.linalg.cholesky(decay ** np.maximum.outer(index, index) + 1e-12 * np.eye(size))
    left, values, right = np.linalg.svd(past @ root, full_matrices=False)
    projected, power = left.T @ answer, float(answer @ answer)
    gains = RATIOS[:, None] * values**2 / (1 + RATIOS[:, None] * values**2)
    noise = np.maximum(power - gains @ projected**2, 1e-12 * power) / count
    likelihood = count * np.log(noise) + np.log1p(RATIOS[:, None] * values**2).sum(axis=1)
    best = int(likelihood.argmin())
    basis, ratio = root @ right.T, RATIOS[best]
    impulse = basis @ (ratio * values / (1 + ratio * values**2) * projected)
    return float(likelihood[best]), impulse, noise[best] * (basis * (ratio / (1 + ratio * values**2))) @ basis.T

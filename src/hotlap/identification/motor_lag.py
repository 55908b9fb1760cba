"""Motor lag of a vehicle with a PID rate loop, from thrust alone.

Rates tell of motors and of all that is between a stick and them. A firmware filters its gyroscope and its derivative part in ways that no
base describes, and a fit of rates would take these for lag of the motors, too. What pushes the vehicle knows nothing of them. Dead time is
that of the rates, which tell it best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hotlap.identification.fit import Fit, Mask, fit
from hotlap.identification.model import Model
from hotlap.identification.unknowns import moved

LAG = ("lag", "lag_ratio")
OF_THRUST = ("full", "curvature", "battery", *LAG, "rotor_drag", "drag_", "body_drag_", "accelerometer_")  # beginnings of names
FIXED = 1e-6  # standard deviation of what is not looked for


def with_lag_of_thrust(models: Sequence[Model], found: Fit, counts: Sequence[dict[str, Mask]]) -> Fit:
    """A fit whose motor lag is that of thrust alone, and all others are fitted with it.

    Args:
        models: one of each log.
        found: fitted to rates and thrust at once.
        counts: which samples it was fitted to, by channel, of each log.

    Returns:
        `found` itself where no thrust was measured, or the rate loop is no PID and has no such filters.
    """
    if models[0].base.rate_loop is None or all(model.evidence.output is None for model in models):
        return found
    at = dict(zip((one.name for one in found.unknowns), found.theta.tolist(), strict=True))
    of_thrust = [one if one.name.startswith(OF_THRUST) else replace(one, belief=FIXED) for one in moved(found.unknowns, at)]
    without_rates = [{name: mask for name, mask in one.items() if name != "rates"} for one in counts]
    alone = fit(models, of_thrust, found.theta, without_rates, rounds=2)
    lag = {name: value for name, value in zip((one.name for one in alone.unknowns), alone.theta.tolist(), strict=True) if name in LAG}
    given = [replace(one, belief=FIXED) if one.name in LAG else one for one in moved(found.unknowns, lag)]
    theta = np.array([lag.get(one.name, value) for one, value in zip(given, found.theta.tolist(), strict=True)])
    rest = fit(models, given, theta, counts, rounds=1)
    covariance, places = rest.covariance.copy(), [k for k, one in enumerate(given) if one.name in LAG]
    covariance[np.ix_(places, places)] = alone.covariance[np.ix_(places, places)]
    return Fit(found.unknowns, rest.theta, covariance, rest.scales)

"""Thrust map: from thrust per mass to the normalised thrust that autopilots take.

    c u^2 + (1 - c) u = T / (full (V / V_0)^2)

u is the throttle, T the thrust per mass, V the voltage, and c says how thrust grows with throttle: 0 where the autopilot makes it linear,
1 where throttle is motor speed. `full`, what all of the throttle gives, is the quadrotor's at first; hovering corrects it, for there the
thrust is known: it is the weight.
"""

from __future__ import annotations

import math

from hotlap.core.errors import HotlapError

GAIN_LIMITS = (0.5, 2.0)  # of the thrust that hovering shows over that of the file: beyond them the file is of another drone
SMOOTHING = 0.5  # s, time constant of the voltage
VOLTAGE_LIMITS = (0.75, 1.2)  # of a voltage over the first: beyond them the sensor is wrong, and is not believed
LEAST_VOLTAGE = 1.0  # V: less is no battery


class ThrustMap:
    """The throttle that gives a thrust.

    Args:
        full: [m/s^2] thrust per mass at full throttle, by the quadrotor's file.
        curve: c, 0 to 1.
        with_battery: whether thrust goes with the square of the voltage; False: the autopilot makes up for it.

    Attributes:
        full: [m/s^2] as it is known now, at the first voltage that was heard.
        gain: [-] that over what the file says.
    """

    def __init__(self, full: float, curve: float = 0.0, *, with_battery: bool = True) -> None:
        self.full, self.gain = full, 1.0
        self._curve, self._with_battery = curve, with_battery
        self._voltage = self._first_voltage = math.nan
        self._time = -math.inf

    def hear(self, time: float, voltage: float) -> None:
        """Take in a voltage [V] at a time [s]; NaN, or what is no voltage of this battery, teaches nothing."""
        low, high = VOLTAGE_LIMITS
        if not voltage > LEAST_VOLTAGE or not (math.isnan(self._first_voltage) or low <= voltage / self._first_voltage <= high):
            return
        if math.isnan(self._voltage):
            self._voltage = self._first_voltage = voltage
        else:
            self._voltage += (1 - math.exp(-max(time - self._time, 0.0) / SMOOTHING)) * (voltage - self._voltage)
        self._time = time

    def throttle(self, thrust: float) -> float:
        """The throttle [-], 0 to 1, that gives a thrust per mass [m/s^2]."""
        share = min(thrust / (self.full * self._voltage_share**2), 1.0)
        if not share > 0:
            return 0.0
        c = self._curve
        return min(2 * share / (math.sqrt((1 - c) ** 2 + 4 * c * share) + (1 - c)), 1.0)  # the root, exact for a small c too

    def correct(self, gain: float) -> None:
        """Take in what hovering has shown.

        Args:
            gain: the thrust that acted over the thrust that was asked for [-].

        Raises:
            HotlapError: the file is of another drone.
        """
        total, (low, high) = self.gain * gain, GAIN_LIMITS
        if not low <= total <= high:
            told = f"hovering takes {1 / total:.2f} times the throttle that the quadrotor's file says" if total > 0 else "nothing hovers"
            raise HotlapError(f"{told}: is it the file of this drone?")
        self.full, self.gain = self.full * gain, total

    @property
    def hover_throttle(self) -> float:
        """The throttle [-] that carries the weight, under standard gravity."""
        return self.throttle(9.81)

    @property
    def _voltage_share(self) -> float:
        """Voltage over that at which `full` is known [-]."""
        if not self._with_battery or math.isnan(self._voltage):
            return 1.0
        return self._voltage / self._first_voltage

"""Battery: how thrust falls over a flight while the battery is drawn down.

    thrust = (1 - lost) commanded thrust,   lost = sag t / T + sag_per_ampere_hour q,   q' = I_hover (thrust / weight)^1.5

t / T is the share of the reference's duration that has passed, q the charge drawn. Momentum theory gives a rotor's induced power as
thrust^1.5; at a steady voltage the current goes with it.
"""

from __future__ import annotations

from pydantic import Field, model_validator

from hotlap.race.schema import Described, NotNegative, Positive

MOST_LOST = 0.9  # share of thrust that a battery may take
HOUR = 3600.0  # s


class Battery(Described):
    """What a battery that is drawn down takes from the thrust, at every command; a controller does not know of it."""

    sag: float = Field(default=0.0, ge=0, le=MOST_LOST)
    """[-] share of thrust lost at the end of the reference; it grows evenly with time."""
    sag_per_ampere_hour: NotNegative = 0.0
    """[1/Ah] share of thrust lost for each ampere-hour drawn; it needs `hover_current`."""
    hover_current: Positive | None = None
    """[A] drawn in hover; the current grows with thrust^1.5. Without it: what is drawn is not counted."""

    @model_validator(mode="after")
    def _counted(self) -> Battery:
        if self.sag_per_ampere_hour > 0 and self.hover_current is None:
            raise ValueError("hover_current: is missing; sag_per_ampere_hour needs it: [A] drawn in hover")
        return self

    def charge_sag(self, weight: float) -> float:
        """Share of thrust lost in each second for each N^1.5 of thrust, at the hover current under a weight [N]."""
        return self.sag_per_ampere_hour * (self.hover_current or 0.0) / HOUR / weight**1.5

"""Observer settings: how fast the controller learns in flight what its model of the vehicle leaves out."""

from __future__ import annotations

from pydantic import Field

from hotlap.race.schema import Described


class ObserverSettings(Described):
    """The observer of offset-free control: bandwidths of what it estimates from the measured velocity."""

    thrust: float = Field(default=10.0, ge=0, le=100)
    """[rad/s] bandwidth of the thrust effectiveness, the thrust that acts over the thrust that was commanded. 0: it is taken to be 1."""
    acceleration: float = Field(default=10.0, ge=0, le=100)
    """[rad/s] bandwidth of the disturbance, an acceleration in the world that nothing else explains. 0: it is taken to be none."""

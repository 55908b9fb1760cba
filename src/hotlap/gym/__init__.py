"""Gymnasium environment of the built-in world; it is registered as `hotlap/Race-v0` when this package is imported.

    import gymnasium
    import hotlap.gym

    env = gymnasium.make("hotlap/Race-v0", race="circle-34")

Needs the package gymnasium: pip install 'hotlap[gym]'.
"""

from __future__ import annotations

try:
    import gymnasium
except ImportError:
    raise ImportError("hotlap.gym needs the package gymnasium: pip install 'hotlap[gym]'") from None

from hotlap.gym.race_env import RaceEnv

NAME = "hotlap/Race-v0"
if NAME not in gymnasium.registry:
    gymnasium.register(id=NAME, entry_point="hotlap.gym.race_env:RaceEnv")

__all__ = ["NAME", "RaceEnv"]

"""Renamed: what tuners and their presets were called before; old names go on working."""

from __future__ import annotations

RENAMED_ALGORITHMS = {"gatewise": "gate_gp"}
RENAMED_PRESETS = {"homely": "no_exploration", "hasty": "one_generation", "steady": "no_restarts"}
WITH_RENAMED_PRESETS = ("gate_gp", "guided_walk")


def current_name(name: str) -> str:
    """The name that a tuner has today.

    Args:
        name: `ALGORITHM` or `ALGORITHM:PRESET`, of today or of before.
    """
    algorithm, separator, preset = name.partition(":")
    algorithm = RENAMED_ALGORITHMS.get(algorithm, algorithm)
    if algorithm in WITH_RENAMED_PRESETS:
        preset = RENAMED_PRESETS.get(preset, preset)
    return f"{algorithm}{separator}{preset}"

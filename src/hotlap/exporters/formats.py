"""Formats by name; imports nothing that takes time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Format:
    """A kind of file.

    Attributes:
        module: in this folder, that writes it.
        file: its name in the study's folder, where no other is asked for.
        finished: whether the study must have ended: it takes the result, not the flights.
    """

    module: str
    file: str
    finished: bool = True


FORMATS: Mapping[str, Format] = {
    "rpg_mpc": Format("rpg_mpc", "mpc.yaml"),
    "acados": Format("acados", "acados_weights.json"),
    "agilicious": Format("agilicious", "quadrotor.yaml", finished=False),
    "px4": Format("px4", "px4.params", finished=False),
    "mcap": Format("ros2_bag", "flight.mcap"),
    "json": Format("plain_json", "parameters.json"),
    "toml": Format("plain_toml", "parameters.toml"),
    "csv": Format("plain_csv", "parameters.csv"),
    "optuna": Format("optuna_study", "optuna.db", finished=False),
}

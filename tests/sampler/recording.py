"""A tuner that keeps what it is told; built as `sampler.recording.Recorder`."""

from __future__ import annotations

from hotlap.tuners.random_search import PRESETS, RandomSearch

__all__ = ["PRESETS", "Recorder"]


class Recorder(RandomSearch):
    told: list[float] = []  # noqa: RUF012  of all that there are

    def tell(self, parameters, scores):
        self.told.extend(scores.cost.tolist())
        return super().tell(parameters, scores)

"""Hypothesis without clocks and without luck: the same examples on every machine."""

from hypothesis import settings

settings.register_profile("hotlap", deadline=None, derandomize=True, max_examples=60)
settings.load_profile("hotlap")

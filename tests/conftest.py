"""Hypothesis without clocks and without luck: the same examples on every machine; linear algebra on one thread."""

from hypothesis import settings

from hotlap.system.blas_threads import one_thread

one_thread()

settings.register_profile("hotlap", deadline=None, derandomize=True, max_examples=60)
settings.load_profile("hotlap")

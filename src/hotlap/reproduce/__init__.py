"""Reproduce: the paper's experiments, flown again and set beside its figures."""

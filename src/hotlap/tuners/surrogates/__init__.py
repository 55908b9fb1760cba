"""Surrogates: Gaussian-process models of a cost, or of the miss at each gate, as functions of the parameters."""

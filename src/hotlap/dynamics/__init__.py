"""Dynamics: the equations of motion, written once as CasADi expressions; their parameters, and their linearisation."""

"""Identification: the numbers of a quadrotor from the log of a flight, each with an interval."""

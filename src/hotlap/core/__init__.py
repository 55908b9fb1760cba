"""Core: what all packages use: errors, parameters and their bounds, records of flights, seeds, success rates."""

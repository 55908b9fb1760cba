"""Reference: the flight that a controller is asked to repeat, cut into segments; with its race, a scenario."""

"""Names of the worlds that come with hotlap; imports nothing, so that help costs nothing."""

BUILT_IN = "built-in"
SIMULATORS = ("rotorpy", "crazyflow", "betaflight", "airsim", "flightmare")
"""Each is a module of `hotlap.worlds` that opens a simulator."""
SERVED = ("airsim",)
"""Those whose simulator is a server that runs already."""
OWN = "my_module.MySimulator"

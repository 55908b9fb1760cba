"""Published: the figures of AutoTune (Loquercio, Saviolo, Scaramuzza, RA-L 7(2), 2022) that are set beside ours."""

from __future__ import annotations

from collections.abc import Mapping

RACES = ("circle-20", "circle-34", "drop-20", "flip-16", "spiral-53", "qualifier-20", "final-22")
"""The columns of Table I: tracks with the planner's v_max."""

TABLE_I: Mapping[str, tuple[int, ...]] = {
    "random search": (100, 65, 40, 80, 0, 50, 10),
    "BO, Matern": (100, 80, 100, 80, 10, 75, 40),
    "BO, locally periodic": (100, 65, 50, 80, 0, 60, 40),
    "BO, rational quadratic": (100, 60, 50, 80, 0, 60, 30),
    "BO, squared exponential": (100, 60, 50, 80, 10, 60, 30),
    "BO, periodic": (100, 30, 40, 80, 0, 30, 25),
    "PSO": (100, 100, 100, 100, 10, 75, 40),
    "CMA-ES": (100, 100, 100, 100, 10, 100, 100),
    "gradient boosting": (100, 65, 50, 80, 10, 65, 40),
    "AutoTune": (100, 100, 100, 100, 100, 100, 100),
}
"""Completion [%]; 200 flights, of PSO and CMA-ES 1000."""

TABLE_II: Mapping[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "QuetzalC++": ((42.01, 17.20, 8.13), (53.52, 28.19, 9.82)),
    "Chuchichaschtli": ((37.58, 18.96, 9.11), (53.49, 18.70, 9.54)),
    "Dedale": ((30.11, 16.49, 11.33), (39.78, 20.02, 12.88)),
    "AutoTune": ((24.05, 21.68, 14.06), (38.09, 19.83, 14.01)),
}
"""Lap [s], largest and mean speed [m/s], on the qualification track and in the final of Game of Drones 2019; Dedale won."""

TABLE_III: Mapping[str, tuple[int, int]] = {"AutoTune": (100, 21), "without regressor": (100, 172), "without segmentation": (65, 300)}
"""Completion [%] on Qualifier, and flights."""

AUTOTUNE_CURVE = (
    *(55, 60, 60, 60, 60, 60, 50, 50, 60, 65, 60, 60, 65, 60, 65, 60, 65, 65, 65, 60),
    *(100, 100, 100, 100, 100),
)  # fmt: skip
"""Completion [%] on Qualifier after flights 1 to 25."""

EXPERTS_CURVE = (
    *(31.25, 31.25, 31.25, 31.25, 38.75, 45, 43.75, 45, 31.25, 50, 46.25, 22.5, 56.25, 58.75, 46.25, 58.75, 62.5, 58.75, 23.75, 42.5),
    *(60, 60, 58.75, 56.25, 53.75),
)  # fmt: skip
"""The same, mean of four human experts."""

EXPERTS_BAND = (*(27,) * 4, 6, *(27,) * 4, 17, 14, 28, *(6,) * 2, 25, *(6,) * 3, 28, 25, *(6,) * 5)
"""About one standard deviation [points] of the experts, read off the figure; where it says 6 there, 3 to 8."""

REAL_WORLD: Mapping[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "human": ((0.70, 0.73, 0.75), (1.396, 1.412, 1.463)),
    "AutoTune": ((0.66, 0.69, 0.72), (1.23, 1.27, 1.28)),
}
"""Mean and largest tracking error [m] of three flights of a physical drone on the double Split-S, tuned by a human and in simulation."""

REAL_WORLD_MEDIANS = {"human": 0.73, "AutoTune": 0.69}
"""Medians [m] of the box plots of the same flights."""

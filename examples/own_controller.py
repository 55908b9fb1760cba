"""A controller of your own in a simulation of your own, tuned on a hotlap reference: the tuner proposes gains and is given their costs.

To fly inside the flight core, thousands of times faster than real time, see docs/controller.md: a model as a CasADi function.
"""

import numpy as np

from hotlap import tuners
from hotlap.core.parameters import ParameterSpace
from hotlap.core.records import Scores
from hotlap.planning.preparation import prepare

STEP, LAG, LATE = 0.01, 0.08, 4  # s; s of the attitude loop; steps of dead time
reference = prepare("circle-34").reference
rows = reference.planned_rows - 1
acceleration = np.diff(reference.velocity, axis=0) / reference.period


def fly(gains: np.ndarray) -> float:
    """Mean distance from the reference [m] of a point mass that follows its commands with a dead time and a lag."""
    k_position, k_velocity, feed_forward = gains
    position, velocity, pushed = reference.position[0].copy(), np.zeros(3), np.zeros(3)
    waiting, error = [np.zeros(3)] * LATE, 0.0
    for row in range(rows):
        away, slip = reference.position[row] - position, reference.velocity[row] - velocity
        waiting.append(k_position * away + k_velocity * slip + feed_forward * acceleration[row])
        pushed = pushed + STEP / LAG * (waiting.pop(0) - pushed)
        velocity = velocity + STEP * pushed
        position = position + STEP * velocity
        error += float(np.linalg.norm(away)) / rows
        if error > 100:
            return 100.0
    return error


low, high, default = np.array([[0.5, 0.5, 0.1], [40.0, 20.0, 3.0], [4.0, 3.0, 1.0]])
space = ParameterSpace(("k_position", "k_velocity", "feed_forward"), low, high, default, log_step=np.ones(3))
tuner = tuners.build("gate_gp")
tuner.start(space.first_guess(1), space, np.random.default_rng(0))
tried = []
while len(tried) < 80:
    asked = tuner.ask(8)
    costs = [fly(gains[0]) for gains in asked]
    tuner.tell(asked, Scores.of_costs(np.array(costs)))
    tried += zip(costs, (gains[0] for gains in asked), strict=True)
cost, gains = min(tried, key=lambda pair: pair[0])
found = ", ".join(f"{name} {gain:.2f}" for name, gain in zip(space.names, gains, strict=True))
print(f"mean error: {tried[0][0]:.2f} m with the default gains, {cost:.2f} m with {found}")

"""A simulator of your own, flown and tuned in by hotlap: hotlap tune circle-34 --on own_simulator.MySimulator (docs/add_a_simulator.md)."""

import numpy as np

import hotlap
from hotlap.reference.scenario import Scenario
from hotlap.worlds.simulator import Start


class MySimulator:
    """A drone whose thrust acts at once, and whose body rates follow their commands with a lag [s]; no drag, no motors."""

    lanes, step, scales_thrust = 1, 0.0025, False

    def __init__(self, scenario: Scenario, instance: int, argument: str = "") -> None:
        self.lag, self.gravity = float(argument or 0.04), scenario.race.vehicle.gravity
        self.state = np.zeros(13)  # position, attitude (w, x, y, z), velocity (world), rates (body): SI units, z up

    def reset(self, lane: int, start: Start) -> None:
        self.state = start.state.copy()

    def advance(self, commands: np.ndarray, duration: float) -> None:
        thrust, rates = commands[0, 0], commands[0, 1:]
        for _ in range(round(duration / self.step)):
            position, (w, x, y, z), velocity, turn = np.split(self.state, (3, 7, 10))
            axis = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])  # of the thrust, in the world
            velocity = velocity + self.step * (thrust * axis - [0, 0, self.gravity])
            turn = turn + self.step / self.lag * (rates - turn)
            a, b, c = self.step / 2 * turn
            attitude = np.array(
                [w - x * a - y * b - z * c, x + w * a + y * c - z * b, y + w * b + z * a - x * c, z + w * c + x * b - y * a]
            )
            self.state = np.concatenate([position + self.step * velocity, attitude / np.linalg.norm(attitude), velocity, turn])

    def states(self) -> np.ndarray:
        return self.state[None]

    def rotor_thrusts(self) -> np.ndarray:
        return np.full((1, 4), np.nan)  # it has no rotors

    def close(self) -> None: ...


if __name__ == "__main__":
    flown = hotlap.fly("circle-34", first_guess="paper", flights=4, on="own_simulator.MySimulator:0.06")
    print(flown.world, "flies:", flown.facts()["all gates in"])

"""Why tune at all? RAPTOR, a learned controller that needs no tuning, beside the MPC: python benchmarks/raptor.py [RACE..]

Both fly in RotorPy, with the same vehicle, the same starts and the same judge (`hotlap.worlds.stepped`); RAPTOR is flown by RotorPy's own
`controllers/raptor.py`, and is asked to be where the MPC is asked to be. Needs `pip install 'hotlap[rotorpy]' foundation-policy==1.0.1`,
which holds its weights (MIT). RAPTOR commands rotor speeds: the MPC's actuation noise does not reach it. It was trained without dead time,
so it flies with the race's and without any.
"""

from __future__ import annotations

import argparse
import math
from collections import deque
from pathlib import Path

import numpy as np
from abroad import Row, fly, tuned_parameters
from numpy.typing import NDArray
from rotorpy.controllers.raptor import RaptorFoundationPolicy

from hotlap.files.descriptions import load_race, save
from hotlap.planning.preparation import prepare
from hotlap.race.quadrotor import RotorLayout
from hotlap.reference.scenario import Scenario
from hotlap.worlds import rotorpy
from hotlap.worlds.simulator import Start
from hotlap.worlds.stepped import Stepped

Floats = NDArray[np.float64]

RACES = ("circle-34", "circle-20", "qualifier-20", "lsy-level0", "circle-34@5")  # the last one at up to 5 m/s
PERIOD = 4  # steps of RotorPy between two actions: the 10 ms that it was trained with
PLUS = [1, 0, 3, 2]  # its rotors (front left, front right, back right, back left) seen from a drone whose front is a rotor


class Raptor(rotorpy.RotorPy):
    """RAPTOR and its drone in RotorPy: follows the reference by itself, and heeds no command.

    Its drone is an X. One whose rotors sit on the axes is seen by it turned by 45 degrees to the left, so that its rotors turn as RAPTOR
    expects, in a world that is turned as much.

    Args:
        scenario: whose reference it follows.
        delay: [s] dead time from its actions to the rotors.
    """

    def __init__(self, scenario: Scenario, delay: float) -> None:
        vehicle = scenario.race.vehicle
        self._parameters = rotorpy.parameters_of(vehicle)
        self._policy = RaptorFoundationPolicy(self._parameters)
        self._reference, self._dead_steps, self._late = scenario.reference, round(delay / rotorpy.STEP), deque()
        self._plus, w = vehicle.layout is RotorLayout.PLUS, scenario.reference.attitude[0]
        heading = math.atan2(2 * (w[0] * w[3] + w[1] * w[2]), 1 - 2 * (w[2] ** 2 + w[3] ** 2))
        self._world, self._body = turn(-heading - math.pi / 4 * self._plus), turn(math.pi / 4 * self._plus)
        super().__init__(vehicle)
        self._multirotor.control_abstraction = "cmd_motor_speeds"

    def reset(self, lane: int, start: Start) -> None:
        """Place the drone; its controller forgets."""
        super().reset(lane, start)
        hover, (least, largest) = self._state["rotor_speeds"], (self._parameters[f"rotor_speed_{end}"] for end in ("min", "max"))
        self._policy.policy.reset()
        self._policy.action_past = 2 * (hover - least) / (largest - least) - 1
        self._steps, self._late = 0, deque([hover] * (self._dead_steps + 1))

    def advance(self, commands: Floats, duration: float) -> None:
        """Fly for a duration [s] under its own control."""
        del commands
        for _ in range(round(duration / rotorpy.STEP)):
            if self._steps % PERIOD == 0:
                self._asked = self._decide(self._steps * rotorpy.STEP)
            self._late.append(self._asked)
            self._late.popleft()
            self._state = self._multirotor.step(self._state, {"cmd_motor_speeds": self._late[0]}, rotorpy.STEP)
            self._steps += 1

    def _decide(self, time: float) -> Floats:
        """Rotor speeds, shape (4,) [rad/s], in our order."""
        table, clock = self._reference, self._reference.times
        place, velocity = (np.array([np.interp(time, clock, column) for column in part.T]) for part in (table.position, table.velocity))
        seen = {
            "x": self._world @ self._state["x"],
            "v": self._world @ self._state["v"],
            "q": turned(self._world, self._state["q"], self._body),
            "w": self._body.T @ self._state["w"],
        }
        asked = self._policy.update(time, seen, {"x": self._world @ place, "x_dot": self._world @ velocity})["cmd_motor_speeds"]
        return asked[PLUS] if self._plus else asked


def turn(angle: float) -> Floats:
    """Rotation matrix about the vertical, shape (3, 3)."""
    return np.array([[math.cos(angle), -math.sin(angle), 0.0], [math.sin(angle), math.cos(angle), 0.0], [0.0, 0.0, 1.0]])


def turned(world: Floats, attitude: Floats, body: Floats) -> Floats:
    """An attitude (x, y, z, w) between a world and a body that are both turned."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415

    return (Rotation.from_matrix(world) * Rotation.from_quat(attitude) * Rotation.from_matrix(body)).as_quat()


def race_of(asked: str, folder: Path) -> str:
    """A race, or one flown at a top speed that was asked for, written as a file so that it can be tuned."""
    name, _, speed = asked.partition("@")
    if not speed:
        return name
    race = load_race(name)
    folder.mkdir(parents=True, exist_ok=True)
    slower = race.model_copy(update={"name": asked, "planning": race.planning.model_copy(update={"v_max": float(speed)})})
    save(folder / f"{asked}.toml", slower)
    return str(folder / f"{asked}.toml")


def main() -> None:
    """Print the table, a line as soon as it is there."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("races", nargs="*", default=RACES)
    parser.add_argument("--flights", type=int, default=10)
    parser.add_argument("--out", type=Path, default=Path("build/abroad"))
    asked = parser.parse_args()
    print(f"{'race':14} {'top speed':9} {'controller':24} complete   gates   error [m], mean and largest of complete flights", flush=True)
    for name in asked.races:
        source = race_of(name, asked.out)
        scenario = prepare(load_race(source))
        first, speed = scenario.space.first_guess(len(scenario.segments)), scenario.reference.max_speed
        tuned = tuned_parameters(source, scenario, asked.out / name)
        delay = scenario.race.vehicle.delay
        worlds = {
            "MPC, tuned": (Stepped("rotorpy", rotorpy.open_simulator), tuned),
            "MPC, default": (Stepped("rotorpy", rotorpy.open_simulator), first),
            "RAPTOR": (Stepped("raptor", lambda scenario, _: Raptor(scenario, scenario.race.vehicle.delay)), first),
        }
        if delay:
            worlds["RAPTOR, no dead time"] = Stepped("raptor", lambda scenario, _: Raptor(scenario, 0.0)), first
        for controller, (world, parameters) in worlds.items():
            row = Row.of(fly(world, scenario, parameters, asked.flights))
            print(f"{name:14} {speed:5.1f} m/s {controller:24} {row}", flush=True)


if __name__ == "__main__":
    main()

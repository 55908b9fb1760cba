"""How well logs tell a drone's numbers: python benchmarks/identification.py [own rotorpy crazyflow betaflight example]

Each world flies the suggested minute with a drone that is heavier than its pilot believes, of another drag and with dead time, with noise
of the sensors; then every number is set beside the truth. `own` draws many drones around the five-inch, each number up to a third off, and
counts intervals that hold the truth. Elsewhere the identified drone is asked for the same steps as the
simulator's. The noise: 0.05 rad/s, 0.05 m/s, 0.01 rad in the built-in world, 0.03, 0.03 and 0.005 elsewhere.
counts intervals that hold the truth. `example` flies what docs/identify.md shows and runs `hotlap identify` on it. The noise:
0.05 rad/s, 0.05 m/s, 0.01 rad in the built-in world, 0.03, 0.03 and 0.005 elsewhere.
"""

from __future__ import annotations

import argparse
import os
import time
from importlib import import_module
from pathlib import Path
from typing import cast

import numpy as np

os.environ.setdefault("SCIPY_ARRAY_API", "1")  # crazyflow asks for it, before SciPy is loaded

from hotlap.cli import main as main_of_hotlap
from hotlap.core.records import Floats
from hotlap.files.descriptions import load_quadrotor
from hotlap.identification.draws import drawn
from hotlap.identification.identify import Identification, identify
from hotlap.identification.quadrotor_file import quadrotor_of
from hotlap.identification.rehearsal import SECONDS, Noise, rehearse
from hotlap.logs.hotlap_csv import write_hotlap_csv
from hotlap.race.quadrotor import Quadrotor
from hotlap.worlds.plant_simulator import PlantSimulator
from hotlap.worlds.simulator import Simulator, Start

WORLDS = ("own", "rotorpy", "crazyflow", "betaflight", "example")
HEAVIER, DRAG = 1.15, (0.4, 0.35, 0.2)
DELAY = {"rotorpy": 0.02, "crazyflow": 0.02, "betaflight": 0.04}  # s
NOISE = Noise(rates=0.05, acceleration=1.0, velocity=0.05, attitude=0.01, position=0.02)
BASE = "five-inch"
STEPS = {"thrust": 0.8, "roll": 2.0, "pitch": 2.0, "yaw": 1.0}  # share of the weight, rad/s
SETTLING, STEP_SECONDS, SHARE = 0.6, 0.4, 0.63
EXAMPLE = {"mass": 0.75, "motor_time": (0.03, 0.045), "rate_gain": (30.0, 28.0, 6.0), "drag": DRAG}
EXAMPLE_DELAY = 0.0425  # s


def truth_of(vehicle: Quadrotor, delay: float) -> dict[str, float]:
    """The numbers of a vehicle by the names of the estimates."""
    found = {"mass": vehicle.mass, "motor lag up": vehicle.motor_time[0], "motor lag down": vehicle.motor_time[1], "dead time": delay}
    loop = vehicle.rate_loop
    words, gains = ("rate gain", vehicle.rate_gain) if loop is None else ("rate loop", loop.p)
    found |= {f"{words} {turn}": gain for turn, gain in zip(("roll", "pitch", "yaw"), gains, strict=True)}
    return found | {f"drag {axis}": drag for axis, drag in zip("xyz", vehicle.drag, strict=True)}


def show(found: Identification, truth: dict[str, float]) -> None:
    """A row for each number."""
    for one in found.estimates:
        if one.name in truth and one.told:
            true = truth[one.name]
            off = f"{one.value / true - 1:+.1%}" if true else ""
            print(f"  {one.name:16} {one.value:9.4g}  {one.low:9.4g} to {one.high:9.4g}  truth {true:9.4g}  {off}")


def step_response(simulator: Simulator, weight: float, axis: int, size: float) -> tuple[float, float]:
    """How a hovering drone follows a step of its thrust (axis 0, as a share of the weight) or of a body rate [rad/s].

    Returns:
        Time [s] to 63 % of the step, and the largest value, as a share of the step.
    """
    simulator.reset(0, Start(np.array([0.0, 0.0, 30.0, 1.0, *np.zeros(9)])))
    hover = np.tile([weight, 0.0, 0.0, 0.0], (simulator.lanes, 1))
    simulator.advance(hover, SETTLING)
    begun = simulator.rotor_thrusts()[0].sum()
    hover[:, axis] = weight * (1 + size) if axis == 0 else size
    followed = np.empty(round(STEP_SECONDS / simulator.step) + 1)
    for k in range(len(followed)):
        followed[k] = (simulator.rotor_thrusts()[0].sum() / begun - 1 if axis == 0 else simulator.states()[0][9 + axis]) / size
        simulator.advance(hover, simulator.step)
    if axis == 0:
        followed /= followed[-1]  # of what it gives, which is another matter
    k = int(np.argmax(followed >= SHARE))
    return simulator.step * (k - (followed[k] - SHARE) / (followed[k] - followed[k - 1])), float(followed.max())


def show_steps(simulator: Simulator, identified: Simulator, weight: float) -> None:
    """A row for each axis."""
    for axis, (name, size) in enumerate(STEPS.items()):
        (time_there, most_there), (time_here, most_here) = (step_response(one, weight, axis, size) for one in (simulator, identified))
        off = f"{time_here / time_there - 1:+.1%}"
        print(f"  step of {name:6} 63 % after {1e3 * time_there:5.1f} ms, identified {1e3 * time_here:5.1f} ms  {off:7}", end="")
        print(f"  largest {most_there:.2f}, identified {most_here:.2f}")


def own(draws: int) -> None:
    """Many drones in the built-in world."""
    base, rows, spent = load_quadrotor(BASE), dict[str, list[tuple[float, float, bool]]](), list[float]()
    left = dict[str, list[tuple[float, float]]]()
    for seed in range(draws):
        vehicle, delay = drawn(base, seed)
        log = rehearse(PlantSimulator(vehicle, base), base, seed=seed, delay=delay, noise=NOISE)
        begun = time.process_time()
        found = identify([log], base, thrust_known=True)
        spent.append(time.process_time() - begun)
        for one in found.estimates:
            true = truth_of(vehicle, delay).get(one.name)
            if true is not None:
                whole = 1.0 if one.name == "dead time" else true
                sizes = abs(one.value - true) / whole, (one.high - one.low) / 2 / whole
                rows.setdefault(one.name, []).append((*sizes, one.low <= true <= one.high))
        for one in found.predictions:
            left.setdefault(f"{one.channel} {one.axis} [{one.unit}]", []).append((one.error, one.former_error))
    print(f"{draws} drones, {np.median(spent):.1f} s of processor time a log in the median")
    for name, row in rows.items():
        offs, halves, held = np.array(row).T
        off = f"off by {np.sqrt(np.mean(offs**2)):.4f} rms, {offs.max():.4f} at most, half an interval {np.mean(halves):.4f}"
        print(f"  {name:16} {off}; {int(held.sum())} of {draws} intervals hold it")
    show_left({name: np.mean(np.array(pairs), axis=0) for name, pairs in left.items()})


def show_left(left: dict[str, Floats]) -> None:
    """Errors of what was predicted and not fitted, and those of the base."""
    for name, (error, former) in left.items():
        print(f"  {name:16} error where it was not fitted {error:.4f}, of the base {former:.4f}")


def example(folder: Path) -> None:
    """The flights of the documentation, the minute and half a minute of hover, and what `hotlap identify` says of them."""
    base = load_quadrotor(BASE)
    vehicle = base.model_copy(update=EXAMPLE)
    folder.mkdir(parents=True, exist_ok=True)
    for name, pushes, seconds in (("flight", True, SECONDS), ("hover", False, SECONDS / 2)):
        path, picture = folder / f"{name}.csv", folder / f"{name}.png"
        log = rehearse(PlantSimulator(vehicle, base), base, seed=1, delay=EXAMPLE_DELAY, pushes=pushes, seconds=seconds)
        write_hotlap_csv(path, log)
        main_of_hotlap(["identify", str(path), "--quadrotor", BASE, "--known", "thrust", "--picture", str(picture)])


def flown(name: str) -> tuple[Simulator, Quadrotor, Quadrotor]:
    """A simulator, the base, and what is true."""
    known = load_quadrotor("cf21b-500-crazyflow" if name == "crazyflow" else BASE)
    known = known.model_copy(update={"rate_loop": None})  # crazyflow's own loop flies its own drones alone
    heavy = known.model_copy(update={"mass": known.mass * HEAVIER, "drag": DRAG})
    if name == "betaflight":
        from hotlap.worlds.betaflight.gains import as_flown  # noqa: PLC0415  optional

        believed = import_module("hotlap.worlds.betaflight.simulator").Betaflight(heavy, (), most_rate=8.0, floor=-1e9)
        return believed, as_flown(known), as_flown(heavy.model_copy(update={"mass": known.mass}))  # its sticks know the mass
    module, kind = import_module(f"hotlap.worlds.{name}"), {"rotorpy": "RotorPy", "crazyflow": "Crazyflow"}[name]
    return getattr(module, kind)(heavy, known), known, heavy


def main() -> None:
    """Fly and identify."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("worlds", nargs="*", default=["own"], metavar="WORLD", help=", ".join(WORLDS))
    parser.add_argument("--draws", type=int, default=100, help="drones in the built-in world")
    parser.add_argument("--out", type=Path, default=Path("build/identification"), help="folder of the example's flight and picture")
    options = parser.parse_args()
    for name in options.worlds:
        if name == "own":
            own(options.draws)
            continue
        if name == "example":
            example(options.out)
            continue
        simulator, base, vehicle = flown(name)
        log = rehearse(simulator, base, seed=1, delay=DELAY[name])
        begun = time.process_time()
        found = identify([log], base.model_copy(update={"delay": 0.0}), thrust_known=True)
        print(f"{name}: {time.process_time() - begun:.1f} s of processor time")
        show(found, truth_of(vehicle, DELAY[name]))
        show_left({f"{one.channel} {one.axis} [{one.unit}]": np.array([one.error, one.former_error]) for one in found.predictions})
        mine = quadrotor_of(found, name)
        show_steps(simulator, cast("Simulator", PlantSimulator(mine, mine)), base.gravity)
        simulator.close()


if __name__ == "__main__":
    main()

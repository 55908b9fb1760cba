"""The comparisons of tuners that the documentation quotes, each resumable: python benchmarks/comparison.py PART

Parts: main, fifty, airsim, random, harder, confirm, ablation, guess. Every tuner begins at the default weights, except in the part guess. A
part keeps its runs in `--out`/PART (default: build/comparison), with tables and pictures.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from hotlap.cli import main as hotlap
from hotlap.files.descriptions import load_race, save
from hotlap.race.random_tracks import random_track

TABLE_I = ("circle-20", "circle-34", "drop-20", "flip-16", "spiral-53", "qualifier-20", "final-22")
AIRSIM = tuple(f"airsim-{name}" for name in TABLE_I)
BUDGETS = "200,cma_es=1000,particle_swarm=1000"  # flights, as in the paper

QUICK = (
    "gate_gp:published", "guided_walk", "metropolis_hastings:tied", "metropolis_hastings:paper", "metropolis_hastings:released",
    "random_search:paper", "random_search:uniform", "random_search:log_uniform", "cma_es:log", "cma_es:raw", "cma_es:tied",
    "cma_es:bipop", "cma_es:warm", "particle_swarm:paper", "particle_swarm:log", "simulated_annealing:tied", "simulated_annealing:paper",
    "tempered:swapping", "tempered:independent", "tempered:multiple_try", "weighted_likelihood:tied", "weighted_likelihood:segments",
    "gradient:spsa", "gradient:spsa_segments", "gradient:finite_differences", "trust_region:default", "trust_region:tied",
    "trust_region:dense",
)  # fmt: skip
SLOW = (
    "gradient_boosting:surrogate", "safe_bayesian:plane", "bayesian:matern", "bayesian:locally_periodic", "bayesian:rational_quadratic",
    "bayesian:squared_exponential", "bayesian:periodic", "bayesian:log",
)  # fmt: skip
ABLATION = tuple(f"gate_gp:{preset}" for preset in ("published", "whole", "one_generation", "tied", "no_restarts", "no_exploration"))
RIVALS = ("gate_gp:published", "guided_walk", "cma_es:log", "cma_es:tied", "trust_region:default", "trust_region:tied",
          "trust_region:dense", "metropolis_hastings:paper", "metropolis_hastings:tied")  # fmt: skip
RANDOM = {"default": ("circle-34", 22.0), "airsim": ("airsim-circle-34", 18.0)}  # suite: race that gives all but the track, v_max [m/s]
UNSEEN = range(100, 110)  # seeds of random tracks that were not used in development, in each suite
SINGLE = ("main", "fifty", "airsim", "ablation", "random", "harder", "guess")
HARDER = {"47.5 ms": {"delay": 0.0475}, "A": {"delay": 0.05, "torque_damping": 0.5}}


def write_random(folder: Path) -> list[str]:
    """Write races on random tracks as files; their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for suite, (base, v_max) in RANDOM.items():
        race = load_race(base)
        planning = race.planning.model_copy(update={"v_max": v_max})
        for seed in UNSEEN:
            track = random_track(seed)
            name = f"{suite}-{track.name}"
            path = folder / f"{name}.toml"
            save(path, race.model_copy(update={"name": name, "track": track, "planning": planning}))
            paths.append(str(path))
    return paths


def write_harder(folder: Path) -> list[str]:
    """Write races of Table I with a vehicle that is harder to control as files; in A the controller's model has 30 ms of the dead time."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for label, changes in HARDER.items():
        for base in TABLE_I:
            race = load_race(base)
            name = f"{base}-{label.replace(' ', '').replace('.', '-')}"
            model = race.control_model.model_copy(update={"delay": 0.03} if label == "A" else {})
            path = folder / f"{name}.toml"
            save(path, race.model_copy(update={"name": name, "vehicle": race.vehicle.model_copy(update=changes), "model": model}))
            paths.append(str(path))
    return paths


def main() -> int:
    """Run one part."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("part", choices=(*SINGLE, "confirm"))
    parser.add_argument("--out", type=Path, default=Path("build/comparison"))
    parser.add_argument("--quick", action="store_true", help="main: leave out the tuners that need much computing time")
    arguments, rest = parser.parse_known_args()
    out = arguments.out / arguments.part
    tuners = QUICK if arguments.quick else QUICK + SLOW
    hard = (*AIRSIM[1:6], "airsim-spiral20-53", "airsim-final-21", "airsim-final-22")
    parts = {
        "main": lambda: [*TABLE_I, *AIRSIM, "--tuners", ",".join(tuners), "--seeds", "20", "--budget", BUDGETS],
        "fifty": lambda: [*TABLE_I, "--tuners", "gate_gp:published", "--seeds", "50", "--budget", "250"],
        "airsim": lambda: [
            *hard,
            "--tuners",
            "gate_gp:published,guided_walk,cma_es:log,trust_region:tied",
            "--seeds",
            "20",
            "--budget",
            "300",
        ],
        "ablation": lambda: [*TABLE_I, *AIRSIM[:6], "--tuners", ",".join(ABLATION), "--seeds", "10"],
        "random": lambda: [*write_random(out), "--tuners", ",".join(RIVALS), "--seeds", "10"],
        "guess": lambda: [*TABLE_I, *hard, "--tuners", "gate_gp:published", "--seeds", "20", "--budget", "300", "--first-guess", "learned"],
        "harder": lambda: [
            *write_harder(out),
            "--tuners",
            "gate_gp:published,guided_walk,metropolis_hastings:tied,cma_es:tied",
            "--seeds",
            "10",
        ],
    }
    if arguments.part != "confirm":
        return hotlap(["compare", *parts[arguments.part](), "--out", str(out), *rest])
    asked = [*TABLE_I, *AIRSIM[1:6], "--tuners", "gate_gp:published", "--seeds", "20", "--budget", "500", "--validation", "200"]
    counts = (4, 10, 20, 40)
    return max(hotlap(["compare", *asked, "--confirm", str(count), "--out", str(out / str(count)), *rest]) for count in counts)


if __name__ == "__main__":
    sys.exit(main())

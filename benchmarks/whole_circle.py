"""What a controller has to know of a drone: python benchmarks/whole_circle.py --help

The files of docs/whole_circle.md are written into an empty folder and its minute is flown and identified. Then the unknown drone flies its
laps through Betaflight's firmware, each time by a controller that knows more of it; plans leave a fifth of the thrust that is known.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import sys
import tempfile
from pathlib import Path
from types import ModuleType

import hotlap
from hotlap.files.descriptions import load_quadrotor, save
from hotlap.race.quadrotor import Quadrotor

DOCS = Path(__file__).resolve().parents[1] / "docs"
LAPS = 'base = "as-believed.toml"\nvehicle = "unknown.toml"\nmodel = "known.toml"\n'


def transcript() -> ModuleType:
    """The program that reads pages."""
    spec = importlib.util.spec_from_file_location("transcript", DOCS / "transcript.py")
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules["transcript"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def known() -> dict[str, Quadrotor]:
    """What the controller knows, from nothing to all."""
    believed, unknown = load_quadrotor("believed.toml"), load_quadrotor("unknown.toml")
    found = [hotlap.identify("flight.csv", quadrotor="believed.toml", known=known, progress=False) for known in ("mass,rate_loop", "mass")]
    mine, loop_too = (one.quadrotor for one in found)
    return {
        "what the file says": believed,
        "thrust": believed.model_copy(update={"rotor_thrust": mine.rotor_thrust}),
        "dead time": believed.model_copy(update={"delay": mine.delay}),
        "thrust and dead time": believed.model_copy(update={"rotor_thrust": mine.rotor_thrust, "delay": mine.delay}),
        "all that was identified": mine,
        "the same, the rate loop identified, too": loop_too,
        "the truth": unknown,
    }


def main() -> None:
    """Write, identify, fly."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--flights", type=int, default=50)
    flights, page = parser.parse_args().flights, (DOCS / "whole_circle.md").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        transcripts = transcript()
        for block in transcripts.BLOCK.finditer(page):
            if block["language"] != "console" and (named := transcripts.FILE.match(block["text"])):
                Path(named[1]).write_text(block["text"], encoding="utf-8")
        transcripts.run(("python", "unknown_drone.py"))
        Path("laps.toml").write_text(LAPS, encoding="utf-8")
        print("| the controller knows | flights through all gates | plan |\n|---|---|---|")
        for name, model in known().items():
            save("known.toml", model.model_copy(update={"provenance": ""}))
            flown = hotlap.fly("laps.toml", on="betaflight", flights=flights, progress=False)
            successes = flown.complete.successes
            print(f"| {name} | {successes} of {flights} | {flown.scenario.reference.lap_time:.2f} s |", flush=True)
        os.chdir("/")


if __name__ == "__main__":
    main()

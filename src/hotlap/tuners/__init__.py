"""Tuners by name: every module of this folder that defines `PRESETS` is an algorithm; `build` makes one.

A new algorithm is one new file here, `my_tuner.py`, with a class `MyTuner`, made as `MyTuner(name, settings)`, and with `PRESETS`, settings
by the name of the preset, the default first. There is no list to edit. In a module outside of hotlap the same two are enough: the tuner's
name is then `my_module.MyTuner`.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Mapping
from importlib import import_module
from types import ModuleType
from typing import Any

from hotlap.core.errors import InputError, UnknownNameError
from hotlap.core.own_code import import_own
from hotlap.core.renamed import say_renamed
from hotlap.tuners.renamed import current_name
from hotlap.tuners.tuner import Tuner

DEFAULT = "gate_gp"

Maker = Callable[[str, Any], Tuner]
Presets = Mapping[str, Any]


def names() -> tuple[str, ...]:
    """Every algorithm with each of its presets, `NAME:PRESET`; the first preset of an algorithm is its default."""
    return tuple(f"{algorithm}:{preset}" for algorithm, (_, presets) in _algorithms().items() for preset in presets)


def build(name: str) -> Tuner:
    """A tuner, not yet started.

    Args:
        name: `ALGORITHM` or `ALGORITHM:PRESET`; the preset may be `default`. An algorithm with a dot is a class to import.

    Raises:
        UnknownNameError: with the names that there are.
        InputError: a class that cannot be imported, or is no tuner.
    """
    renamed = current_name(name)
    if renamed != name:
        say_renamed(name, renamed)
    algorithm, separator, preset = renamed.partition(":")
    found = _import(algorithm) if "." in algorithm else _algorithm(algorithm)
    if found is None:
        raise UnknownNameError("tuner", name, (*_algorithms(), *names()), key="tuner")
    make, presets = found
    if not separator or preset == "default":
        preset = next(iter(presets))
    if preset not in presets:
        raise UnknownNameError(f"preset of {algorithm}", preset, (*presets, "default"), key="tuner")
    if "." in algorithm:
        from hotlap.tuners.checked import made  # noqa: PLC0415  only where there is a tuner of someone else's

        return made(make, f"{algorithm}:{preset}", presets[preset])
    return make(f"{algorithm}:{preset}", presets[preset])


def _modules() -> list[str]:
    """Names of the modules of this package, in alphabetical order."""
    return sorted(module.name for module in pkgutil.iter_modules(__path__) if not module.ispkg)


def _algorithms() -> dict[str, tuple[Maker, Presets]]:
    """Class and presets of every algorithm; imports them all."""
    found = {module: _algorithm(module) for module in _modules()}
    return {module: algorithm for module, algorithm in found.items() if algorithm is not None}


def _algorithm(name: str) -> tuple[Maker, Presets] | None:
    """Class and presets of one algorithm, or None where no module of this package is one; imports that module alone."""
    if name not in _modules():
        return None
    module = import_module(f"{__name__}.{name}")
    return (_class_of(module, name), module.PRESETS) if hasattr(module, "PRESETS") else None


def _class_of(module: ModuleType, name: str) -> Maker:
    """The class of an algorithm, called as its file is: `GateGp` of `gate_gp.py`."""
    return getattr(module, "".join(word.capitalize() for word in name.split("_")))


def _import(path: str) -> tuple[Maker, Presets]:
    """A class and its presets from a module outside of hotlap."""
    place, _, name = path.rpartition(".")
    try:
        module = import_own(place)
        made, presets = getattr(module, name), module.PRESETS
    except Exception as error:  # a module of someone else's may raise anything
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError("", "tuner", f"{path} cannot be imported: {reason}") from error
    if not isinstance(made, type):
        raise InputError("", "tuner", f"{path} cannot be imported: it is no class")
    if not isinstance(presets, Mapping) or not presets:
        raise InputError("", "tuner", f"{path} cannot be imported: its PRESETS must map at least one name to settings")
    return made, presets


__all__ = ["DEFAULT", "Tuner", "build", "names"]

"""Worlds by name: where flights happen; all answer to the protocol of `world.py`.

A name is `built-in`, that of a simulator, or `my_module.MySimulator` for one's own; what follows a colon is told to the simulator, as in
`airsim:127.0.0.1:41451`. A simulator is a module of this package, `NAME`, with

    open_simulator(scenario: Scenario, instance: int, argument: str = "") -> Simulator

and, where opening it takes long, the words `OPENING` for what it does then. It is imported when it is asked for, so that nobody needs the
packages of a simulator that is not used.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from hotlap.core.errors import InputError, UnknownNameError
from hotlap.core.own_code import import_own
from hotlap.core.vehicle_names import LANGUAGES
from hotlap.core.world_names import BUILT_IN, OWN, SERVED, SIMULATORS
from hotlap.system.engine import Engine
from hotlap.worlds.built_in import BuiltIn
from hotlap.worlds.simulator import Simulator
from hotlap.worlds.world import World

if TYPE_CHECKING:
    from hotlap.worlds.stepped import Stepped

DEFAULT = BUILT_IN
MOST_INSTANCES = 256


def names() -> tuple[str, ...]:
    """Every world that comes with hotlap, the built-in one first; some need packages or programs of their own."""
    return (BUILT_IN, *(name for name in SIMULATORS if find_spec(f"{__name__}.{name}") is not None))


def build(name: str, instances: int = 1, engine: Engine | None = None) -> World:
    """A world by its name; a simulator is opened by the first flight.

    Args:
        name: of the world, and what its simulator is told behind a colon.
        instances: simulators that fly side by side.
        engine: whose workers open the simulators; None: this process does.

    Raises:
        UnknownNameError: with the names that there are.
        InputError: a simulator of one's own that cannot be imported, or a number of instances that makes no sense.
    """
    if not 1 <= instances <= MOST_INSTANCES:
        raise InputError("", "instances", f"must be from 1 to {MOST_INSTANCES}, not {instances}")
    base, _, argument = name.partition(":")
    if name == BUILT_IN:
        if instances > 1:
            raise InputError("", "instances", f"are of simulators; {BUILT_IN} flies on all processors at once")
        return BuiltIn()
    if base in LANGUAGES:
        flies = f"hotlap.lap(RACE, parameters=FILE, on={name!r})"
        raise InputError("", "on", f"{base} is no world but a real vehicle, which is flown once: {flies}")
    if "." not in base and base not in names():
        raise UnknownNameError("world", name, (*names(), OWN), key="on")
    if base == BUILT_IN:
        raise InputError("", "on", f"{BUILT_IN} is told nothing, not '{argument}'")
    opened = _import(base) if "." in base else partial(_open, base)
    if engine is not None:
        from hotlap.worlds.on_workers import OnWorkers  # noqa: PLC0415  only for simulators on workers

        check_spread(name)
        engine.require(*needed(name))
        return _named(OnWorkers(name, instances, engine), base)
    from hotlap.worlds.stepped import Stepped  # noqa: PLC0415  only for simulators

    return _named(Stepped(name, partial(_tell, opened, argument) if argument else opened, instances), base)


def check_spread(name: str) -> None:
    """Refuse worlds that workers of a cluster cannot open.

    Raises:
        InputError: it is a server, of which there is one.
    """
    base = name.partition(":")[0]
    if base in SERVED:
        raise InputError("", "cluster", f"has no {base}, which is a server of its own")


def needed(name: str) -> tuple[str, ...]:
    """What a world by its name reads, besides hotlap: the module of one's own simulator, and a file that it is told."""
    base, _, argument = name.partition(":")
    return base.rpartition(".")[0], argument


def _named(world: Stepped, base: str) -> Stepped:
    """A world with the words for what it does while it is opened."""
    if "." not in base:
        world.opening = getattr(import_module(f"{__name__}.{base}"), "OPENING", world.opening)
    return world


def _open(name: str, *told: Any) -> Simulator:
    """Open a simulator that comes with hotlap."""
    return import_module(f"{__name__}.{name}").open_simulator(*told)


def _tell(opened: Callable[..., Simulator], argument: str, *told: Any) -> Simulator:
    """Open a simulator with what its name says behind the colon."""
    return opened(*told, argument)


def _import(path: str) -> Callable[..., Any]:
    """What opens a simulator of one's own: a class, or a function."""
    place, _, name = path.rpartition(".")
    try:
        opened = getattr(import_own(place), name)
    except Exception as error:  # a module of someone else's may raise anything
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError("", "on", f"{path} cannot be imported: {reason}") from error
    if not callable(opened):
        raise InputError("", "on", f"{path} cannot be imported: it is no class")
    return opened


__all__ = ["DEFAULT", "BuiltIn", "World", "build", "names"]

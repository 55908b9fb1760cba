"""Real flight: the tuned controller on a real vehicle, through a link that speaks its language.

A vehicle is named `LANGUAGE:ARGUMENT`, as in `mavlink:udpin:127.0.0.1:14540`. A language is a module of this package, listed in
`core.vehicle_names`, with

    open_link(argument: str, period: float, *, mute: bool) -> Link

It is imported when it is asked for, so that nobody needs the packages of a vehicle that is not flown. What a link has to do says `link`;
what is flown with it, in which order, and what stops it is the same for all of them and stands in `flight`.
"""

from __future__ import annotations

from importlib import import_module

from hotlap.core.errors import InputError, UnknownNameError
from hotlap.core.vehicle_names import LANGUAGES
from hotlap.real_flight.link import Link


def open_link(name: str, period: float, *, mute: bool = False) -> Link:
    """A link to a vehicle by its name; nothing is sent before it is opened.

    Args:
        name: language and argument.
        period: [s] of the control loop: how often states are wanted.
        mute: whether it only listens: it sends heartbeats, and neither commands nor questions.

    Raises:
        UnknownNameError: with the languages that there are.
        InputError: its argument is none, or a package is missing.
    """
    language, colon, argument = name.partition(":")
    if language not in LANGUAGES:
        raise UnknownNameError("vehicle", name, tuple(f"{one}:ADDRESS" for one in LANGUAGES), key="on")
    if not colon or not argument:
        raise InputError("", "on", f"{language} needs an address: {LANGUAGES[language]}")
    return import_module(f"{__name__}.{language}").open_link(argument, period, mute=mute)

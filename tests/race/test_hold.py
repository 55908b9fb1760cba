"""The words of `--hold`: what they mean, and what is said where they mean nothing."""

from __future__ import annotations

import pytest

from hotlap.core.errors import InputError
from hotlap.race.hold import parse_hold

GOOD = {
    "": [],
    " ": [],
    "mass=+10%": ["10 % heavier"],
    "mass=-10 %": ["10 % lighter"],
    "mass = +- 10%": ["10 % lighter", "10 % heavier"],
    "mass=±10%": ["10 % lighter", "10 % heavier"],
    "mass=+/-7.5%": ["7.5 % lighter", "7.5 % heavier"],
    "thrust=-20%": ["20 % less thrust"],
    "thrust=\N{MINUS SIGN}20%": ["20 % less thrust"],
    "delay=+20ms": ["20 ms more dead time"],
    "delay=+-0.01s": ["10 ms less dead time", "10 ms more dead time"],
    "drag=+50%": ["50 % more drag"],
    "motor=+-20%": ["20 % faster motors", "20 % slower motors"],
    "inertia=-5%": ["5 % less inertia"],
    "rate_gain=-30%": ["30 % softer rate loop"],
    "noise=x2": ["twice the noise"],
    "noise=1.5": ["1.5 times the noise"],
    "wind=3": ["steady push of 3 m/s^2 as of wind"],
    "gusts=.5m/s^2": ["gusts that push with 0.5 m/s^2"],
    "sag=15%": ["battery sag of 15 %"],
    "wind=3, gusts=2,wind=3": ["steady push of 3 m/s^2 as of wind", "gusts that push with 2 m/s^2"],
    "mass=+-10% & wind=3": ["10 % lighter and steady push of 3 m/s^2 as of wind", "10 % heavier and steady push of 3 m/s^2 as of wind"],
}
BAD = {
    "mass": "'mass': must be like mass=",
    "mass=+10%,": "'': must be like mass=",
    "mass=10%": "'mass=10%': less or more? It must be like mass=+10%, -10% or +-10%",
    "mass=+10": "'mass=+10': must be like mass=+10%",
    "mass=+10kg": "'mass=+10kg': must be like mass=+10%",
    "mass=heavy": "'mass=heavy': must be like mass=+10%",
    "mass=x2": "'mass=x2': must be like mass=+10%",
    "mass=-95%": "'mass=-95%': mass must be from -90% to +900%",
    "delay=+20": "'delay=+20': must be like delay=+20ms",
    "delay=20ms": "'delay=20ms': less or more? It must be like delay=+20ms",
    "delay=+20%": "'delay=+20%': must be like delay=+20ms",
    "delay=+20s": "'delay=+20s': delay must be from -250ms to +250ms",
    "wind=+3": "'wind=+3': must be like wind=3",
    "wind=3m/s": "'wind=3m/s': must be like wind=3 or 3m/s^2",
    "wind=1000": "'wind=1000': wind must be from 0 to 100 m/s^2",
    "sag=0.1": "'sag=0.1': must be like sag=15%",
    "sag=95%": "'sag=95%': sag must be from 0% to 90%",
    "noise=x1e3": "'noise=x1e3': must be like noise=x2",
    "weight=+10%": r"'weight=\+10%': there is no quantity 'weight' \(did you mean mass\?\); available: mass, thrust",
    "wieght=+10%": r"there is no quantity 'wieght' \(did you mean mass\?\)",
    "trust=+10%": r"there is no quantity 'trust' \(did you mean thrust\?\)",
    "Mass=+10%": r"there is no quantity 'Mass' \(did you mean mass\?\)",
    "zzz=1": "there is no quantity 'zzz'; available",
    "wind=1 & wind=2": "'wind=1 & wind=2': changes wind twice at once",
    "mass=+10% & thrust": "'mass=+10% & thrust': must be like",
}


@pytest.mark.parametrize("text", GOOD)
def test_what_is_asked_for_is_read(text):
    assert [condition.name for condition in parse_hold(text)] == GOOD[text]


@pytest.mark.parametrize("text", GOOD)
def test_conditions_can_be_asked_for_again_in_their_own_words(text):
    conditions = parse_hold(text)
    assert parse_hold(", ".join(condition.text for condition in conditions)) == conditions


@pytest.mark.parametrize("text", BAD)
def test_what_means_nothing_is_refused_on_one_line_with_item_and_reason(text):
    wanted = BAD[text] if "\\" in BAD[text] else BAD[text].replace("?", r"\?").replace("+", r"\+").replace("^", r"\^")
    with pytest.raises(InputError, match=f"^hold: .*{wanted}") as caught:
        parse_hold(text)
    assert "\n" not in str(caught.value)

"""Printed figures: whether what a finding of `check` says to people is there for programs."""

from __future__ import annotations

import math
import re

FIGURE = re.compile(r"(?P<number>-?\d+(?:\.\d+)?(?:e[-+]?\d+)?)\s?(?P<unit>%|[a-zA-Z][\w/^]*)?")
SUFFIXES = {
    "m": "_m",
    "m/s": "_m_per_s",
    "m/s^2": "_m_per_s2",
    "s": "_s",
    "ms": "_s",
    "deg": "_rad",
    "Hz": "_hz",
    "rad/s": "_rad_per_s",
    "rad/s^2": "_rad_per_s2",
}
FACTORS = {"ms": 1e-3, "%": 1e-2, "deg": math.pi / 180}


def check_figures(finding):
    """Every number of a finding's value is among its figures, as precisely as it is printed and in the unit of its name."""
    if not finding.value[:1].isdigit():
        return  # words
    for match in FIGURE.finditer(finding.value):
        number, unit = match["number"], match["unit"] or ""
        digit = 10.0 ** -len(number.partition(".")[2]) if "e" not in number else abs(float(number))
        factor, suffix = FACTORS.get(unit, 1.0), SUFFIXES.get(unit, "")
        near = [name for name, value in finding.figures.items() if abs(abs(value) - factor * float(number)) <= 1.01 * factor * digit]
        assert any(name.endswith(suffix) for name in near), (finding, number, unit)

"""Parameters files of the straight race, as people write them."""

from __future__ import annotations

VALUES = {"Q_pos_xy": 100, "Q_pos_z": 300, "Q_attitude": 50, "Q_velocity": 5, "horizon": 4}


def segment(kind: str, start: str, end: str) -> str:
    """One segment, with `VALUES`."""
    values = "".join(f"{name} = {value}\n" for name, value in VALUES.items())
    return f'[[segment]]\nclass = "{kind}"\nstart = {start}\nend = {end}\n{values}'


def parameters(*segments: str, more: str = "") -> str:
    """A file of some segments, with more tables before them."""
    names = ", ".join(f'"{name}"' for name in VALUES)
    return f'race = "straight"\nnames = [{names}]\n{more}{"".join(segments)}'

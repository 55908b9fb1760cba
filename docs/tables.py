"""Write the tables of keys in files.md from the descriptions themselves: python docs/tables.py."""

from __future__ import annotations

import re
from pathlib import Path

from hotlap.files import toml_writer
from hotlap.files.documented_keys import documented_keys
from hotlap.race import battery, gate, observer, obstacles, race, rate_loop, track
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.schema import Described

PAGE = Path(__file__).with_name("files.md")
DESCRIPTIONS: dict[str, type[Described]] = {
    "track": track.Track,
    "gate": gate.Gate,
    "pole": obstacles.Pole,
    "sphere": obstacles.Sphere,
    "box": obstacles.Box,
    "quadrotor": Quadrotor,
    "battery": battery.Battery,
    "rate_loop": rate_loop.RateLoop,
    "race": race.Race,
    "planning": race.PlanningSettings,
    "ramp": race.Ramp,
    "controller": race.ControllerSettings,
    "observer": observer.ObserverSettings,
    "noise": race.NoiseSettings,
    "judge": race.JudgeSettings,
}
BLOCK = re.compile(r"(<!-- keys: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def table(description: type[Described]) -> str:
    """A row for each key."""
    rows = ["| key | unit | meaning | default |", "|---|---|---|---|"]
    for key in documented_keys(description):
        plain = key.default is not None and key.table is None
        needed = "the file's own name" if key.name == "name" else "*required*"
        default = needed if key.required else f"`{toml_writer.write_value(key.default)}`" if plain else ""
        rows.append(f"| `{key.name}` | {key.unit} | {key.meaning.replace('|', chr(92) + '|')} | {default} |")
    return "\n".join(rows) + "\n"


def fill(text: str) -> str:
    """The page with its tables brought up to date."""
    return BLOCK.sub(lambda block: block[1] + table(DESCRIPTIONS[block[2]]) + block[3], text)


if __name__ == "__main__":
    PAGE.write_text(fill(PAGE.read_text(encoding="utf-8")), encoding="utf-8")

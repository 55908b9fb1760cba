"""Package data: files of hotlap that are no Python and decide about its results, too, and what tells them and the code apart."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from hotlap.core import version
from hotlap.system.disk_cache import digest_sources

ROOT = Path(version.__file__).parents[1]
ELSEWHERE = {"first_guess": "data/first_guess.json"}  # data of a package that do not lie in its folder
PYTHON = frozenset({".py", ".pyc", ".pyo", ".pyi"})


def digest_packages(packages: Sequence[str], *sources: str | Path) -> str:
    """Sixteen hexadecimal digits that change whenever what packages compute could change, by their code or their data.

    Args:
        packages: names within hotlap.
        sources: other code; see `digest_sources`.
    """
    code = digest_sources(*(f"hotlap.{name}" for name in packages), *sources)
    return hashlib.sha256(f"{code} {digest_data(*packages)}".encode()).hexdigest()[:16]


@cache
def digest_data(*packages: str) -> str:
    """Sixteen hexadecimal digits of the content of the data of packages.

    Args:
        packages: names within hotlap.
    """
    digest = hashlib.sha256()
    for path in data_files(*packages):
        content = path.read_bytes()
        digest.update(f"{path.relative_to(ROOT).as_posix()} {len(content)}\n".encode() + content)
    return digest.hexdigest()[:16]


def data_files(*packages: str) -> list[Path]:
    """Files of packages that are no Python, in a fixed order.

    Args:
        packages: names within hotlap.
    """
    places = [ROOT / place for name in packages for place in (name, ELSEWHERE.get(name, name))]
    found = {path for place in places for path in (place.rglob("*") if place.is_dir() else [place])}
    return sorted(path for path in found if path.is_file() and path.suffix not in PYTHON and not path.name.startswith("."))

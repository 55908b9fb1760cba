"""Keep what `hotlap reproduce` found: python docs/reproduced.py [DIR]; pages and pictures here, results in benchmarks/results."""

from __future__ import annotations

import gzip
import sys
from pathlib import Path

HERE = Path(__file__).parent
PAGES, RESULTS = HERE / "reproduced", HERE.parent / "benchmarks" / "results"
QUICK = "-quick"
KEPT = ("lines.jsonl", "runs.jsonl")


def keep(folder: Path) -> None:
    """One experiment: its page with the pictures beside it, and its results in short."""
    text = (folder / "page.md").read_text(encoding="utf-8")
    for picture in sorted(folder.glob("*.png")):
        name = f"{folder.name}-{picture.name}"
        text = text.replace(f"]({picture.name})", f"]({name})")
        (PAGES / name).write_bytes(picture.read_bytes())
    (PAGES / f"{folder.name}.md").write_text(text, encoding="utf-8")
    for file in KEPT:
        if (folder / file).exists():
            name = f"{folder.name}{'' if file == 'runs.jsonl' else '-pieces'}.jsonl.gz"
            (RESULTS / name).write_bytes(gzip.compress((folder / file).read_bytes(), 9, mtime=0))


def main(build: Path) -> None:
    """Everything that is whole."""
    for page in sorted(build.glob("*/page.md")):
        if not page.parent.name.endswith(QUICK):
            keep(page.parent)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "build/reproduced"))

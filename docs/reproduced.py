"""Keep what `hotlap reproduce` found: python docs/reproduced.py [DIR]; pages and pictures here, results in benchmarks/results.

Each page ends with what is behind it: the command, the runs, and the commit that flew them, which is that of the working tree.
"""

from __future__ import annotations

import gzip
import subprocess
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
    runs = []
    for file in KEPT:
        if (folder / file).exists():
            name = f"{folder.name}{'' if file == 'runs.jsonl' else '-pieces'}.jsonl.gz"
            (RESULTS / name).write_bytes(gzip.compress((folder / file).read_bytes(), 9, mtime=0))
            runs.append(name)
    text += evidence(folder.name, runs, git("rev-parse", "--short", "HEAD"), git("log", "-1", "--format=%as"))
    (PAGES / f"{folder.name}.md").write_text(text, encoding="utf-8")


def evidence(name: str, runs: list[str], commit: str, day: str) -> str:
    """What is behind a page, in Markdown."""
    files = ", ".join(f"{{download}}`{run} <../../benchmarks/results/{run}>`" for run in runs)
    told = f"`hotlap reproduce {name}` at commit `{commit}` ({day}). Every run with its race, seed and result, one a line: {files}"
    return f"\n## What is behind it\n\n{told}; at that commit the same command comes to the same figures.\n"


def git(*words: str) -> str:
    """What git says."""
    return subprocess.run(["git", *words], cwd=HERE, capture_output=True, text=True, check=True).stdout.strip()


def main(build: Path) -> None:
    """Everything that is whole."""
    for page in sorted(build.glob("*/page.md")):
        if not page.parent.name.endswith(QUICK):
            keep(page.parent)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "build/reproduced"))

"""Guided by coverage: libFuzzer keeps the inputs that reach something new: `python tests/fuzz/guided.py READER [--seconds N] [--out DIR]`.

Needs atheris (`make fuzz-guided` installs it). What is kept lies in the folder, so the next call goes on from there; the first input
that does what none should ends it, and lies there, too, as crash-NUMBER.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import atheris

sys.path.insert(0, str(Path(__file__).parents[1]))

# All else is compiled, or reads no file.
READING = ("core", "files", "race", "importers", "reference_files", "first_guess", "logs", "feasibility")
with atheris.instrument_imports(include=["tomllib", *(f"hotlap.{part}" for part in READING)]):
    from fuzz.logs import LOGS
    from fuzz.readers import READERS, Reader
    from fuzz.trial import attempt

ALL = {**READERS, **LOGS}


def guide(reader: Reader, seconds: int, kept: Path) -> None:
    """Give a reader inputs for so many seconds; the process ends with it, with 0 where nothing was at fault."""
    kept.mkdir(parents=True, exist_ok=True)
    for k, sample in enumerate(reader.samples()):
        (kept / f"sample-{k}").write_bytes(sample)
    folder = kept.with_name(f"{kept.name}-input")  # libFuzzer ends the process, so nothing would be removed after it
    folder.mkdir(exist_ok=True)
    path = folder / f"input{reader.ending}"

    def prepare(content: bytes) -> object:
        path.write_bytes(content)
        return lambda: reader.refuse_in_a_line(path)

    def give(content: bytes) -> None:
        figures = attempt(reader.name, lambda _: prepare(content), 1, folder)
        if figures.faults:
            raise AssertionError("\n".join(figures.faults))

    longest = 2 * max(len(sample) for sample in reader.samples())
    options = [f"-max_total_time={seconds}", f"-max_len={longest}", f"-artifact_prefix={kept}/", "-print_final_stats=1"]
    atheris.Setup([sys.argv[0], *options, str(kept)], give)
    atheris.Fuzz()


def main() -> None:
    """Guide one reader."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reader", choices=ALL, metavar="READER", help=", ".join(ALL))
    parser.add_argument("--seconds", type=int, default=600)
    parser.add_argument("--out", type=Path, default=Path("build/fuzz"))
    asked = parser.parse_args()
    guide(ALL[asked.reader], asked.seconds, asked.out.resolve() / asked.reader.replace(" ", "-").replace(",", ""))


if __name__ == "__main__":
    main()

"""Power cut: what a disk may hold when the power goes, and whether hotlap goes on from it: python benchmarks/power_cut.py --help

A job is flown under strace, which writes down what it does to its files. From that the disk is rebuilt as it may be when the power goes at
a random moment: all that was synced is there; of what was written since, in each file nothing, everything, a beginning, or any part, torn
at a sector; of names that were made, renamed and removed since a folder was synced, a beginning. (File systems in use lose less.) The same
command then goes on from there, and has to end with the very results of the job that was never stopped; nothing that was kept at the last
sync may be lost. Linux and strace only. Outcomes are kept in `--out`; the same command continues.
"""

from __future__ import annotations

import argparse
import random
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path

import torture
from torture import HOTLAP, JOBS, LONGEST, Job, Place, Whole, ends_alike, fly_whole, warm_up

from hotlap.core.errors import HotlapError
from hotlap.system.disk_cache import digest_sources
from hotlap.system.journal import Journal

SECTOR = 512  # bytes that are written whole
CALLS = "openat,write,pwrite64,ftruncate,rename,renameat,renameat2,unlink,unlinkat,fsync,fdatasync,lseek"
TRACED = ("tune: gate_gp", "tune: planning", "compare", "learn")
_QUOTED = re.compile(r'"((?:\\x[0-9a-f]{2})*)"')
_FILE = re.compile(r"^(\d+)<((?:\\x[0-9a-f]{2})*)>")
_CALL = re.compile(r"^(\d+)\s+(\w+)\((.*)\)\s+= (-?\d+)")


@dataclass
class File:
    """Content that is on the disk, and what was written since.

    Attributes:
        safe: content at the last sync.
        since: writes since, each a place and what was written there; None instead of it: the file was cut at that place.
    """

    safe: bytes = b""
    since: list[tuple[int, bytes | None]] = field(default_factory=list)

    def content(self, kept: Sequence[tuple[int, bytes | None]] | None = None) -> bytes:
        """Content after some of the writes since; None: all of them."""
        content = bytearray(self.safe)
        for place, data in self.since if kept is None else kept:
            if data is None:
                del content[place:]
            content.extend(bytes(max(0, place - len(content))))
            if data is not None:
                content[place : place + len(data)] = data
        return bytes(content)

    def torn(self, chance: random.Random) -> bytes:
        """Content as it may be when the power goes."""
        way, kept = chance.randrange(4), list(self.since)
        if way == 0:
            kept = []
        elif way == 1:
            kept = kept[: chance.randint(0, len(kept))]
        elif way == 2:
            kept = [one for one in kept if chance.random() < 0.5]
        if kept and (last := kept[-1])[1] and chance.random() < 0.5:
            kept[-1] = (last[0], last[1][: SECTOR * chance.randint(0, len(last[1]) // SECTOR)])
        return self.content(kept)


@dataclass
class Disk:
    """Files by name, as they are on the disk and as programs see them.

    Attributes:
        safe: names at the last sync of their folder.
        since: what was done to names since, by folder: a name, and its file or None where it was removed.
        seen: names as programs see them.
    """

    safe: dict[str, File] = field(default_factory=dict)
    since: dict[str, list[dict[str, File | None]]] = field(default_factory=dict)
    seen: dict[str, File] = field(default_factory=dict)
    _places: dict[tuple[str, str], int] = field(default_factory=dict)

    def name(self, changes: dict[str, File | None]) -> None:
        """Make, rename or remove names."""
        self.since.setdefault(next(iter(changes)).rpartition("/")[0], []).append(changes)
        _apply(self.seen, changes)

    def open(self, path: str, flags: str, descriptor: str) -> None:
        """A file is opened, made if there is none."""
        if path not in self.seen:
            if "O_CREAT" not in flags:
                return
            self.name({path: File()})
        elif "O_TRUNC" in flags:
            self.seen[path].since.append((0, None))
        self._places[descriptor, path] = -1 if "O_APPEND" in flags else 0

    def write(self, path: str, descriptor: str, data: bytes, place: int | None) -> None:
        """Bytes are written, at a place or where the file stands."""
        if (file := self.seen.get(path)) is None:
            return
        at = self._places.get((descriptor, path), 0) if place is None else place
        file.since.append((len(file.content()) if at < 0 else at, data))
        if place is None and at >= 0:
            self._places[descriptor, path] = at + len(data)

    def seek(self, path: str, descriptor: str, place: int) -> None:
        """A file is written from another place on."""
        if self._places.get((descriptor, path), -1) >= 0:
            self._places[descriptor, path] = place

    def sync(self, path: str) -> None:
        """What was written to a file, or done to the names in a folder, is on the disk."""
        if path in self.seen:
            file = self.seen[path]
            file.safe, file.since = file.content(), []
        for changes in self.since.pop(path, []):
            _apply(self.safe, changes)

    def whole(self) -> dict[str, bytes]:
        """Contents by name, as programs see them."""
        return {path: file.content() for path, file in self.seen.items()}

    def torn(self, chance: random.Random) -> dict[str, bytes]:
        """Contents by name, as they may be when the power goes."""
        names = dict(self.safe)
        for changes in self.since.values():
            for change in changes[: chance.choice((0, len(changes), chance.randint(0, len(changes))))]:
                _apply(names, change)
        return {path: file.torn(chance) for path, file in names.items()}


def _apply(names: dict[str, File], changes: dict[str, File | None]) -> None:
    for name, file in changes.items():
        if file is None:
            names.pop(name, None)
        else:
            names[name] = file


def calls(trace: Path, folder: Path) -> list[tuple[str, list[str], str]]:
    """Calls that succeeded and are about files in a folder: name, arguments and result."""
    inside, unfinished, found = _escaped(str(folder)), dict[str, str](), list[tuple[str, list[str], str]]()
    for line in trace.read_text(encoding="ascii").splitlines():
        if line.endswith("<unfinished ...>"):
            unfinished[line.split(maxsplit=1)[0]] = line.removesuffix("<unfinished ...>").rstrip()
            continue
        pid, _, rest = line.partition(" ")
        if (resumed := re.match(r"\s*<\.\.\. \w+ resumed>(.*)", rest)) and pid in unfinished:
            line = unfinished.pop(pid) + resumed[1]  # noqa: PLW2901  the whole line
        if inside in line and (call := _CALL.match(line)) and int(call[4]) >= 0:
            found.append((call[2], re.split(r", (?=(?:[^\"]*\"[^\"]*\")*[^\"]*$)", call[3]), call[4]))
    return found


def _escaped(text: str) -> str:
    return "".join(f"\\x{byte:02x}" for byte in text.encode())


def _text(argument: str) -> bytes:
    quoted = _QUOTED.search(argument)
    return bytes.fromhex(quoted[1].replace("\\x", "")) if quoted else b""


def follow(disk: Disk, name: str, arguments: list[str], result: str) -> None:
    """Do to a disk what a call did."""
    of_file = _FILE.match(arguments[0])
    descriptor, path = (of_file[1], bytes.fromhex(of_file[2].replace("\\x", "")).decode()) if of_file else ("", "")
    if name == "openat":
        disk.open(_text(arguments[1]).decode(), arguments[2], result)
    elif name in {"write", "pwrite64"}:
        disk.write(path, descriptor, _text(arguments[1])[: int(result)], int(arguments[3]) if name == "pwrite64" else None)
    elif name == "ftruncate" and path in disk.seen:
        disk.seen[path].since.append((int(arguments[1]), None))
    elif name == "lseek":
        disk.seek(path, descriptor, int(result))
    elif name.startswith("rename"):
        old, new = (_text(argument).decode() for argument in arguments if '"' in argument)
        disk.name({new: disk.seen[old], old: None})
    elif name.startswith("unlink"):
        disk.name({next(_text(argument) for argument in arguments if '"' in argument).decode(): None})
    elif name in {"fsync", "fdatasync"}:
        disk.sync(path)


def trace(place: Place, warm: Path, status: int) -> list[tuple[str, list[str], str]]:
    """What a job does to its files, from its beginning to its end, which has an exit status."""
    place.prepare(warm)
    log = place.folder / "calls"
    options = ["-f", "--seccomp-bpf", "-y", "-xx", "-s", "100000000", "-e", f"trace={CALLS}", "-o", str(log)]
    command = ["strace", *options, *HOTLAP, *place.job.arguments.split(), "--out", str(place.out)]
    done = subprocess.run(command, cwd=place.folder, env=place.environment(), capture_output=True, timeout=LONGEST, check=False)
    if done.returncode != status:
        sys.exit(f"{place.job.name} ends with {done.returncode} under strace, not with {status}:\n{done.stderr.decode(errors='replace')}")
    return calls(log, place.folder)


def cut(place: Place, warm: Path, whole: Whole, log: Sequence[tuple[str, list[str], str]], traced: Path, chance: random.Random) -> str:
    """One trial; what went wrong in it, "" where nothing did."""
    moment, disk, at_sync = chance.randrange(len(log)), Disk(), dict[str, bytes]()
    last_sync = max((k for k in range(moment) if "sync" in log[k][0]), default=-1)
    for k in range(moment):
        follow(disk, *log[k])
        if k == last_sync:
            at_sync = disk.whole()
    kept = 0
    for number, files in enumerate((at_sync, disk.torn(chance))):
        place.prepare(warm)
        _lay(place, traced, files)
        try:
            kept, before = place.kept(), kept
        except HotlapError as error:
            return f"at call {moment}, does not open: {error}"
        if number and kept < before:
            return f"at call {moment}, {before - kept} of {before} results are lost"
    wrong = ends_alike(place, whole)
    return f"at call {moment}, {wrong}" if wrong else ""


def _lay(place: Place, traced: Path, files: dict[str, bytes]) -> None:
    for name, content in files.items():
        path = place.folder / Path(name).relative_to(traced)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.unlink(missing_ok=True)
        path.write_bytes(content)


def run_job(job: Job, folder: Path, warm: Path, kept: Journal, trials: int, processes: int) -> None:
    """All trials of a job that are not kept yet, several at a time."""
    missing = [trial for trial in range(trials) if f"{job.name} #{trial}" not in kept.done]
    if not missing:
        return
    whole = fly_whole([Place(folder / "whole", job)], warm)
    traced = folder / "traced"
    log = trace(Place(traced, job), warm, whole.status)

    def one(trial: int) -> tuple[int, str]:
        place = Place(folder / f"cut-{trial}", job)
        try:
            wrong = cut(place, warm, whole, log, traced, random.Random(f"{job.name} #{trial}"))
        except (HotlapError, ValueError, OSError) as error:  # of what was being read, or hangs
            wrong = f"{type(error).__name__}: {error}"
        if not wrong:
            shutil.rmtree(place.folder)
        return trial, wrong

    with ThreadPoolExecutor(processes) as pool:
        for done in as_completed([pool.submit(one, trial) for trial in missing]):
            trial, wrong = done.result()
            kept.add(f"{job.name} #{trial}", {"job": job.name, "calls": len(log), "wrong": wrong})
            print(f"{job.name} {trial + 1} of {trials}: {wrong or 'identical'}", file=sys.stderr, flush=True)


def table(outcomes: Sequence[dict[str, str]]) -> Iterator[str]:
    """Lines of Markdown: of each job how many trials ended identical."""
    yield "| job | power cut |"
    yield "|---|---:|"
    for job in dict.fromkeys(one["job"] for one in outcomes):
        its = [one for one in outcomes if one["job"] == job]
        yield f"| {job} | {sum(not one['wrong'] for one in its)}/{len(its)} |"


def main(arguments: Sequence[str] | None = None) -> None:
    """Cut the power of all jobs, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("jobs", nargs="*", metavar="JOB", default=list(TRACED), help=f"parts of names (default: {', '.join(TRACED)})")
    parser.add_argument("--trials", type=int, default=25, help="of each job")
    parser.add_argument("--processes", type=int, default=2, help="trials at a time")
    parser.add_argument("--out", type=Path, default=Path("build/power-cut"))
    asked = parser.parse_args(arguments)
    if shutil.which("strace") is None:
        sys.exit("power_cut.py needs strace")
    jobs, folder = [job for job in JOBS if any(part in job.name for part in asked.jobs)], asked.out.resolve()
    with Journal.opened(folder, digest_sources("hotlap", Path(__file__), Path(torture.__file__))) as kept:
        warm = warm_up(folder, jobs)
        for job in jobs:
            run_job(job, folder, warm, kept, asked.trials, asked.processes)
        outcomes = [kept.done[f"{job.name} #{trial}"] for job in jobs for trial in range(asked.trials)]
    print("\n".join(table(outcomes)))
    sys.exit("\n".join(f"{one['job']}: {one['wrong']}" for one in outcomes if one["wrong"]) or 0)


if __name__ == "__main__":
    main()

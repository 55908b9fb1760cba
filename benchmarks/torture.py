"""Torture: hotlap is stopped at random moments, goes on, and must end as if nothing had happened: python benchmarks/torture.py --help

A job is flown once to its end. Then, in each trial, the same job begins in a folder of its own and something befalls it at a random moment
of its run: its processes are killed, all or one of them, Ctrl-C or SIGTERM arrives, or the disk is full. After that no process of it may
live, all that was kept before must still be there, and the same command has to end with the very results, files and exit status of the job
that was never stopped. Linux only (/proc); the full disk is a small file system in memory, which only root can mount: else those trials are
left out. Outcomes are kept in `--out`; the same command continues. `power_cut.py` takes the power away.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hotlap.core.errors import HotlapError
from hotlap.study.database import FILE as STUDY
from hotlap.study.study import Study
from hotlap.system.disk_cache import digest_sources
from hotlap.system.journal import Journal

HOTLAP = (sys.executable, "-m", "hotlap")
PATIENCE = 20.0  # s within which all processes of a command that is dead have to be gone
LONGEST = 600.0  # s of one command
TIMES = {"tuner_time", "cpu_time", "checksum"}  # keys of what is another at each run, and the sum of a line that has them
TIME_COLUMN = "ms/flight"  # of a table, likewise
ROOM = 256 << 20  # bytes of a disk that is not full
SHORT_RACE = """vehicle = "hummingbird"

[track]
name = "short"
start = [0.0, 0.0, 1.0]

[[track.gates]]
position = [4.0, 1.0, 1.5]

[[track.gates]]
position = [7.0, -2.0, 1.5]
"""

KILLED, PARENT, WORKER, CTRL_C, TERM, FULL = (
    "kill -9 of all",
    "kill -9 of the parent",
    "kill -9 of a process",
    "Ctrl-C",
    "SIGTERM",
    "full disk",
)
STATUSES = {KILLED: (-9,), PARENT: (-9,), WORKER: (-9, 2), CTRL_C: (-2, 130), TERM: (-15, 143)}  # of a command that is not done yet
FAULTS = (KILLED, PARENT, WORKER, CTRL_C, TERM, FULL)


@dataclass(frozen=True)
class Job:
    """What is done, and from which caches it begins.

    Attributes:
        name: of the job.
        arguments: of hotlap, without `--out`.
        trials: how often something befalls it.
        plans, kernels: whether plans and compiled code are there when a trial begins.
    """

    name: str
    arguments: str
    trials: int
    plans: bool = True
    kernels: bool = True


TUNE = "tune circle-34 --goal none --validation 50"
JOBS = (
    Job("tune: gate_gp", f"{TUNE} --budget 60", 34),
    Job("tune: metropolis_hastings", f"{TUNE} --budget 80 --tuner metropolis_hastings", 33),
    Job("tune: cma_es", f"{TUNE} --budget 120 --tuner cma_es", 33),
    Job("tune: planning", "tune short.toml --goal none --budget 20 --validation 20", 24, plans=False),
    Job("tune: compiling", "tune circle-34 --goal none --budget 20 --validation 20", 8, kernels=False),
    Job("tune: fastest lap", "tune short.toml --goal lap_time --budget 20 --validation 20", 18),
    Job("compare", "compare circle-34 circle-20 --tuners gate_gp,cma_es --seeds 2 --budget 40 --jobs 2", 30),
    Job("learn", "learn circle-34 circle-20 --jobs 2", 24),
    Job("reproduce", "reproduce experts --quick --jobs 2", 24),
)


@dataclass(frozen=True)
class Place:
    """A folder in which a job works.

    Attributes:
        folder: with the results in `out` and the caches in `cache`.
        job: that works there.
    """

    folder: Path
    job: Job

    @property
    def out(self) -> Path:
        """Where the results are."""
        return self.folder / "out"

    def prepare(self, warm: Path) -> None:
        """Make the folder, with a copy of the caches that the job may begin with."""
        shutil.rmtree(self.folder, ignore_errors=True)
        self.out.mkdir(parents=True)
        (self.folder / "short.toml").write_text(SHORT_RACE, encoding="utf-8")
        left_out = [name for name, there in (("plans", self.job.plans), ("kernels", self.job.kernels)) if not there]
        if warm.exists():
            shutil.copytree(warm, self.folder / "cache", copy_function=_link, ignore=shutil.ignore_patterns(*left_out))

    def environment(self) -> dict[str, str]:
        """Of its commands."""
        cache = self.folder / "cache"
        cache.mkdir(mode=0o700, exist_ok=True)
        return {**os.environ, "HOTLAP_CACHE": str(cache), "PYTHONFAULTHANDLER": "1"}

    def start(self) -> subprocess.Popen[bytes]:
        """Begin, or go on."""
        command, environment = [*HOTLAP, *self.job.arguments.split(), "--out", str(self.out)], self.environment()
        with (self.folder / "said").open("wb") as said:
            return subprocess.Popen(
                command,
                cwd=self.folder,
                env=environment,
                stdout=said,
                stderr=subprocess.STDOUT,
                stdin=subprocess.DEVNULL,
                start_new_session=True,
            )

    def finish(self) -> int:
        """Run to the end; the exit status.

        Raises:
            HotlapError: it hangs; its processes are killed.
        """
        return finish(self.start())

    def said(self) -> str:
        """What the last command said."""
        return (self.folder / "said").read_text(encoding="utf-8", errors="replace")

    def kept(self) -> int:
        """How many flights and results are kept.

        Raises:
            HotlapError: what is there is damaged.
        """
        file, flights = self.out / STUDY, 0
        if file.exists() and file.stat().st_size:
            try:
                flights = len(Study.read(self.out).flights())
            except HotlapError:
                if file.stat().st_size:  # else nothing was in it yet
                    raise
        return flights + sum(path.read_bytes().count(b"\n") for path in self.out.rglob("*.jsonl"))

    def result(self) -> dict[str, Any]:
        """Everything that a job leaves, by the name of its file, without what is another each time."""
        return {str(path.relative_to(self.out)): _content(path) for path in sorted(self.out.rglob("*")) if path.is_file()}


def _link(source: str, target: str) -> str:
    os.link(source, target)
    return target


def _content(path: Path) -> Any:
    """What has to be the same: rows and results to the last bit; of pages and pictures that they are whole."""
    if path.name == STUDY:
        study = Study.read(path.parent)
        flights = study.flights()
        return {"flights": repr(flights.records()), "bits": flights.parameters.tobytes().hex(), "values": study.values.tobytes().hex()}
    if path.suffix == ".jsonl":
        return sorted(json.dumps(_timeless(json.loads(line)), sort_keys=True) for line in path.read_text(encoding="utf-8").splitlines())
    if path.suffix in {".toml", ".json"}:
        return path.read_text(encoding="utf-8")
    if path.suffix == ".html":
        return path.read_text(encoding="utf-8").rstrip().endswith("</html>")
    if path.suffix in {".md", ".csv"}:
        return list(_timeless_lines(path.read_text(encoding="utf-8")))
    if path.suffix == ".png":
        content = path.read_bytes()
        return content.startswith(b"\x89PNG") and content.endswith(b"IEND\xaeB`\x82")
    return path.name


def _timeless_lines(text: str) -> Iterator[str]:
    """Lines without the column of a table that says how long a tuner has thought."""
    thought = None
    for line in text.splitlines():
        cells = line.split(" | ")
        names = [cell.strip(" |") for cell in cells]
        if TIME_COLUMN in names:
            thought = names.index(TIME_COLUMN)
        elif not line.startswith("|"):
            thought = None
        yield " | ".join(cell for k, cell in enumerate(cells) if k != thought)


def _timeless(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _timeless(inner) for key, inner in value.items() if key not in TIMES}
    return [_timeless(inner) for inner in value] if isinstance(value, list) else value


def finish(process: subprocess.Popen[bytes]) -> int:
    """Wait for the end of a command; its exit status.

    Raises:
        HotlapError: it hangs; its processes are killed.
    """
    try:
        return process.wait(LONGEST)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        outlived(process.pid)
        raise HotlapError("hangs") from None


def session(leader: int) -> list[int]:
    """Processes of a session that live, its leader last."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            state, _, _, its_session = path.read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()[:4]
            if int(its_session) == leader and state not in {"Z", "X"}:
                found.append(int(path.parent.name))
    return sorted(found, key=lambda pid: (pid == leader, pid))


def strike(process: subprocess.Popen[bytes], fault: str, chance: random.Random) -> None:
    """Let a fault befall a command that runs; nothing where it has ended already."""
    with suppress(ProcessLookupError):
        if fault in {KILLED, CTRL_C}:  # a terminal sends Ctrl-C to all
            os.killpg(process.pid, signal.SIGKILL if fault == KILLED else signal.SIGINT)
        elif fault == WORKER:
            os.kill(chance.choice(session(process.pid)[:-1] or [process.pid]), signal.SIGKILL)
        else:
            os.kill(process.pid, {PARENT: signal.SIGKILL, TERM: signal.SIGTERM}[fault])


def outlived(leader: int) -> bool:
    """Whether a process of a dead command lives on; it is killed."""
    until = time.monotonic() + PATIENCE
    while (left := session(leader)) and time.monotonic() < until:
        time.sleep(0.05)
    for pid in left:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    return bool(left)


@contextmanager
def small_disk(folder: Path, size: int) -> Iterator[None]:
    """A context in which a folder lies on a disk of its own; `grow` makes room."""
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "hotlap-torture", str(folder)], check=True, capture_output=True)
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=False, capture_output=True)


def grow(folder: Path) -> None:
    """Make room on a small disk."""
    subprocess.run(["mount", "-o", f"remount,size={ROOM}", str(folder)], check=True, capture_output=True)


@dataclass(frozen=True)
class Whole:
    """A job that was never stopped.

    Attributes:
        seconds: that it took.
        status: its exit status.
        size: [bytes] of its files.
        result: of `Place.result`.
    """

    seconds: float
    status: int
    size: int
    result: dict[str, Any]


def fly_whole(places: Sequence[Place], warm: Path) -> Whole:
    """Fly a job to its end, from the caches of its trials and as many at a time; ends the program where they do not end alike."""
    for place in places:
        place.prepare(warm)
    began = time.monotonic()
    with ThreadPoolExecutor(len(places)) as pool:
        statuses = list(pool.map(Place.finish, places))
    seconds, results = time.monotonic() - began, [place.result() for place in places]
    if statuses[0] not in {0, 1}:
        sys.exit(f"{places[0].job.name} ends with {statuses[0]}:\n{places[0].said()}")
    if any(result != results[0] for result in results) or len({*statuses}) > 1:
        sys.exit(f"{places[0].job.name} ends in different ways when nothing befalls it")
    size = sum(path.stat().st_size for path in places[0].out.rglob("*") if path.is_file())
    return Whole(seconds, statuses[0], size, results[0])


def torment(place: Place, warm: Path, whole: Whole, fault: str, chance: random.Random) -> str:
    """One trial; what went wrong in it, "" where nothing did."""
    place.prepare(warm)
    try:
        if fault != FULL:
            return _struck(place, whole, fault, chance)
        with small_disk(place.out, chance.randrange(min(1 << 12, whole.size // 2), whole.size)):
            process = place.start()
            status = finish(process)
            complaint = "" if status in {0, 1} else f"exit status {status}"
            complaint = complaint or _after(process, place, 0)
            grow(place.out)
            return complaint or ends_alike(place, whole)
    except (HotlapError, ValueError, OSError) as error:  # of what was being read, or hangs
        return f"{type(error).__name__}: {error}"


def _struck(place: Place, whole: Whole, fault: str, chance: random.Random) -> str:
    moment = chance.uniform(0.0, whole.seconds)
    process = place.start()
    with suppress(subprocess.TimeoutExpired):
        process.wait(moment)
    kept = 0
    if process.poll() is None:
        with suppress(HotlapError):  # it is being made
            kept = place.kept()
    strike(process, fault, chance)
    status = finish(process)
    if status not in {0, 1, *STATUSES[fault]}:
        return f"exit status {status}"
    return _after(process, place, kept) or ends_alike(place, whole)


def _after(process: subprocess.Popen[bytes], place: Place, kept: int) -> str:
    """What is wrong when a command has been stopped."""
    if outlived(process.pid):
        return "a process outlives its parent"
    if "Traceback" in place.said() or "Fatal Python error" in place.said():
        return f"traceback: {place.said()[-1500:]}"
    try:
        left = place.kept()
    except HotlapError as error:
        return f"does not open: {error}"
    return "" if left >= kept else f"{kept - left} of {kept} results are lost"


def ends_alike(place: Place, whole: Whole) -> str:
    """What is wrong with the end of a job that goes on; "" where nothing is."""
    status = place.finish()
    if status != whole.status:
        return f"goes on to exit status {status}: {place.said()[-1500:]}"
    result = place.result()
    differ = [name for name in result.keys() | whole.result.keys() if result.get(name) != whole.result.get(name)]
    return f"ends with another {', '.join(sorted(differ))}" if differ else ""


def can_mount(folder: Path) -> bool:
    """Whether a small disk can be had."""
    try:
        with small_disk(folder, 1 << 16):
            return True
    except (OSError, subprocess.CalledProcessError):
        return False


def warm_up(folder: Path, jobs: Sequence[Job]) -> Path:
    """Caches with all that the jobs plan and compile, filled by one job after another, each once."""
    warm, filled = folder / "warm", folder / "warm.txt"
    names = filled.read_text().splitlines() if filled.exists() and warm.exists() else []
    for job in jobs:
        if job.name in names:
            continue
        place = Place(folder / "warming", Job(job.name, job.arguments, 0))
        place.prepare(warm)
        print(f"filling caches: {job.name}", file=sys.stderr, flush=True)
        place.finish()
        shutil.rmtree(warm, ignore_errors=True)
        (place.folder / "cache").rename(warm)
        names.append(job.name)
        filled.write_text("".join(f"{name}\n" for name in names))
    return warm


def run_job(job: Job, folder: Path, warm: Path, kept: Journal, processes: int, faults: Sequence[str]) -> None:
    """All trials of a job that are not kept yet, several at a time."""
    missing = [trial for trial in range(job.trials) if _key(job, trial) not in kept.done]
    if not missing:
        return
    whole = fly_whole([Place(folder / f"whole-{k}", job) for k in range(processes)], warm)

    def one(trial: int) -> tuple[int, dict[str, str]]:
        fault = faults[trial % len(faults)]
        place = Place(folder / f"trial-{trial}", job)
        wrong = torment(place, warm, whole, fault, random.Random(_key(job, trial)))
        if not wrong:
            shutil.rmtree(place.folder)
        return trial, {"job": job.name, "fault": fault, "wrong": wrong}

    with ThreadPoolExecutor(processes) as pool:
        for done in as_completed([pool.submit(one, trial) for trial in missing]):
            trial, outcome = done.result()
            kept.add(_key(job, trial), outcome)
            print(
                f"{job.name} {trial + 1} of {job.trials}, {outcome['fault']}: {outcome['wrong'] or 'identical'}",
                file=sys.stderr,
                flush=True,
            )


def _key(job: Job, trial: int) -> str:
    return f"{job.name} #{trial}"


def table(outcomes: Sequence[dict[str, str]]) -> Iterator[str]:
    """Lines of Markdown: of each job and fault, how many trials ended identical."""
    faults = [fault for fault in FAULTS if any(one["fault"] == fault for one in outcomes)]
    tried, good = (Counter((one["job"], one["fault"]) for one in outcomes if not (good and one["wrong"])) for good in (False, True))
    yield f"| job | {' | '.join(faults)} | all |"
    yield f"|---|{'---:|' * (len(faults) + 1)}"
    for job in dict.fromkeys(one["job"] for one in outcomes):
        cells = [f"{good[job, fault]}/{tried[job, fault]}" if tried[job, fault] else "" for fault in faults]
        both = [sum(count for (name, _), count in counter.items() if name == job) for counter in (good, tried)]
        yield f"| {job} | {' | '.join(cells)} | {both[0]}/{both[1]} |"


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly all jobs, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("jobs", nargs="*", metavar="JOB", default=[""], help="parts of names, such as compare (default: all)")
    parser.add_argument("--trials", type=int, default=0, help="of each job (default: 8 to 34)")
    parser.add_argument("--processes", type=int, default=2, help="trials at a time")
    parser.add_argument("--out", type=Path, default=Path("build/torture"))
    asked = parser.parse_args(arguments)
    jobs = [job for job in JOBS if any(part in job.name for part in asked.jobs)]
    jobs = [Job(job.name, job.arguments, asked.trials or job.trials, plans=job.plans, kernels=job.kernels) for job in jobs]
    folder = asked.out.resolve()
    with Journal.opened(folder, digest_sources("hotlap", Path(__file__))) as kept:
        (folder / "disk").mkdir(exist_ok=True)
        faults = FAULTS if can_mount(folder / "disk") else tuple(fault for fault in FAULTS if fault != FULL)
        warm = warm_up(folder, jobs)
        for job in jobs:
            run_job(job, folder, warm, kept, asked.processes, faults)
        outcomes = [kept.done[_key(job, trial)] for job in jobs for trial in range(job.trials)]
    print("\n".join(table(outcomes)))
    wrong = [f"{one['job']}, {one['fault']}: {one['wrong']}" for one in outcomes if one["wrong"]]
    sys.exit("\n".join(wrong) or 0)


if __name__ == "__main__":
    main()

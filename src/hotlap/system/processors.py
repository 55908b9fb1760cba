"""Processors that this process may use: fewer than the machine has where affinity or a container's quota says so."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

PROCESS = Path("/proc/self/cgroup")
HIERARCHIES = Path("/sys/fs/cgroup")


def available() -> int:
    """How many processors this process may keep busy, at least 1.

    The smallest of the processors that it may run on and the quotas of its control groups (Linux, version 1 and 2), rounded up.
    """
    return max(1, math.ceil(min(_usable(), _quota())))


def _usable() -> int:
    """Processors that this process may run on."""
    affinity: Callable[[int], set[int]] | None = getattr(os, "sched_getaffinity", None)  # Linux alone has it
    return len(affinity(0)) if affinity else os.cpu_count() or 1


def _quota() -> float:
    """Processors that the control groups of this process, and those around them, leave it; infinite where none is limited."""
    smallest = math.inf
    for group in _groups():
        for folder in (group, *group.parents):
            if folder == HIERARCHIES.parent:
                break
            smallest = min(smallest, _quota_of(folder))
    return smallest


def _groups() -> list[Path]:
    """Folders of the control groups of this process; within a container its own group may lie at the top."""
    found = [HIERARCHIES, HIERARCHIES / "cpu"]
    with suppress(OSError, ValueError):
        for line in PROCESS.read_text(encoding="utf-8").splitlines():
            _, controllers, path = line.split(":", 2)
            if not controllers:
                found.append(HIERARCHIES / path.strip("/"))
            elif "cpu" in controllers.split(","):
                found += [HIERARCHIES / name / path.strip("/") for name in ("cpu", controllers)]
    return found


def _quota_of(group: Path) -> float:
    """Processors that one control group leaves: quota over period [us]; infinite where it says nothing."""
    with suppress(OSError, ValueError, ZeroDivisionError):
        quota, period = (group / "cpu.max").read_text(encoding="utf-8").split()  # version 2
        return math.inf if quota == "max" else int(quota) / int(period)
    with suppress(OSError, ValueError, ZeroDivisionError):
        quota = int((group / "cpu.cfs_quota_us").read_text(encoding="utf-8"))  # version 1; -1 is no limit
        return quota / int((group / "cpu.cfs_period_us").read_text(encoding="utf-8")) if quota > 0 else math.inf
    return math.inf

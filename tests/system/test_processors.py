"""Processors that may be used, by affinity and by the quotas of control groups."""

import os

import pytest

from hotlap.system import processors

NO_LIMIT = {"cpu.max": "max 100000\n"}


@pytest.fixture
def machine(tmp_path, monkeypatch):
    """Sixteen processors; returns what places this process in control groups: its own, by folder, with their files."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(16)), raising=False)
    monkeypatch.setattr(processors, "PROCESS", tmp_path / "cgroup")
    monkeypatch.setattr(processors, "HIERARCHIES", tmp_path / "fs")

    def place(process: str, groups: dict[str, dict[str, str]]) -> None:
        (tmp_path / "cgroup").write_text(process)
        for group, files in groups.items():
            (tmp_path / "fs" / group).mkdir(parents=True, exist_ok=True)
            for name, text in files.items():
                (tmp_path / "fs" / group / name).write_text(text)

    return place


@pytest.mark.usefixtures("machine")
def test_affinity_counts(monkeypatch):
    assert processors.available() == 16
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 5, 6}, raising=False)
    assert processors.available() == 3


@pytest.mark.usefixtures("machine")
def test_systems_without_affinity_have_all(monkeypatch):
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.setattr(os, "cpu_count", lambda: 6)
    assert processors.available() == 6
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert processors.available() == 1


@pytest.mark.parametrize(
    ("process", "groups", "expected"),
    [
        ("0::/\n", {"": {"cpu.max": "200000 100000\n"}}, 2),
        ("0::/a/b\n", {"a/b": {"cpu.max": "250000 100000\n"}}, 3),  # two and a half keep three busy most of the time
        ("0::/a/b\n", {"a/b": NO_LIMIT, "a": {"cpu.max": "400000 100000\n"}}, 4),  # the group around it
        ("0::/a\n", {"a": {"cpu.max": "10000 100000\n"}}, 1),
        ("0::/a\n", {"a": NO_LIMIT}, 16),
        ("0::/of/the/host\n", {"": {"cpu.max": "200000 100000\n"}}, 2),  # a container sees its own group at the top
        ("4:cpu,cpuacct:/job\n", {"cpu/job": {"cpu.cfs_quota_us": "300000\n", "cpu.cfs_period_us": "100000\n"}}, 3),
        ("4:cpu,cpuacct:/job\n", {"cpu,cpuacct/job": {"cpu.cfs_quota_us": "50000\n", "cpu.cfs_period_us": "50000\n"}}, 1),
        ("4:cpu,cpuacct:/job\n", {"cpu/job": {"cpu.cfs_quota_us": "-1\n", "cpu.cfs_period_us": "100000\n"}}, 16),
        ("3:memory:/job\n", {}, 16),
        ("nonsense", {"": {"cpu.max": "nonsense"}}, 16),
    ],
)
def test_quotas_of_control_groups_count(machine, process, groups, expected):
    machine(process, groups)
    assert processors.available() == expected


def test_a_wide_quota_gives_no_more_than_there_are(machine):
    machine("0::/\n", {"": {"cpu.max": "9900000 100000\n"}})
    assert processors.available() == 16

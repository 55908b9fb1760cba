"""`--cluster`: every command that takes it gives what it gives here, although a worker is killed while it works."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import hotlap as package
from hotlap.analysis import front
from hotlap.cli import main
from hotlap.cli.arguments import COMMANDS
from hotlap.system.disk_cache import folder
from hotlap.worlds.betaflight import built
from hotlap.worlds.simulator import SimulatorError
from system.dask_cluster import running, wait_until

pytest.importorskip("distributed", reason="needs the extra cluster")

TAKE_IT = {"compare", "fly", "landscape", "learn", "reproduce", "transfer", "tune"}
FLOWN = ["--tuners", "random_search,cma_es:tied", "--seeds", "3", "--budget", "40", "--validation", "20"]


def test_these_commands_take_a_cluster():
    assert {name for name, command in COMMANDS.items() if "--cluster" in command.parser(name).options} == TAKE_IT


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("fly circle-34", "--cluster: is for flights in simulators"),
        ("tune circle-34", "--cluster: is for flights in simulators"),
        ("learn circle-34 --out l --jobs 2", "--jobs: are processes of this machine"),
        ("compare circle-34 --out c", "--cluster: there is no scheduler at tcp://127.0.0.1:9"),
        ("reproduce experts --out r", "--cluster: there is no scheduler at tcp://127.0.0.1:9"),
        ("landscape circle-34", "--cluster: there is no scheduler at tcp://127.0.0.1:9"),
        ("tune circle-34 --goal lap_time --out t", "--cluster: there is no scheduler at tcp://127.0.0.1:9"),
    ],
)
def test_a_cluster_that_is_of_no_use_is_told_in_one_line(hotlap, monkeypatch, command, said):
    monkeypatch.setattr("hotlap.system.cluster.TIMEOUT", 0.2)
    monkeypatch.setattr("hotlap.api.fastest.make_kind_ready", lambda *_: None)
    ran = hotlap(*command.split(), "--cluster", "tcp://127.0.0.1:9")
    assert ran.code == 2
    assert said in ran.err
    assert len(ran.err.splitlines()) == 1


@pytest.fixture
def _firmware():
    try:
        built.firmware()
    except SimulatorError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with running(tmp_path_factory.mktemp("dask"), 2, nanny=True) as started:
        yield started


def both(cluster, capsys, *command: str):
    """What a command prints here, and what it prints where a worker is killed meanwhile."""
    assert main([*command]) == 0
    here = capsys.readouterr().out
    cluster.wait_for(2)
    with cluster.losing_a_worker():
        assert main([*command, "--cluster", cluster.address]) == 0
    return here, capsys.readouterr().out


def runs_of(place: Path):
    """The runs of a comparison, but for the time that tuners took."""
    lines = [json.loads(line) for line in (place / "runs.jsonl").read_text(encoding="utf-8").splitlines()]
    found = [line["run"] | {"tuner_time": 0.0} for line in lines if "run" in line]
    return sorted(found, key=lambda run: (run["race"], run["tuner"], run["seed"]))


@pytest.mark.check
def test_a_comparison_is_the_same(cluster, tmp_path, capsys):
    races = ["drop-20", "flip-16"]
    assert main(["compare", *races, *FLOWN, "--out", str(tmp_path / "here")]) == 0
    with cluster.losing_a_worker():
        assert main(["compare", *races, *FLOWN, "--out", str(tmp_path / "there"), "--cluster", cluster.address]) == 0
    assert len(runs_of(tmp_path / "here")) == 12
    assert runs_of(tmp_path / "here") == runs_of(tmp_path / "there")
    assert "2 workers on 1 machine" in capsys.readouterr().err
    assert cluster.address not in (tmp_path / "there" / "comparison.html").read_text(encoding="utf-8")


@pytest.mark.check
def test_a_map_is_the_same(cluster, capsys):
    here, there = both(cluster, capsys, "landscape", "circle-34", "--points", "14", "--flights", "10", "--json")
    assert here == there


@pytest.mark.check
def test_what_is_learnt_is_the_same(cluster, tmp_path):
    races = ["circle-20", "airsim-circle-20"]
    assert main(["learn", *races, "--out", str(tmp_path / "here")]) == 0
    cluster.wait_for(2)
    with cluster.losing_a_worker():
        assert main(["learn", *races, "--out", str(tmp_path / "there"), "--cluster", cluster.address]) == 0
    assert (tmp_path / "here" / "first_guess.json").read_bytes() == (tmp_path / "there" / "first_guess.json").read_bytes()


@pytest.mark.check
def test_a_front_is_the_same(cluster, tmp_path, monkeypatch):
    monkeypatch.setattr(front, "LADDER", (0.8, 0.5))
    monkeypatch.setattr(front, "NARROWED", (0.5,))
    monkeypatch.setattr(front, "OTHERS", ())
    command = ["tune", "circle-20", "--goal", "lap_time", "--budget", "60", "--validation", "40", "--hold", "mass=+5%"]
    assert main([*command, "--out", str(tmp_path / "here")]) == 0
    cluster.wait_for(2)
    with cluster.losing_a_worker():
        assert main([*command, "--out", str(tmp_path / "there"), "--cluster", cluster.address]) == 0
    here, there = ((tmp_path / name / "front.json").read_text(encoding="utf-8") for name in ("here", "there"))
    assert here == there.replace(str(tmp_path / "there"), str(tmp_path / "here"))


@pytest.mark.check
@pytest.mark.usefixtures("_firmware")
def test_flights_of_betaflight_are_the_same(cluster, capsys):
    here, there = both(cluster, capsys, "fly", "circle-34", "--on", "betaflight", "--flights", "6", "--json")
    assert here == there


@pytest.mark.check
@pytest.mark.usefixtures("_firmware")
def test_flights_of_a_transfer_are_the_same(cluster, tmp_path, capsys):
    assert main(["tune", "circle-20", "--budget", "60", "--out", str(tmp_path / "s")]) == 0
    shutil.copytree(tmp_path / "s", tmp_path / "t")
    capsys.readouterr()
    assert main(["transfer", str(tmp_path / "s"), "--to", "betaflight", "--json"]) == 0
    here = json.loads(capsys.readouterr().out)
    cluster.wait_for(2)
    with cluster.losing_a_worker():
        assert main(["transfer", str(tmp_path / "t"), "--to", "betaflight", "--json", "--cluster", cluster.address]) == 0
    there = json.loads(capsys.readouterr().out)
    assert here["flights"] == there["flights"]


@pytest.mark.check
@pytest.mark.parametrize(
    ("file", "line", "said"),
    [("core/version.py", "__version__ = '9.9.9'", "has hotlap 9.9.9, not"), ("core/counts.py", "ANOTHER = 1", "has hotlap's code")],
)
def test_a_worker_with_another_hotlap_is_refused(hotlap, tmp_path_factory, file, line, said):
    place = tmp_path_factory.mktemp("other")
    shutil.copytree(Path(package.__file__).parent, place / "hotlap", ignore=shutil.ignore_patterns("__pycache__"))
    changed = place / "hotlap" / file
    changed.write_text(f"{changed.read_text(encoding='utf-8')}\n{line}\n", encoding="utf-8")
    with running(place, 1, environment={"PYTHONPATH": str(place)}) as own:
        ran = hotlap("landscape", "circle-34", "--points", "2", "--cluster", own.address)
    assert ran.code == 2
    assert said in ran.err
    assert len(ran.err.splitlines()) == 1


@pytest.mark.check
def test_ctrl_c_cancels_what_waits_on_the_cluster(cluster, tmp_path):
    from distributed import Client  # noqa: PLC0415  an extra

    cluster.wait_for(2)
    command = [sys.executable, "-m", "hotlap", "compare", "--races", "default", "--out", str(tmp_path / "c"), "--cluster", cluster.address]
    environment = {**os.environ, "HOTLAP_CACHE": str(folder("plans").parent)}
    with (
        Client(cluster.address, set_as_default=False) as client,
        subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run,
    ):
        wait_until(lambda: any(client.processing().values()), 120)
        run.send_signal(signal.SIGINT)
        _, said = run.communicate(timeout=60)
        assert run.returncode == 130
        assert "interrupted; nothing is lost; go on with: hotlap compare" in said
        assert f"--cluster {cluster.address}" in said
        wait_until(lambda: not any(client.processing().values()), 60)

"""A cluster as an engine: the same results as on this machine, whoever dies; and one line where it is not usable."""

from __future__ import annotations

import os
import signal
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from hotlap.core.errors import HotlapError, InputError
from hotlap.core.own_code import import_own
from hotlap.system import cluster_worker, engine
from hotlap.system.cluster_worker import do, fingerprint, installation, pack, unpack
from hotlap.system.engine import check_jobs, is_one_of_many, opened
from hotlap.system.process_pool import Processes
from system.dask_cluster import DaskCluster, running, wait_until

distributed = pytest.importorskip("distributed", reason="needs the extra cluster")


def square(piece: int):
    yield piece**2
    yield -piece


def say_where(piece: tuple[str, float]):
    folder, seconds = piece
    (Path(folder) / f"{os.getpid()}-{time.monotonic_ns()}").touch()
    time.sleep(seconds)
    yield os.getpid()


def wait_for(file: str):
    wait_until(Path(file).exists)
    yield os.getpid()


def complain(piece: int):
    yield piece
    raise InputError("file", "key", f"{piece} is bad")


def die(piece: int):
    yield piece
    os.kill(os.getpid(), signal.SIGKILL)


def one_of_many(_: int):
    yield is_one_of_many()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with running(tmp_path_factory.mktemp("dask"), 2) as started:
        yield started


def on(cluster, work, pieces, notes=None):
    with opened(cluster.address, note=(notes if notes is not None else []).append) as engine:
        return list(engine.spread(work, pieces))


def say_value(name: str):
    yield import_own(name).VALUE


@pytest.mark.check
def test_a_cluster_gives_what_processes_of_this_machine_give(cluster):
    pieces, notes = list(range(30)), []
    assert sorted(on(cluster, square, pieces, notes)) == sorted(Processes(2).spread(square, pieces))
    assert notes == [f"2 workers on 1 machine at {cluster.address}"]


@pytest.mark.check
def test_a_worker_of_a_cluster_is_one_of_many(cluster):
    assert on(cluster, one_of_many, [1]) == [(1, True)]
    assert not is_one_of_many()


@pytest.mark.check
def test_an_error_of_a_piece_arrives_as_it_was_after_its_results(cluster):
    with opened(cluster.address) as engine:
        results = engine.spread(complain, [3])
        assert next(results) == (3, 3)
        with pytest.raises(InputError, match="file: key: 3 is bad"):
            next(results)


@pytest.mark.check
def test_the_file_of_a_scheduler_is_as_good_as_its_address(cluster):
    with opened(str(cluster.file)) as engine:
        assert engine.workers == 2


@pytest.mark.check
def test_what_a_killed_worker_had_begun_is_done_by_one_that_joins(tmp_path):
    with running(tmp_path, 1) as own, opened(own.address) as engine:
        results = engine.spread(wait_for, [str(own.file), str(tmp_path / "killed")])
        assert next(results) == (str(own.file), own.workers[0].pid)
        own.workers[0].kill()
        own.workers[0].wait()
        own.add_worker()
        (tmp_path / "killed").touch()
        assert list(results) == [(str(tmp_path / "killed"), own.workers[1].pid)]


@pytest.mark.check
def test_what_a_killed_worker_had_begun_is_done_by_another(tmp_path):
    with running(tmp_path, 2) as own:
        begun, notes = tmp_path / "begun", []
        begun.mkdir()
        pieces = [(str(begun), 0.2)] * 20
        victim = own.workers[0]
        with opened(own.address, note=notes.append) as engine:
            found = []
            for piece, pid in engine.spread(say_where, pieces):
                found.append((piece, pid))
                if len(found) == 4:
                    victim.kill()
        assert [piece for piece, _ in found] == pieces
        assert {pid for _, pid in found[8:]} == {own.workers[1].pid}
        assert len(list(begun.iterdir())) > len(pieces)
        assert any("1 worker of the cluster lost" in line and "1 worker left" in line for line in notes)


@pytest.mark.check
def test_a_piece_that_kills_whoever_does_it_is_told_in_one_line(tmp_path):
    with running(tmp_path, 5) as own, opened(own.address) as engine, pytest.raises(HotlapError, match="ended every worker that began it"):
        list(engine.spread(die, [1]))


@pytest.mark.check
def test_without_any_worker_left_it_waits_for_one_that_joins_and_else_gives_up(tmp_path):
    with running(tmp_path, 1) as own:
        notes, found = [], []
        with opened(own.address, note=notes.append) as engine:
            for piece, _ in engine.spread(say_where, [(str(tmp_path), 0.1)] * 6):
                found.append(piece)
                if len(found) == 2:
                    own.workers[0].kill()
                    own.add_worker()
            assert len(found) == 6
            own.workers[1].kill()
            engine.patience = 1.0
            with pytest.raises(HotlapError, match="has had no worker for 1 s"):
                list(engine.spread(say_where, [(str(tmp_path), 0.1)]))


@pytest.mark.check
def test_a_scheduler_that_goes_is_told_in_one_line(tmp_path):
    with running(tmp_path, 1) as own, opened(own.address) as engine:
        own._scheduler.kill()
        with pytest.raises(HotlapError, match=r"has (gone|failed)"):
            list(engine.spread(say_where, [(str(tmp_path), 0.1)] * 3))


@pytest.mark.check
def test_what_waits_on_the_cluster_is_cancelled_when_the_work_is_given_up(cluster, tmp_path):
    with opened(cluster.address) as engine:
        results = engine.spread(say_where, [(str(tmp_path), 0.3)] * 40)
        next(results)
        results.close()
        begun = len(list(tmp_path.iterdir()))
        with distributed.Client(cluster.address, set_as_default=False) as client:
            wait_until(lambda: not any(client.processing().values()), 20)
        assert begun <= len(list(tmp_path.iterdir())) < 15


@pytest.mark.check
def test_a_module_of_the_folder_that_workers_were_started_in_is_found_and_after_a_change_they_are_to_be_restarted(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    module = tmp_path / "module_of_a_cluster.py"
    module.write_text("VALUE = 3\n")
    with running(tmp_path, 1, environment={"PYTHONSAFEPATH": "1"}) as own:  # as the command dask does
        with opened(own.address) as engine:
            engine.require("module_of_a_cluster")
            assert list(engine.spread(say_value, ["module_of_a_cluster"])) == [("module_of_a_cluster", 3)]
        module.write_text("VALUE = 4\n")
        with opened(own.address) as engine:
            engine.require("module_of_a_cluster")
            with pytest.raises(InputError, match="restart the workers"):
                list(engine.spread(say_value, ["module_of_a_cluster"]))


@pytest.mark.check
def test_a_worker_with_several_threads_is_refused(tmp_path):
    with DaskCluster(tmp_path) as own:
        with pytest.raises(InputError, match=r"has no workers; start some: dask worker"), opened(own.address):
            pass
        own.add_worker(threads=2)
        own.wait_for(1)
        with pytest.raises(InputError, match=r"has 2 threads, and should have one"), opened(own.address):
            pass


def test_a_worker_with_several_threads_that_joins_late_does_nothing():
    with distributed.Client(processes=False, n_workers=1, threads_per_worker=2, dashboard_address=":0", set_as_default=False) as client:
        results, error = unpack(client.submit(do, pack(square, 3, ()), fingerprint()).result())
    assert results == []
    assert "has 2 threads, and should have one" in str(error)


@pytest.mark.check
def test_a_worker_with_several_threads_that_joins_later_is_refused_too(tmp_path):
    with running(tmp_path, 1) as own, opened(own.address) as engine:
        own.add_worker(threads=2)
        own.wait_for(2)
        with pytest.raises(InputError, match=r"has 2 threads, and should have one"):
            list(engine.spread(say_where, [(str(tmp_path), 0.1)] * 30))


def test_a_cluster_that_is_not_there_is_told_in_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr("hotlap.system.cluster.TIMEOUT", 0.5)
    with pytest.raises(InputError, match=r"cluster: there is no scheduler at tcp://127\.0\.0\.1:9") as raised, opened("tcp://127.0.0.1:9"):
        pass
    assert "\n" not in str(raised.value)
    with pytest.raises(InputError, match="No such file"), opened(str(tmp_path / "scheduler.json")):
        pass
    (tmp_path / "other.json").write_text("[]")
    with pytest.raises(InputError, match="is not the file of a scheduler"), opened(str(tmp_path / "other.json")):
        pass


def test_without_the_extra_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"needs dask.distributed: pip install 'hotlap\[cluster\]'"), opened("tcp://127.0.0.1:9"):
        pass


def test_a_worker_does_nothing_for_another_installation():
    results, error = unpack(do(pack(square, 3, ()), "another"))
    assert results == []
    assert "another installation" in str(error)
    assert unpack(do(pack(square, 3, ()), fingerprint())) == ([9, -3], None)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_worker_does_nothing_on_more_than_one_thread(monkeypatch, threads):
    monkeypatch.setattr(distributed, "get_worker", lambda: SimpleNamespace(state=SimpleNamespace(nthreads=threads)))
    results, error = unpack(do(pack(square, 3, ()), fingerprint()))
    assert results == ([9, -3] if threads == 1 else [])
    assert error is None if threads == 1 else f"has {threads} threads, and should have one" in str(error)


def test_a_fingerprint_knows_code_and_libraries_and_forgives_the_processor(monkeypatch):
    mine, before = installation(), fingerprint()
    monkeypatch.setattr(cluster_worker, "installation", lambda: {**mine, "processor": "another"})
    assert fingerprint() == before
    for what in mine:
        if what != "processor":
            monkeypatch.setattr(cluster_worker, "installation", lambda what=what: {**mine, what: "another"})
            assert fingerprint() != before


def test_what_cannot_be_sent_is_told_in_one_line():
    with pytest.raises(HotlapError, match="cannot be sent to a worker"):
        pack(lambda piece: [piece], 1, ())


@pytest.mark.parametrize(("jobs", "cluster"), [(-1, None), (2, "tcp://127.0.0.1:9")])
def test_numbers_of_processes_that_make_no_sense_are_refused(jobs, cluster):
    with pytest.raises(InputError, match="jobs"):
        check_jobs(jobs, cluster)


def test_without_a_cluster_the_engine_is_processes_of_this_machine():
    with engine.opened(None, 3) as found:
        assert found.workers == 3
        assert isinstance(found, Processes)

"""`hotlap watch`: a real server, asked by a real client."""

from __future__ import annotations

import http.client
import json
import re
import shutil
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import pytest

PROGRAM = [sys.executable, str(Path(__file__).parent / "fake_hotlap.py")]
SLOW = ("tune", "straight.toml", "--goal", "none", "--budget", "400", "--tuner", "random_search", "--batch", "4", "--validation", "0")

pytestmark = pytest.mark.usefixtures("faked")


@contextmanager
def watching(environment, *arguments):
    """A server of its own, and its address."""
    process = subprocess.Popen(
        [*PROGRAM, "watch", *arguments, "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    )
    try:
        assert process.stdout is not None
        said = "".join(iter(process.stdout.readline, "}\n")) + "}"
        yield process, urlsplit(json.loads(said)["address"])
    finally:
        process.kill()
        process.communicate()


def ask(address, path, method="GET", **headers):
    """One request; returns the answer and its content."""
    connection = http.client.HTTPConnection(address.hostname, address.port, timeout=30)
    try:
        connection.request(method, path, headers=headers)
        answer = connection.getresponse()
        return answer, answer.read().decode()
    finally:
        connection.close()


@pytest.fixture
def finished(faked, hotlap):  # noqa: ARG001  the fakes come first
    assert hotlap("tune", "straight.toml", "--seed", "1", "--validation", "50", "--out", "mine").code == 0
    return "mine"


def test_a_finished_study_is_served_and_nothing_is_new(finished, environment):
    with watching(environment, finished) as (_, address):
        answer, page = ask(address, "/")
        assert answer.status == 200
        assert re.search(r"<title>straight: gate_gp:default - hotlap</title>", page)
        found = re.search(r'type="application/json">(.*?)</script>', page, re.DOTALL)
        assert found
        document = json.loads(found[1])
        assert (document["live"], document["headline"]["state"]) == (True, "finished")
        flights = document["flights"]["number"]["shape"][0]
        assert ask(address, f"/data.json?flights={flights}")[0].status == 204
        answer, news = ask(address, f"/data.json?flights={flights - 1}")
        assert (answer.status, json.loads(news)) == (200, document)


def test_a_page_may_only_run_its_own_script_and_ask_its_own_server(finished, environment):
    with watching(environment, finished) as (_, address):
        for path in ("/", "/data.json", "/nothing"):
            headers = ask(address, path)[0].headers
            policy = headers["Content-Security-Policy"]
            assert policy.startswith("default-src 'none'; script-src '")
            assert "connect-src 'self'" in policy
            assert "unsafe-inline" not in policy.partition("style-src")[0]
            assert (headers["Cache-Control"], headers["X-Content-Type-Options"]) == ("no-store", "nosniff")
            assert headers["Server"] == "hotlap "


@pytest.mark.check
def test_a_folder_of_studies_is_one_page_and_each_has_its_own_below(finished, hotlap, here, environment):
    assert hotlap("tune", "straight.toml", "--validation", "50", "--out", "runs/one").code == 0
    shutil.copytree(here / finished, here / "runs" / "two")
    with watching(environment, "runs") as (process, address):
        answer, page = ask(address, "/")
        assert (answer.status, re.findall(r'href="([^"]*)"', page)) == (200, ["study/one/", "study/two/"])
        assert "connect-src 'self'" in answer.headers["Content-Security-Policy"]
        version = int(re.findall(r'data-version="(\d+)"', page)[0])
        assert ask(address, f"/data.json?flights={version}")[0].status == 204
        assert {row["name"] for row in json.loads(ask(address, "/data.json")[1])["rows"]} == {"one", "two"}
        for name in ("one", "two"):
            answer, page = ask(address, f"/study/{name}/")
            assert (answer.status, "<title>straight: gate_gp:default - hotlap</title>" in page) == (200, True)
            assert ask(address, f"/study/{name}/data.json")[0].status == 200
        assert ask(address, "/study/three/")[0].status == 404
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=30)
        assert process.returncode == 0
        assert f"runs are shown at http://127.0.0.1:{address.port}/ until Ctrl-C" in err.splitlines()


def test_a_folder_of_studies_is_read_only(finished, here, environment):
    (here / "runs").mkdir()
    shutil.move(here / finished, here / "runs" / "one")
    before = {path: path.read_bytes() for path in (here / "runs" / "one").iterdir()}
    with watching(environment, "runs") as (_, address):
        for path in ("/", "/data.json", "/study/one/"):
            ask(address, path)
    assert {path: path.read_bytes() for path in (here / "runs" / "one").iterdir()} == before


def test_there_is_nothing_else(finished, environment):
    with watching(environment, finished) as (_, address):
        for path in ("/nothing", "/study.sqlite", "/../straight.toml", "//etc/passwd", "/data.json/x"):
            assert ask(address, path)[0].status == 404, path


def test_other_hosts_methods_and_numbers_are_refused(finished, environment):
    with watching(environment, finished) as (_, address):
        for host in ("evil.example", f"evil.example:{address.port}", "127.0.0.1", "127.0.0.1:1", ""):
            answer, said = ask(address, "/", Host=host)
            assert (answer.status, "straight" in said) == (403, False), host
        for host in ("localhost", "127.0.0.1", "[::1]", "LOCALHOST"):
            assert ask(address, "/data.json?flights=1", Host=f"{host}:{address.port}")[0].status == 200, host
        for method in ("POST", "PUT", "DELETE", "PATCH", "OPTIONS"):
            answer, said = ask(address, "/", method)
            assert answer.status in {405, 501}, method
            assert (answer.headers["Content-Type"], said.count("\n")) == ("text/plain; charset=utf-8", 1), method
            assert answer.headers["X-Content-Type-Options"] == "nosniff", method
        answer, said = ask(address, "/", "HEAD")
        assert (answer.status, said) == (200, "")
        assert int(answer.headers["Content-Length"]) > 1000
        for number in ("x", "1e9", "99999999999999999999", "%00"):
            assert ask(address, f"/data.json?flights={number}")[0].status == 400, number


@pytest.mark.check
def test_it_follows_a_study_from_before_its_first_flight(here, environment):
    tuning = subprocess.Popen(
        [*PROGRAM, *SLOW, "--out", "mine"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**environment, "FAKE_PAUSE": "0.1"},
    )
    assert tuning.stderr is not None
    assert "flying\n" in tuning.stderr  # the study is there, its first batch is not
    try:
        with watching(environment, "mine") as (_, address):
            known, seen = -1, []
            while len(seen) < 3:
                answer, news = ask(address, f"/data.json?flights={known}")
                if answer.status == 200:
                    document = json.loads(news)
                    known = document["flights"]["number"]["shape"][0]
                    seen.append(known)
                    assert document["headline"]["state"] == "running"
                    assert document["sensitivity"] is None
            assert seen == sorted(set(seen))
    finally:
        tuning.kill()
        tuning.communicate()
    assert here.exists()


def test_the_flights_that_are_shown_are_flown_again_only_when_the_best_changes(finished, environment):
    with watching({**environment, "FAKE_PAUSE": "0.01"}, finished) as (process, address):
        for _ in range(4):
            ask(address, "/data.json")
        once = 2  # demonstration and sensitivity
        process.kill()
        assert process.stderr is not None
        assert process.stderr.read().count("flying\n") == once


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 0), (signal.SIGTERM, 143)])
def test_ctrl_c_is_how_it_ends(finished, environment, number, code):
    with watching(environment, finished) as (process, address):
        ask(address, "/")
        process.send_signal(number)
        _, err = process.communicate(timeout=30)
        assert process.returncode == code
        lines = err.splitlines()
        assert lines[-1 if code == 0 else -2] == f"mine is shown at http://127.0.0.1:{address.port}/ until Ctrl-C"


def test_nothing_is_written(finished, here, environment):
    before = {path: path.read_bytes() for path in (here / "mine").iterdir()}
    with watching(environment, finished) as (_, address):
        ask(address, "/")
    assert {path: path.read_bytes() for path in (here / "mine").iterdir()} == before


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("missing", "missing: holds no study (study.sqlite)"),
        ("cache", "cache: holds no study (study.sqlite)"),
        ("mine --port 65536", "--port: must be from 0 to 65535, not 65536"),
        ("mine --port -1", "--port: must be from 0 to 65535, not -1"),
        ("mine --port x", "--port: must be a whole number, not 'x'"),
        ("mine --host no.such.host.invalid", "--host: 'no.such.host.invalid' cannot be found: "),
        ("mine --host 192.0.2.1", "--port: 0 on 192.0.2.1 cannot be listened on: "),
    ],
)
@pytest.mark.usefixtures("finished")
def test_bad_input_is_one_clear_line(hotlap, words, said):
    ran = hotlap("watch", *words.split())
    assert (ran.code, ran.out) == (2, "")
    last = ran.err.splitlines()[-1]
    assert last.startswith(f"hotlap: {said}"), ran.err


@pytest.mark.usefixtures("finished")
def test_a_port_that_is_taken_is_one_clear_line(hotlap):
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        ran = hotlap("watch", "mine", "--port", str(port))
    assert ran.code == 2
    assert ran.err.splitlines()[-1] == f"hotlap: --port: {port} on 127.0.0.1 cannot be listened on: Address already in use"

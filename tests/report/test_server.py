"""The server answers those who mean it, refuses those who were led here by another name, and keeps quiet about those who leave."""

from __future__ import annotations

import resource
import socket
import threading
from contextlib import ExitStack, contextmanager, suppress

import pytest

from hotlap.report.connections import most_at_once
from hotlap.report.server import Server


class Big:
    """A page that takes longer to send than a browser may stay."""

    def page(self):
        return "<p>" + 30_000_000 * "x"

    def news(self, known=-1):
        return None if known == 7 else "{}"


@contextmanager
def serving(host="127.0.0.1", below=lambda _: None):
    with Server(Big(), host, 0, below) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


def get(server, path, *hosts):
    """Status of the answer to a request that no client checks before it is sent."""
    named = "".join(f"Host: {host}\r\n" for host in hosts or [f"127.0.0.1:{server.server_port}"])
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=30) as client:
        client.sendall(f"GET {path} HTTP/1.1\r\n{named}\r\n".encode())
        said = client.makefile("rb").read()
    return int(said.split()[1]) if said else None


def test_a_browser_that_leaves_before_it_has_the_page_is_no_error(capfd):
    with serving() as server:
        before = threading.active_count()
        with socket.create_connection(("127.0.0.1", server.server_port)) as browser:
            browser.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{server.server_port}\r\n\r\n".encode())
            browser.recv(100)
        while threading.active_count() > before:  # it is still being answered
            pass
        assert get(server, "/data.json?flights=7") == 204
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    ("files", "most"), [(16, 8), (256, 128), (1024, 512), (1_048_576, 512), (resource.RLIM_INFINITY, 512), (0, 1), (1, 1)]
)
def test_connections_leave_half_of_the_files_that_a_process_may_open(monkeypatch, files, most):
    monkeypatch.setattr(resource, "getrlimit", lambda _: (files, files))
    assert most_at_once() == most


def test_browsers_that_ask_nothing_leave_room_for_one_that_does(monkeypatch):
    monkeypatch.setattr(resource, "getrlimit", lambda _: (16, 16))
    with serving() as server, ExitStack() as idle:
        for _ in range(20):
            idle.enter_context(socket.create_connection(("127.0.0.1", server.server_port)))
        assert get(server, "/data.json?flights=7") == 204
        assert len(server._connections) <= 8


@pytest.mark.parametrize("path", ["//[", "//[x]/", "http://[/", "http:///x"])
def test_a_path_that_is_no_address_is_not_there(path, capfd):
    with serving() as server:
        assert get(server, path) == 404
    assert capfd.readouterr().err == ""


def test_only_one_host_may_be_asked_for_and_a_whole_address_names_its_host_too():
    with serving() as server:
        here = f"127.0.0.1:{server.server_port}"
        assert get(server, "/x", here) == get(server, f"http://{here}/x", here) == 404
        for path, hosts in (("/x", (here, here)), ("/x", (here, "evil.example")), ("http://evil.example/x", (here,)), ("/x", ("",))):
            assert get(server, path, *hosts) == 403, (path, hosts)


def test_two_hundred_browsers_that_say_nothing_keep_nobody_from_the_page():
    with serving() as server, ExitStack() as silent:
        for _ in range(200):
            silent.enter_context(socket.create_connection(("127.0.0.1", server.server_port), timeout=30))
        assert get(server, "/data.json?flights=7") == 204


def test_a_browser_that_sends_a_byte_at_a_time_is_cut_off(monkeypatch):
    monkeypatch.setattr("hotlap.report.server.LONGEST", 0.3)
    with serving() as server, socket.create_connection(("127.0.0.1", server.server_port), timeout=0.1) as client:
        said = None
        with suppress(ConnectionError):
            while said is None:
                client.sendall(b"G")
                with suppress(TimeoutError):
                    said = client.recv(1)
        assert not said


def test_pages_of_studies_lie_below_by_their_names_and_no_other_name_leads_anywhere():
    asked = []

    def below(name):
        asked.append(name)
        return Big() if name == "a/b c" else None

    with serving(below=below) as server:
        assert get(server, "/study/a/b%20c/data.json?flights=7") == 204
        assert get(server, "/study/a/b%20c/data.json?flights=x") == 400
        for path in ("/study/", "/study//", "/study/a/", "/study/a/b%20c", "/study/a/b%20c/x", "/study/../data.json", "/study/%2e%2e/"):
            assert get(server, path) == 404, path
    assert set(asked) <= {"a/b c", "a", "a/b c/x", "..", "/"}
    with serving() as server:
        assert get(server, "/study/a/b%20c/data.json?flights=7") == 404


def test_a_browser_leaves_out_the_port_of_the_web():
    with Server(Big(), "127.0.0.1", 0) as server:
        assert not server.knows("127.0.0.1")
        server.server_port = 80
        assert server.knows("127.0.0.1")
        assert server.knows("localhost")
        assert server.knows("localhost:80")
        assert not server.knows("evil.example")


@pytest.mark.parametrize(("host", "others"), [("0.0.0.0", True), ("::", True), ("127.0.0.1", False)])  # noqa: S104  what is tested
def test_who_listens_everywhere_is_known_by_any_number_but_by_no_other_name(host, others):
    with Server(Big(), host, 0) as server:
        port = server.server_port
        for address in ("192.0.2.7", "[2001:db8::1]"):
            assert server.knows(f"{address}:{port}") is others
            assert not server.knows(f"{address}:{port + 1}")
        for name in ("evil.example", "[::1%evil.example]", "192.0.2.7.evil.example", "192.0.2", "", "[::1", "2001:db8::1"):
            assert not server.knows(f"{name}:{port}")
        assert server.knows(f"localhost:{port}")

"""Server: serves a page and its updates to browsers, and pages of studies below it, by default on this machine only; it writes nothing."""

from __future__ import annotations

import base64
import hashlib
import ipaddress
import re
import socket
import socketserver
import sys
from collections.abc import Callable, Iterable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Protocol
from urllib.parse import parse_qs, unquote, urlsplit

from hotlap.core.errors import HotlapError, InputError
from hotlap.report.connections import Connections, most_at_once

LOCAL = ("localhost", "127.0.0.1", "[::1]")
PATIENCE = 20.0  # s between two signs of life of a browser
LONGEST = 60.0  # s until it must have its answer, however slow it is
WAITING = 512  # browsers that wait to be let in
HTML, JSON, PLAIN = "text/html; charset=utf-8", "application/json; charset=utf-8", "text/plain; charset=utf-8"
_SCRIPT = re.compile(r"<script(?![^>]*application/json)[^>]*>(.*?)</script>", re.DOTALL)
_BELOW = re.compile(r"/study/(.+?)(/|/data\.json)")
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class Source(Protocol):
    """The page that is served."""

    def page(self) -> str:
        """The whole page as HTML."""
        ...

    def news(self, known: int = -1) -> str | None:
        """The document of the page as JSON; None where the page has all `known` flights already."""
        ...


class Server(ThreadingHTTPServer):
    """An HTTP server that listens from its construction on; `serve_forever` answers.

    Args:
        source: the page that is served.
        host: name or address to listen on.
        port: 0 for any that is free.
        below: the page of a study by its name, served at `/study/NAME/`; None where there is none.

    Raises:
        InputError: there is no such host, or it cannot be listened on.
    """

    daemon_threads = True
    request_queue_size = WAITING

    def __init__(self, source: Source, host: str, port: int, below: Callable[[str], Source | None] = lambda _: None) -> None:
        self.source, self._host, self._below = source, host, below
        self._connections = Connections(most_at_once(), LONGEST)
        self.address_family, place = _find(host, port)
        try:
            super().__init__(place, Answer)
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise InputError("", "port", f"{port} on {host} cannot be listened on: {reason}") from None

    def server_bind(self) -> None:
        """Bind without a look-up of the host's name, which can take seconds."""
        socketserver.TCPServer.server_bind(self)
        self.server_name, self.server_port = self._host, self.server_address[1]

    @property
    def address(self) -> str:
        """The URL for a browser."""
        return f"http://{_bracketed(self._host)}:{self.server_port}/"

    def knows(self, name: str) -> bool:
        """Whether the host that a browser asked for is this one; other names are refused (DNS rebinding).

        A server that listens on all addresses accepts every numeric address: no name of another site can lead to a number.
        """
        host, colon, port = name.lower().rpartition(":") if re.search(r":\d+$", name, re.ASCII) else (name.lower(), "", "")
        if (port if colon else "80") != str(self.server_port):  # of the web, browsers leave it out
            return False
        everywhere = ipaddress.ip_address(str(self.server_address[0])).is_unspecified
        return host in {*LOCAL, _bracketed(self._host).lower()} or (everywhere and _is_number(host))

    def find(self, path: str) -> tuple[Source, str] | None:
        """The page that a path belongs to, and the path within it; None where there is no such page."""
        inner = _BELOW.fullmatch(path)
        if inner is None:
            return self.source, path
        found = self._below(unquote(inner[1]))
        return None if found is None else (found, inner[2])

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer in a thread; the oldest connection makes way where there are too many."""
        self._connections.add(request)
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """Close a connection."""
        self._connections.remove(request)
        super().shutdown_request(request)

    def service_actions(self) -> None:
        """Cut off who is too slow; called twice a second."""
        self._connections.expire()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Report errors of our own; a browser that closes the connection early is no error."""
        if not isinstance(sys.exception(), ConnectionError | TimeoutError):
            super().handle_error(request, client_address)


class Answer(BaseHTTPRequestHandler):
    """Answers one request: `/` or `/data.json?flights=N`, or the same below `/study/NAME`."""

    server: Server  # pyright: ignore[reportIncompatibleVariableOverride]  the only one that makes it
    server_version, sys_version, timeout = "hotlap", "", PATIENCE

    def do_GET(self) -> None:
        """Send the page or its update."""
        self._answer()

    def do_HEAD(self) -> None:
        """Send the headers alone."""
        self._answer()

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:  # noqa: ARG002  its signature
        """Refuse a bad request in one line, with the usual headers."""
        status = HTTPStatus(code)
        self._send(status, PLAIN, f"{message or status.phrase}\n")

    def log_message(self, *_: Any, **__: Any) -> None:
        """Log nothing."""

    def _answer(self) -> None:
        try:
            asked = urlsplit(self.path)
        except ValueError:  # brackets that do not match
            asked = urlsplit("")
        hosts = [*self.headers.get_all("Host", []), *([asked.netloc] if asked.netloc else [])]  # a whole address names its host, too
        if len(self.headers.get_all("Host", [])) != 1 or not all(map(self.server.knows, hosts)):
            self._send(HTTPStatus.FORBIDDEN, PLAIN, "this is not the host that you asked for\n")
            return
        try:
            source, path = self.server.find(asked.path) or (self.server.source, "")
            if path == "/":
                self._send(HTTPStatus.OK, HTML, source.page())
            elif path == "/data.json":
                self._send_news(source, parse_qs(asked.query).get("flights", ["-1"])[0])
            else:
                self._send(HTTPStatus.NOT_FOUND, PLAIN, "there is nothing here but / and /data.json\n")
        except HotlapError as error:
            self._send(HTTPStatus.SERVICE_UNAVAILABLE, PLAIN, f"{error}\n")

    def _send_news(self, source: Source, known: str) -> None:
        """Send the document to a page with `known` flights, or nothing where it is up to date."""
        if not re.fullmatch(r"-?\d{1,9}", known):
            self._send(HTTPStatus.BAD_REQUEST, PLAIN, "flights must be a whole number\n")
            return
        news = source.news(int(known))
        self._send(HTTPStatus.NO_CONTENT if news is None else HTTPStatus.OK, JSON, news or "")

    def _send(self, status: HTTPStatus, kind: str, text: str) -> None:
        """Send an answer with its headers."""
        content = text.encode()
        self.send_response(status)
        for name, value in _HEADERS.items():
            self.send_header(name, value)
        self.send_header("Content-Security-Policy", policy(_SCRIPT.findall(text) if kind == HTML else ()))
        if status is not HTTPStatus.NO_CONTENT:
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)


def policy(scripts: Iterable[str]) -> str:
    """The content security policy: only the scripts in the page, known by their hashes, and requests to this server."""
    digests = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts]
    allowed = " ".join(f"'sha256-{digest}'" for digest in digests) or "'none'"
    parts = ("default-src 'none'", f"script-src {allowed}", "style-src 'unsafe-inline'", "img-src data: blob:", "connect-src 'self'")
    return "; ".join((*parts, "base-uri 'none'", "form-action 'none'", "frame-ancestors 'none'"))


def _find(host: str, port: int) -> tuple[socket.AddressFamily, tuple[str, int]]:
    """Address family and address of a host."""
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no name of a host"
        raise InputError("", "host", f"'{host}' cannot be found: {reason}") from None
    return family, (str(address[0]), port)


def _bracketed(host: str) -> str:
    """A host as it is written in a URL."""
    return f"[{host}]" if ":" in host else host


def _is_number(host: str) -> bool:
    """Whether a host in a URL is a numeric address; one with a zone is none, since its zone may be any text."""
    try:
        return "%" not in host and host == _bracketed(str(ipaddress.ip_address(host.removeprefix("[").removesuffix("]"))))
    except ValueError:
        return False

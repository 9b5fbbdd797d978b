"""The live page on this machine: a small HTTP server with a secret in its address.

Only 127.0.0.1 is listened to. A request must come to a host name of this machine (a page of another site that resolves
its own name to 127.0.0.1 fails here), from the page's own origin, to the address with the token, as JSON of a limited
size. The page may load nothing from elsewhere. One computation runs at a time; a request for a run is given up if its
page requests another one, or asks to stop. Each invalid request gets a status from 400.
"""

from __future__ import annotations

import hmac
import json
import secrets
import sys
import threading
from collections import Counter
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import SplitResult, urlsplit

from linkages.input.files.writing import json_text
from linkages.show.live.answers import Answers, front_end, page_of

HOST = "127.0.0.1"
_OWN_NAMES = ("127.0.0.1", "localhost")
_LARGEST = 1 << 20  # of a request [bytes]
_SLOW = 30.0  # longest wait for a request to arrive [s]

_INVALID = SplitResult("", "", "", "", "")

_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}


class LiveServer(ThreadingHTTPServer):
    """Serves the live page of one session; port 0 takes a free one.

    `hosts` are further allowed host names of requests, for example behind a proxy.
    """

    daemon_threads = True
    request_queue_size = 128

    def __init__(self, answers: Answers, port: int = 0, hosts: tuple[str, ...] = ()) -> None:
        super().__init__((HOST, port), _Handler)
        self.answers, self.hosts = answers, (*_OWN_NAMES, *hosts)
        self.token = secrets.token_urlsafe(24)
        self.said = ""  # stage of the computation
        self._computing = threading.Lock()
        self._counting = threading.Lock()
        self._latest: Counter[str] = Counter()  # requests for runs by page

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of a browser that has closed its connection; raise anything else."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)

    @property
    def address(self) -> str:
        """Address of the page, with its token."""
        return f"http://{HOST}:{self.server_address[1]}/{self.token}/"

    def answer(self, kind: str, request: Any) -> dict[str, Any]:
        """Answer a request; the runs of a page are counted, and only the latest one is computed."""
        if kind == "status":
            return {"said": self.said}
        page = page_of(request)
        with self._counting:
            self._latest[page] += kind in ("run", "stop")
            mine = self._latest[page]
        if kind == "stop":
            return {}

        def outdated() -> bool:
            return kind == "run" and mine != self._latest[page]

        with self._computing:
            if outdated():
                return {"outdated": True}
            return self.answers.answer(kind, request, outdated)


class _Handler(BaseHTTPRequestHandler):
    """Checks a request, and answers it."""

    server: LiveServer
    server_version = "linkages"
    sys_version = ""
    timeout = _SLOW

    def do_GET(self) -> None:
        """Send the page, its style or its script."""
        kinds = {"page.html": "text/html", "live.css": "text/css", "live.js": "text/javascript"}
        name = self._checked()
        if name is None:
            return
        file = name or "page.html"
        if name == "page.html" or file not in kinds:
            self._refuse(HTTPStatus.NOT_FOUND)
            return
        self._send(HTTPStatus.OK, front_end(file).encode(), f"{kinds[file]}; charset=utf-8")

    def do_POST(self) -> None:
        """Answer a request of the page."""
        name = self._checked()
        if name is None:
            return
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal():
            self._refuse(HTTPStatus.LENGTH_REQUIRED)
        elif float(length) > _LARGEST:  # int() refuses thousands of digits
            self._refuse(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
        elif self.headers.get_content_type() != "application/json":
            self._refuse(HTTPStatus.UNSUPPORTED_MEDIA_TYPE)
        else:
            try:
                request = json.loads(self.rfile.read(int(float(length))))
            except TimeoutError:
                self._refuse(HTTPStatus.REQUEST_TIMEOUT)
                return
            except (ValueError, RecursionError):
                self._refuse(HTTPStatus.BAD_REQUEST)
                return
            found = json_text(self.server.answer(name, request)).encode()
            self._send(HTTPStatus.OK, found, "application/json")

    def _checked(self) -> str | None:
        """Return the part of the address behind the token; None after the refusal of a request."""
        host = self.headers.get("Host", "")
        origin = self.headers.get("Origin")
        address = _split(self.path)
        token, _, name = address.path.removeprefix("/").partition("/")
        if address == _INVALID:
            self._refuse(HTTPStatus.BAD_REQUEST)
        elif _split(f"//{host}").hostname not in self.server.hosts or (
            origin is not None and _split(origin).netloc != host
        ):
            self._refuse(HTTPStatus.FORBIDDEN)
        elif not hmac.compare_digest(token.encode(), self.server.token.encode()):
            self._refuse(HTTPStatus.NOT_FOUND)
        else:
            return name
        return None

    def _refuse(self, status: HTTPStatus) -> None:
        self.close_connection = True
        self._send(status, f"{status.value} {status.phrase}\n".encode(), "text/plain; charset=utf-8")

    def _send(self, status: HTTPStatus, content: bytes, kind: str) -> None:
        self.send_response(status)
        for header, value in (*_HEADERS.items(), ("Content-Type", kind), ("Content-Length", str(len(content)))):
            self.send_header(header, value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    def send_response_only(self, code: int, message: str | None = None) -> None:
        """Send the status, which HTTP 0.9 lacks."""
        self.request_version = "HTTP/1.0"
        super().send_response_only(code, message)

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing of single requests."""


def _split(address: str) -> SplitResult:
    """Split an address of a request; `_INVALID` if it is none."""
    try:
        return urlsplit(address)
    except ValueError:
        return _INVALID

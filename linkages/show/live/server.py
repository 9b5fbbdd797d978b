"""The live page on this machine: a small HTTP server with a secret in its address, and the protocol of the page.

Only 127.0.0.1 is listened to. A request must come to a host name of this machine (a page of another site that resolves
its own name to 127.0.0.1 fails here), from the page's own origin, to the address with the token, as JSON of a limited
size. The page may load nothing from elsewhere. One computation runs at a time. Each invalid request gets a status from
400.

The page sends ``POST KIND`` with a JSON table, and gets one:

| kind          | request                        | reply                                                               |
|---------------|--------------------------------|---------------------------------------------------------------------|
| start         | values                         | `title`, `file`, `name`, `folder`, `units`, `controls`, `parts`     |
| run           | values, restart, refine        | the view, see below                                                 |
| picture       | values                         | `svg`, its place, `joints`, `bodies`, `poses`                       |
| numbers       |                                | `motion` (lines) and `table` of the run that was shown last         |
| warnings      |                                | `warnings`: `text`, `remedies`, each with `label` and `values`      |
| edit          | values, part, name, model      | `values`, `controls`: a joint or link with another model            |
| edit          | values, name, add              | the same: a joint with a further "groove" or "wear"                 |
| move          | values, joint, to, phase       | `values`: the pin of a joint at a place [m] of the picture          |
| sweep         | values, path, low, high, count | `values` (n) of the path, `peaks` (n) by output, None: no run       |
| sensitivities | values, paths                  | `peaks` by output; `changes` [1] by path and output, see below      |
| tolerances    | values, spreads, runs          | `time`, `bands` and `peaks` by output, see below                    |
| notebook      | values, name, replace          | `code`; the notebook that was `written`, if there is a name         |
| report        | values, runs, notes, units     | `page`: a page of pinned runs (`name`, `values`, `peaks` by output) |
| save          | values, name, replace          | `written`, and the `command` that runs the file                     |
| export        | values, name, replace          | the folder that was written by ``linkages simulate``, its `command` |
| status        |                                | `said`: the present stage                                           |
| stop          |                                | nothing; a computation of the page ends within 50 ms                |

- Each request can name its page by a text `page`: runs, numbers and warnings of pages are independent. A request that
  cannot be answered gets ``{"error": TEXT}``. A run, a sweep, sensitivities or tolerances get ``{"outdated": true}`` as
  soon as the page requests a newer one of them, or stop; it need not wait for the reply before it sends the newer one.
- `values` are everything that the page has changed: numbers (SI units) and texts by dotted path, to which an edit or a
  moved pin only adds. So undo, a link, save and export need nothing else. A control (`Control`) whose `value` is None
  is of a key that the file does not have: it is shown while `values` have its path. ``start`` with the values of a link
  has the controls for them.
- `parts` are `joints` (`name`, `type`, `driven`, `model`, `models` that an edit can choose) and `links` (`name`,
  `model`, `models`); `units` are systems of units, see `linkages.show.live.units`.
- A view has `status`, `remedy`, `periodic`, `settled`, `from`, `to`, `time`, `curves`, `orbits`, `poses`, `numbers`,
  `ran`, `picture`, `took`. A run that takes longer than 0.5 s is repeated coarsely: `coarse` is true, and the page asks
  again with `refine` for the run in full, unless its values have changed. A design that locks is not run: its `status`
  is "locked", `poses` and `curves` show the ideal linkage until then, and `locked` is the time [s]. Loops that
  cannot be closed at all are an error, and the picture has them open.
- `to` is a place [x, y] in plane axes; `phase`, 0 to 1, is the time of the shown poses. The lengths of both links of
  the pin change such that the loops stay closed there, see `linkages.show.live.pins`.
- `changes` are relative changes of a peak for a relative change of a value, d log(peak) / d log(value).
- `spreads` are standard deviations by path, as parts of the value, by default a third of 1 % of each number that is
  shown at first, without drives; `bands` have the curves' 5 %, 50 % and 95 % quantiles over `time`, `peaks` have
  their `mean`, `deviation` and `quantiles`.
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
from linkages.show.live.answers import MODULES, Answers, front_end, page_of

HOST = "127.0.0.1"
_OWN_NAMES = ("127.0.0.1", "localhost")
_LARGEST = 1 << 20  # of a request [bytes]
_SLOW = 30.0  # longest wait for a request to arrive [s]

_LONG = ("run", "sweep", "sensitivities", "tolerances")  # kinds that a newer request of them ends
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
        """Answer a request; the computations of a page are counted, and only the latest is made."""
        if kind == "status":
            return {"said": self.answers.said or self.said}
        page = page_of(request)
        with self._counting:
            self._latest[page] += kind in _LONG or kind == "stop"
            mine = self._latest[page]
        if kind == "stop":
            return {}
        if kind == "warnings":  # some take long, and no run waits for them
            return self.answers.answer(kind, request)

        def outdated() -> bool:
            return kind in _LONG and mine != self._latest[page]

        with self._computing:
            if outdated():
                return {"outdated": True}
            return self.answers.answer(kind, request, outdated)


class _Handler(BaseHTTPRequestHandler):
    server: LiveServer
    server_version = "linkages"
    sys_version = ""
    timeout = _SLOW

    def do_GET(self) -> None:
        kinds = {"page.html": "text/html", "live.css": "text/css"} | dict.fromkeys(MODULES, "text/javascript")
        name = self._checked()
        if name is None:
            return
        file = name or "page.html"
        if name == "page.html" or file not in kinds:
            self._refuse(HTTPStatus.NOT_FOUND)
            return
        self._send(HTTPStatus.OK, front_end(file).encode(), f"{kinds[file]}; charset=utf-8")

    def do_POST(self) -> None:
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

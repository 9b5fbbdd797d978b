"""The server of the live page accepts requests of its page only."""

import http.client
import json
import os
import re
import select
import signal
import socket
import threading
from collections import Counter

import pytest
from processes import child, start

import linkages
import linkages.show.live.session
from linkages.cli import progress
from linkages.cli.main import main
from linkages.show.live.server import LiveServer, _Handler
from linkages.show.live.watch import Watch


def ask(server, method="POST", path=None, body=b'{"values": {}}', headers=None):
    """Send one request; returns status, headers and body."""
    connection = http.client.HTTPConnection(*server.server_address, timeout=600)
    given = {"Content-Type": "application/json"} | (headers or {})
    connection.request(method, f"/{server.token}/run" if path is None else path, body, given)
    reply = connection.getresponse()
    found = reply.status, dict(reply.getheaders()), reply.read()
    connection.close()
    return found


def test_the_page_loads_nothing_from_elsewhere(serve):
    server = serve()
    for name, kind in (("", "text/html"), ("live.js", "text/javascript"), ("live.css", "text/css")):
        status, headers, body = ask(server, "GET", f"/{server.token}/{name}", None)
        assert (status, headers["Content-Type"].partition(";")[0]) == (200, kind)
        assert "default-src 'none'" in headers["Content-Security-Policy"]
        assert headers["Referrer-Policy"] == "no-referrer"
        assert b"http://" not in re.sub(rb"http://www\.w3\.org/\S+", b"", body)
        assert b"https://" not in body
    assert b"<script>" not in ask(server, "GET", f"/{server.token}/", None)[2]


def test_a_run_is_answered(serve):
    status, _, body = ask(serve())
    assert status == 200
    assert json.loads(body)["status"] == "ok"


@pytest.mark.parametrize(
    ("status", "changes"),
    [
        (404, {"path": "/run"}),
        (404, {"path": "/wrong-token/run"}),
        (404, {"method": "GET", "path": "/"}),
        (403, {"headers": {"Host": "attacker.example"}}),
        (403, {"headers": {"Host": "attacker.example:80"}}),
        (403, {"headers": {"Host": "[bad"}}),
        (403, {"headers": {"Origin": "https://attacker.example"}}),
        (403, {"headers": {"Origin": "http://127.0.0.1:1"}}),
        (403, {"headers": {"Origin": "null"}}),
        (415, {"headers": {"Content-Type": "text/plain"}}),
        (415, {"headers": {"Content-Type": "application/x-www-form-urlencoded"}}),
        (413, {"headers": {"Content-Length": str(1 << 30)}, "body": b""}),
        (411, {"headers": {"Content-Length": "-1"}, "body": b""}),
        (400, {"body": b"{"}),
        (400, {"body": b"[" * 100_000}),
        (501, {"method": "PUT"}),
    ],
)
def test_a_request_from_elsewhere_is_refused(serve, status, changes):
    server = serve()
    assert ask(server, **changes)[0] == status
    assert ask(server)[0] == 200  # the page continues


def send_raw(server, *lines, body=b""):
    """Send lines of a request as they are; returns the first line of the answer."""
    with socket.create_connection(server.server_address, timeout=60) as connection:
        connection.sendall(b"\r\n".join([*lines, b"", body]))
        with connection.makefile("rb") as answer:
            return answer.readline().decode().strip()


@pytest.mark.parametrize(
    ("status", "first", "headers"),
    [
        (400, b"GET http://[/ HTTP/1.1", []),
        (400, b"GET http://[/", []),
        (400, b"POST http://[::1/ HTTP/1.0", []),
        (400, b"GET http://a]b/ HTTP/0.9", []),
        (403, b"GET / HTTP/1.1", [b"Origin: http://["]),
        (403, b"GET / HTTP/1.1", [b"Origin: http://[::1"]),
        (413, b"POST /TOKEN/run HTTP/1.1", [b"Content-Length: " + b"9" * 5000]),
        (400, b"POST /TOKEN/run HTTP/1.1", [b"Content-Length: " + b"0" * 5000]),
        (400, b"POST /TOKEN/run HTTP/0.9", [b"Content-Length: 0"]),
        (404, b"GET /\xff\xfe HTTP/1.1", []),
    ],
)
def test_a_malformed_request_gets_a_status(serve, capfd, status, first, headers):
    """Not one of them prints a traceback, or closes the connection without an answer."""
    server = serve()
    host = b"Host: 127.0.0.1:%d" % server.server_address[1]
    first = first.replace(b"TOKEN", server.token.encode())
    answer = send_raw(server, first, host, b"Content-Type: application/json", *headers, b"")
    assert answer.split()[1] == str(status)
    assert not capfd.readouterr().err
    assert ask(server)[0] == 200


def test_a_request_that_does_not_arrive_is_refused_in_time(serve, monkeypatch):
    monkeypatch.setattr(_Handler, "timeout", 0.2)
    server = serve()
    head = [b"POST /%s/run HTTP/1.1" % server.token.encode(), b"Host: localhost", b"Content-Length: 9"]
    assert send_raw(server, *head, b"Content-Type: application/json", b"").split()[1] == "408"


def test_the_names_of_this_machine_are_its_own(serve):
    server = serve()
    port = server.server_address[1]
    for host in (f"127.0.0.1:{port}", f"localhost:{port}", "localhost:9999"):
        assert ask(server, headers={"Host": host, "Origin": f"http://{host}"})[0] == 200


def test_bad_requests_get_one_line(serve):
    server = serve()
    for kind, body in (
        ("run", b"[]"),
        ("run", b'{"values": {"a": 1}}'),
        ("nonsense", b"{}"),
        ("picture", b'{"values": 3}'),
    ):
        status, _, found = ask(server, path=f"/{server.token}/{kind}", body=body)
        assert status == 200
        assert "\n" not in json.loads(found)["error"]


@pytest.mark.processes
def test_a_hundred_requests_at_once_give_one_run_after_the_other(serve):
    """All come during a run: each is answered, all but the latest are skipped, and the latest is computed."""
    server, replies = serve(), [None] * 100
    ask(server)
    counted, count = threading.Semaphore(0), server._latest

    class Counted(Counter):
        def __setitem__(self, page, number):
            super().__setitem__(page, number)
            counted.release()

    server._latest = Counted(count)
    while counted.acquire(blocking=False):
        pass

    def send(k):
        body = json.dumps({"values": {"joints.A.viscosity": 0.3 + 0.001 * k}}).encode()
        replies[k] = json.loads(ask(server, body=body)[2])

    threads = [threading.Thread(target=send, args=(k,)) for k in range(100)]
    with server._computing:  # as during a run
        for thread in threads:
            thread.start()
        for _ in threads:
            assert counted.acquire(timeout=300.0)
    for thread in threads:
        thread.join()
    assert sum("outdated" in reply for reply in replies) == 99
    assert [reply["status"] for reply in replies if "status" in reply] == ["ok"]


@pytest.mark.processes
def test_pages_do_not_overtake_each_other(serve):
    """Each of five pages gets its own run and its own table, however their requests are mixed."""
    server, tables = serve(), {}

    def table(page, clearance):
        request = json.dumps({"page": page, "values": {"joints.A.clearance": clearance}}).encode()
        replies = [json.loads(ask(server, body=request)[2])]
        ready.wait()  # all pages have run
        request = json.dumps({"page": page}).encode()
        replies.append(json.loads(ask(server, path=f"/{server.token}/numbers", body=request)[2]))
        tables[page] = replies

    pages = {f"page {k}": 1e-4 * (1 + k) for k in range(5)}
    ready = threading.Barrier(len(pages), timeout=600)
    threads = [threading.Thread(target=table, args=given) for given in pages.items()]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for page, clearance in pages.items():
        alone = linkages.show.live.session.Session(linkages.load(linkages.find_file("seven_bar.toml")))
        alone.compute({"joints.A.clearance": clearance})
        assert tables[page][0]["status"] == "ok"
        assert tables[page][1] == json.loads(json.dumps(alone.numbers()))


@pytest.mark.processes
def test_a_page_stops_its_run_and_no_other(serve, monkeypatch):
    looks, check = threading.Semaphore(0), Watch._check

    def looked(watch):
        check(watch)
        looks.release()

    monkeypatch.setattr(Watch, "_check", looked)
    server = serve(linkages.load(linkages.find_file("slider_crank_dry.toml"), {"duration": 100.0}))
    replies = {}

    def run(page):
        replies[page] = json.loads(
            ask(server, body=json.dumps({"page": page, "values": {"duration": 1e3}}).encode())[2]
        )

    thread = threading.Thread(target=run, args=["mine"])
    thread.start()
    assert looks.acquire(timeout=300.0)  # it runs
    stop = f"/{server.token}/stop"
    ask(server, path=stop, body=b'{"page": "other"}')
    while looks.acquire(blocking=False):
        pass
    for _ in range(3):  # its run has looked after the request, and goes on
        assert looks.acquire(timeout=300.0)
    assert replies == {}
    ask(server, path=stop, body=b'{"page": "mine"}')
    thread.join(300.0)
    assert replies == {"mine": {"outdated": True}}


@pytest.mark.processes
def test_warnings_do_not_wait_for_a_run_nor_a_run_for_them(serve):
    server = serve()
    ask(server)
    with server._computing:  # as during a run
        found = json.loads(ask(server, path=f"/{server.token}/warnings")[2])
    assert set(found) == {"warnings"}


def test_names_with_markup_are_text(serve, system_of):
    sdf = linkages.find_file("seven_bar.sdf").read_text().replace("link2", "a&lt;script&gt;alert(1)&lt;/script&gt;")
    toml = linkages.find_file("seven_bar.toml").read_text().partition("\n\n")[2].partition("\n")[2]
    server = serve(system_of(sdf, toml))
    picture = json.loads(ask(server, path=f"/{server.token}/picture")[2])["svg"]
    assert "<script" not in picture
    assert "&lt;script" in picture


@pytest.fixture
def played(tmp_path):
    """Return the process of a command that serves an experiment into a folder, and connection and path of its page."""
    started = []

    def play(name):
        words = ["play", name, "--no-browser", "--out", tmp_path]
        started.append(served := start(*words, cwd=tmp_path, stderr=None))
        address = re.search(r"http://127\.0\.0\.1:(\d+)(/[\w-]+/)", served.stdout.readline())
        return served, http.client.HTTPConnection("127.0.0.1", int(address[1]), timeout=600), address[2]

    yield play
    for served in started:
        served.kill()
        served.communicate()


@pytest.mark.processes
def test_the_command_serves_until_ctrl_c(played, tmp_path):
    served, connection, path = played("seven_bar.toml")
    connection.request("GET", path)
    assert connection.getresponse().status == 200
    connection.close()
    served.send_signal(signal.SIGINT)
    assert served.wait(600) == 130
    assert not list(tmp_path.iterdir())


@pytest.mark.processes
@pytest.mark.skipif(not hasattr(os, "pidfd_open"), reason="waits for a process that another one has started")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_an_export_ends_with_the_command(played, tmp_path, number):
    """Whatever ends it: nothing is written but the part of the run that was computed."""
    served, connection, path = played("slider_crank_dry.toml")
    request = {"values": {"duration": 30.0}, "name": "long", "replace": False}
    connection.request("POST", f"{path}export", json.dumps(request), {"Content-Type": "application/json"})
    end = os.pidfd_open(child(served, "simulate"))
    served.send_signal(number)
    assert served.wait(600) == {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGKILL: -signal.SIGKILL}[number]
    assert select.select([end], [], [], 300.0)[0]
    os.close(end)
    connection.close()
    written = tmp_path / "long" / "summary.json"
    assert not written.exists() or json.loads(written.read_text())["status"] == "interrupted"


@pytest.mark.slow
@pytest.mark.processes
def test_an_export_that_is_not_interrupted_is_written(played, tmp_path):
    _, connection, path = played("seven_bar.toml")
    request = {"values": {"duration": 1e-3}, "name": "short", "replace": False}
    connection.request("POST", f"{path}export", json.dumps(request), {"Content-Type": "application/json"})
    assert json.loads(connection.getresponse().read())["written"] == str(tmp_path / "short")
    connection.close()
    assert json.loads((tmp_path / "short" / "summary.json").read_text())["status"] == "ok"


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--vary", "joints.A.clearanc=1:2"], "joints.A.clearanc"),
        (["--vary", "joints.A.clearance=2:1"], "--vary"),
        (["--port", "99999"], "--port"),
        (["--limit", "0"], "--limit"),
        (["--out", __file__], "--out"),
    ],
)
def test_wrong_options_are_named(options, named, capsys):
    assert main(["play", "seven_bar.toml", "--no-browser", *options]) == 2
    said = capsys.readouterr().err
    assert named in said
    assert said.count("\n") == 1


@pytest.mark.processes
def test_a_served_page_prints_nothing(monkeypatch, capsys, tmp_path, heartbeats):
    """The command waits for its user, and says so once; its folder is made when something is saved."""
    for name in ("_FIRST", "_LATER", "_GRACE"):
        monkeypatch.setattr(progress, name, 0.0)
    printed = []

    def serve(self, poll_interval):
        capsys.readouterr()
        heartbeats()
        printed.append(capsys.readouterr().err)

    monkeypatch.setattr(LiveServer, "serve_forever", serve)
    assert main(["play", "seven_bar.toml", "--no-browser", "--out", str(tmp_path / "new" / "folder")]) == 0
    assert printed == [""]
    assert not list(tmp_path.iterdir())

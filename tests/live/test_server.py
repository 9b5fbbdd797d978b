"""The server of the live page accepts requests of its page only."""

import http.client
import json
import os
import re
import signal
import subprocess
import sys
import threading

import pytest

import linkages


def ask(server, method="POST", path=None, body=b'{"values": {}}', headers=None):
    """Send one request; returns status, headers and body."""
    connection = http.client.HTTPConnection(*server.server_address, timeout=60)
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


def test_a_hundred_requests_at_once_give_one_run_after_the_other(serve):
    """Each is answered; all but the latest may be skipped, and the latest is computed."""
    server, replies = serve(), [None] * 100
    ask(server)

    def send(k):
        body = json.dumps({"values": {"joints.A.viscosity": 0.3 + 0.001 * k}}).encode()
        replies[k] = json.loads(ask(server, body=body)[2])

    threads = [threading.Thread(target=send, args=(k,)) for k in range(100)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all("outdated" in reply or reply["status"] == "ok" for reply in replies)
    assert sum("status" in reply for reply in replies) < 100
    assert any("status" in reply for reply in replies)


def test_names_with_markup_are_text(serve, system_of):
    sdf = linkages.find_file("seven_bar.sdf").read_text().replace("link2", "a&lt;script&gt;alert(1)&lt;/script&gt;")
    toml = linkages.find_file("seven_bar.toml").read_text().partition("\n\n")[2].partition("\n")[2]
    server = serve(system_of(sdf, toml))
    picture = json.loads(ask(server, path=f"/{server.token}/picture")[2])["svg"]
    assert "<script" not in picture
    assert "&lt;script" in picture


def test_the_command_serves_until_ctrl_c(tmp_path):
    command = [
        sys.executable,
        "-m",
        "linkages.cli.main",
        "play",
        "seven_bar.toml",
        "--no-browser",
        "--out",
        str(tmp_path),
    ]
    served = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=tmp_path)
    address = re.search(r"http://127\.0\.0\.1:(\d+)/([\w-]+)/", served.stdout.readline())
    connection = http.client.HTTPConnection("127.0.0.1", int(address[1]), timeout=60)
    connection.request("GET", f"/{address[2]}/")
    assert connection.getresponse().status == 200
    connection.close()
    os.kill(served.pid, signal.SIGINT)
    assert served.wait(60) == 130
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--vary", "joints.A.clearanc=1:2"], "joints.A.clearanc"),
        (["--vary", "joints.A.clearance=2:1"], "--vary"),
        (["--port", "99999"], "--port"),
        (["--limit", "0"], "--limit"),
        (["--out", "nowhere"], "--out"),
    ],
)
def test_wrong_options_are_named(options, named, capsys):
    from linkages.cli.main import main

    assert main(["play", "seven_bar.toml", "--no-browser", *options]) == 2
    said = capsys.readouterr().err
    assert named in said
    assert said.count("\n") == 1

"""A live page that is served to a test, and a browser for it."""

import threading

import pytest
from browser import started

import linkages
from linkages.show.live.answers import Answers
from linkages.show.live.controls import controls
from linkages.show.live.server import LiveServer
from linkages.show.live.session import Session


@pytest.fixture(scope="module")
def browser():
    with started("--window-size=1280,1200") as found:
        yield found


@pytest.fixture
def serve(tmp_path):
    """Serve a page for the values of an experiment; the server ends with the test."""
    served = []

    def start(system=None, vary=None):
        system = system or linkages.load(linkages.find_file("seven_bar.toml"))
        server = LiveServer(Answers(Session(system, 60.0, 60.0), controls(system, vary), tmp_path))
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02})
        thread.start()
        served.append((server, thread))
        return server

    yield start
    for server, thread in served:
        server.shutdown()
        server.server_close()
        thread.join()


@pytest.fixture
def answers(tmp_path):
    """Make the answers of a shipped experiment, which save into a folder of the test."""

    def make(name, limit=60.0, preview=60.0, **overrides):
        system = linkages.load(linkages.find_file(f"{name}.toml"), overrides)
        return Answers(Session(system, limit, preview), controls(system), tmp_path, overrides)

    return make


@pytest.fixture
def settled():
    """Ask for a run until its motion is settled, as the page does."""

    def ask(of, values):
        for _ in range(20):
            reply = of.answer("run", {"values": values})
            assert "error" not in reply, reply
            if reply["settled"]:
                return reply | of.answer("numbers", {})
        raise AssertionError("the motion does not settle")

    return ask


@pytest.fixture
def steady_numbers():
    """Return the peaks of the last period of a file's motion, as `linkages simulate` reports them."""

    def peaks(path):
        summary = linkages.summarize(linkages.assess(linkages.load(path), "compiled", error_estimate=False))
        shown = summary["windows"][summary["report"]] if summary["report"] != "whole" else summary
        found = {name: entry["peak"] for name, entry in shown["outputs"].items()}
        found |= {f"{name}.force": entry["force"]["peak"] for name, entry in shown["joints"].items()}
        return found | {f"{name}.torque": entry["torque"]["peak"] for name, entry in shown["drives"].items()}

    return peaks

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
        server = LiveServer(Answers(Session(system), controls(system, vary), tmp_path))
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02})
        thread.start()
        served.append((server, thread))
        return server

    yield start
    for server, thread in served:
        server.shutdown()
        server.server_close()
        thread.join()

"""The built site: its search leads to the right page, in a browser, with the site's own index.

``SITE`` names a folder with the site; without it the test builds one. Both need the extra ``docs``.
"""

import functools
import os
import subprocess
import sys
import threading
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

pytest.importorskip("material", reason="the site needs the extra docs")
pytest.importorskip("selenium")
from browser import find_browser, started

ROOT = Path(__file__).resolve().parents[1]
pytestmark = [pytest.mark.slow, pytest.mark.skipif(find_browser() is None, reason="needs a browser")]
#: Words that users type, and the page that answers.
QUESTIONS = {
    "plot results": "plot_results",
    "units mm": "units",
    "bifurcation diagram": "nonlinear",
    "import solidworks": "import",
    "export csv": "export",
    "impact force": "tutorial_dry",
    "joint clearance": "clearance",
    "natural frequency": "modes",
    "genetic algorithm": "optimisation",
    "wear depth": "wear",
    "monte carlo": "tolerances",
    "flexible link": "flexible",
    "motor torque": "motors",
    "measured data": "recorded",
    "gear backlash": "gears",
    "live page": "tutorial_live",
}
FIRST = 3  # results that a user looks at
MISSED = 1  # questions that may lead elsewhere
#: Types the argument's words, and returns the pages found once the list has stayed the same for 0.5 s.
_SEARCH = """
const [words, done] = arguments, input = document.querySelector("[data-md-component=search-query]");
input.value = words;
input.dispatchEvent(new Event("keyup", {bubbles: true}));
let before = "", same = 0;
const timer = setInterval(() => {
  const said = document.querySelector(".md-search-result__meta").textContent;
  const links = [...document.querySelectorAll(".md-search-result__item > a:first-of-type")];
  const pages = links.map((link) => new URL(link.href).pathname.slice(1).replace(".html", ""));
  const now = said + pages;
  same = now === before && said.includes("matching") ? same + 1 : 0;
  before = now;
  if (same > 5) { clearInterval(timer); done([...new Set(pages)]); }
}, 80);
"""


class _Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        """Print nothing."""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Address of the site."""
    folder = os.environ.get("SITE") or str(tmp_path_factory.mktemp("site"))
    if "SITE" not in os.environ:
        subprocess.run([sys.executable, "-m", "mkdocs", "build", "-q", "-d", folder], cwd=ROOT, check=True)
    server = ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(_Quiet, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()


def test_the_search_leads_to_the_right_page(site):
    found = {}
    with started("--window-size=1280,900") as browser:
        browser.get(f"{site}/index.html")
        browser.execute_script("document.querySelector('[data-md-component=search-query]').focus()")
        for words in QUESTIONS:
            found[words] = browser.execute_async_script(_SEARCH, words)[:FIRST]
    missed = {words: pages for words, pages in found.items() if QUESTIONS[words] not in pages}
    assert len(missed) <= MISSED, missed
    evidence = ("replication", "misprints", "press_films", "api/")
    assert not [page for pages in found.values() for page in pages if page.startswith(evidence)]

"""Open a page in a headless browser without network, and return its content and its requests.

Time in the page is the wall clock's: Chromium's virtual time (``--virtual-time-budget``) now and then never ends.
"""

from __future__ import annotations

import base64
import io
import json
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.ui import WebDriverWait

_NAMES = ("chromium", "chromium-browser", "google-chrome")
_FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--disable-dev-shm-usage", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--hide-scrollbars",
    "--host-resolver-rules=MAP * ~NOTFOUND",  # no name is resolved: no network
)  # fmt: skip
_PATIENCE = 100.0  # seconds for a page to load and to answer

# Runs in the page before its own parts: counts requests rejected by the content policy, and reports the end of drawing.
_PROBE = """<script>
const refused = [];
document.addEventListener("securitypolicyviolation", (event) => refused.push(event.blockedURI));
let drawn = false;
addEventListener("load", () => setTimeout(() => { drawn = true; }, 1000));
const frames = async (count) => { while (count--) await new Promise(requestAnimationFrame); };
const decoded = async (view) => { while (!view.viewer?.animator.duration) await frames(1); };  // a window's recording
</script>"""


@dataclass(frozen=True)
class Page:
    """Content and requests of a page in the browser.

    Attributes
    ----------
    seen : dict
        Result of the probe, with ``refused``: requests rejected by the page's content policy.
    image : (height, width, 3) array
        Screenshot, 0 to 1.
    requests : list of str
        URLs that the page requested from the network, without the browser's requests.
    """

    seen: dict[str, Any]
    image: np.ndarray
    requests: list[str]


def find_browser() -> str | None:
    """Path of a Chromium, if there is one and its driver."""
    found = next((path for name in _NAMES if (path := shutil.which(name))), None)
    return found if shutil.which("chromedriver") else None


def open_page(path: Path, folder: Path, look: str = "return {};", size: tuple[int, int] = (1200, 1400)) -> Page:
    """Open a file; `look` is the body of an asynchronous function that runs in the page after it has loaded.

    It can await ``decoded(window)``: the window's recording can be played; and ``frames(n)``: n more were drawn.
    """
    text = path.read_text(encoding="utf-8")
    probed = folder / "probed.html"
    at = re.search(r"<body[^>]*>", text)
    place = at.end() if at else 0
    probed.write_text(text[:place] + _PROBE + text[place:], encoding="utf-8")
    log = folder / "net.json"
    browser = _start(f"--window-size={size[0]},{size[1]}", f"--log-net-log={log}")
    try:
        browser.get(probed.as_uri())
        WebDriverWait(browser, _PATIENCE).until(lambda page: page.execute_script("return drawn"))
        seen = browser.execute_script(f"return (async () => {{{look}}})().then((seen) => ({{refused, ...seen}}));")
        image = matplotlib.image.imread(io.BytesIO(browser.get_screenshot_as_png()))[:, :, :3]
    finally:
        browser.quit()  # completes the log
    return Page(seen, image, _requests(log))


@contextmanager
def started(*flags: str) -> Iterator[webdriver.Chrome]:
    """A browser that a test drives itself; it may reach this machine by its number, and no names."""
    browser = _start(*flags, "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1")  # the last one holds
    try:
        yield browser
    finally:
        browser.quit()


def _start(*flags: str) -> webdriver.Chrome:
    options = webdriver.ChromeOptions()
    options.binary_location = find_browser()
    for flag in (*_FLAGS, *flags):
        options.add_argument(flag)
    browser = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    browser.set_page_load_timeout(_PATIENCE)
    browser.set_script_timeout(_PATIENCE)
    return browser


def picture(data_uri: str) -> np.ndarray:
    """Pixels of a PNG given as a data URI, (height, width, 3), 0 to 1."""
    return matplotlib.image.imread(io.BytesIO(base64.b64decode(data_uri.partition(",")[2])))[:, :, :3]


def _requests(log: Path) -> list[str]:
    """Return the URLs of a network log that a page requested: entries with an initiator."""
    events = json.loads(log.read_text(encoding="utf-8"))["events"]
    asked = [event["params"] for event in events if "initiator" in event.get("params", {})]
    return sorted({item["url"] for item in asked if item["initiator"] != "not an origin"})

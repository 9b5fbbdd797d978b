"""Opens a page in a headless browser that can reach no network, and says what it shows and what it asked for."""

from __future__ import annotations

import base64
import html
import io
import json
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np

_NAMES = ("chromium", "chromium-browser", "google-chrome")
_FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--disable-dev-shm-usage", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--hide-scrollbars",
    "--host-resolver-rules=MAP * ~NOTFOUND",  # no name is resolved: no network
)  # fmt: skip

# Runs in the page: counts what the content policy refused; after loading calls `look` and writes its result down.
_PROBE = """<script>
const refused = [];
document.addEventListener("securitypolicyviolation", (event) => refused.push(event.blockedURI));
addEventListener("load", () => setTimeout(() => {
  const seen = (() => {@LOOK@})();
  document.documentElement.dataset.seen = JSON.stringify({refused, ...seen});
}, 3000));
</script>"""


@dataclass(frozen=True)
class Page:
    """What the browser showed and asked for.

    Attributes
    ----------
    seen : dict
        What the probe returned, and ``refused``: what the page's content policy refused to fetch.
    image : (height, width, 3) array
        Screenshot, 0 to 1.
    requests : list of str
        URLs that the page asked the network for; what the browser asks for on its own account is left out.
    """

    seen: dict[str, Any]
    image: np.ndarray
    requests: list[str]


def find_browser() -> str | None:
    """Path of a Chromium, if there is one."""
    return next((path for name in _NAMES if (path := shutil.which(name))), None)


def open_page(
    path: Path, folder: Path, look: str = "return {};", size: tuple[int, int] = (1200, 1400)
) -> Page:
    """Open a file; `look` is the body of a function that runs in the page after it has loaded."""
    browser = find_browser()
    assert browser is not None
    text = path.read_text(encoding="utf-8")
    probed = folder / "probed.html"
    at = re.search(r"<body[^>]*>", text)
    place = at.end() if at else 0
    probed.write_text(text[:place] + _PROBE.replace("@LOOK@", look) + text[place:], encoding="utf-8")
    shot, log = folder / "shot.png", folder / "net.json"
    command = [
        browser, *_FLAGS, f"--user-data-dir={folder / 'profile'}", f"--window-size={size[0]},{size[1]}",
        f"--log-net-log={log}", f"--screenshot={shot}", "--virtual-time-budget=12000", "--dump-dom", probed.as_uri(),
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    found = re.search(r'data-seen="([^"]*)"', done.stdout)
    assert found, "the probe did not run"
    return Page(json.loads(html.unescape(found[1])), matplotlib.image.imread(shot)[:, :, :3], _requests(log))


def picture(data_uri: str) -> np.ndarray:
    """Pixels of a PNG given as a data URI, (height, width, 3), 0 to 1."""
    return matplotlib.image.imread(io.BytesIO(base64.b64decode(data_uri.partition(",")[2])))[:, :, :3]


def _requests(log: Path) -> list[str]:
    """URLs of a network log that a page asked for: those with an initiator."""
    events = json.loads(log.read_text(encoding="utf-8"))["events"]
    asked = [event["params"] for event in events if "initiator" in event.get("params", {})]
    return sorted({item["url"] for item in asked if item["initiator"] != "not an origin"})

"""Writes the picture of the live page, with a headless Chromium: ``python docs/make_live.py``."""

import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from browser import started

import linkages
from linkages.live.answers import Answers
from linkages.live.controls import controls
from linkages.live.server import LiveServer
from linkages.live.session import Session

FIGURES = Path(__file__).parent / "figures"

# Pins the first steady motion, then doubles the clearance of A.
_CHANGE = """
const [done] = arguments, root = document.querySelector("main");
const idle = async () => {
  await new Promise((go) => setTimeout(go, 200));
  while (root.getAttribute("aria-busy") !== "false") await new Promise((go) => setTimeout(go, 50));
};
(async () => {
  await idle();
  document.querySelector(".buttons button").click();
  const field = document.querySelector('[data-path="joints.A.clearance"] .typed');
  field.value = "0.6 mm";
  field.dispatchEvent(new Event("change"));
  await idle();
  document.querySelector(".playback button").click();
  done();
})();
"""

if __name__ == "__main__":
    system = linkages.load(linkages.find_file("seven_bar.toml"))
    server = LiveServer(Answers(Session(system), controls(system), Path(".")))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with started("--window-size=1280,1500") as browser:
        browser.get(server.address)
        browser.execute_async_script(_CHANGE)
        browser.save_screenshot(str(FIGURES / "live_page.png"))
    server.shutdown()

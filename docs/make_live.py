"""Writes the pictures of the live page's tutorial, with a headless Chromium: ``python docs/make_live.py [NAME ...]``."""

import io
import json
import sys
import threading
from pathlib import Path
from urllib.parse import quote

from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from browser import started

import linkages
from linkages.show.live.answers import Answers
from linkages.show.live.controls import controls
from linkages.show.live.server import LiveServer
from linkages.show.live.session import Session

FIGURES = Path(__file__).parent / "figures"
FAST = {"drives.O.speed": 200.0}


def viscosity(value):
    """Values of both joints."""
    return {f"joints.{name}.viscosity": value for name in "AB"}


#: Machine, values of the pinned run [SI units], values that are typed then, and the shown curves, or parts of the page.
PICTURES = {
    "live_page": ("seven_bar", {}, {"joints.A.clearance": "0.6"}, ()),
    "live_film": ("seven_bar", {}, dict.fromkeys(viscosity(0), "5"), ".orbits figure"),
    "live_direction": ("seven_bar", {}, {"drives.O4.speed": "60"}, ("slider7.ax", "A.force")),
    "live_mass": ("seven_bar", {}, {"sdf.links.link2.mass": "0.5"}, ("A.force", "B.force")),
    "live_contact": ("seven_bar_mixed", viscosity(0.1), dict.fromkeys(viscosity(0), "1"), ".orbits figure"),
    "live_friction": ("slider_crank_dry", FAST, {"joints.B.friction.coefficient": "0.2"}, ("B.force",)),
}

# Pins the first run, changes the values one by one, and stops the moving picture.
_CHANGE = """
const [values, done] = arguments, root = document.querySelector("main");
const idle = async () => {
  await new Promise((go) => setTimeout(go, 200));
  while (root.getAttribute("aria-busy") !== "false") await new Promise((go) => setTimeout(go, 50));
};
const row = (path) => document.querySelector(`[data-path="${path}"] .typed`);
(async () => {
  await idle();
  document.querySelector(".buttons button").click();
  for (const [path, value] of Object.entries(values)) {
    if (!row(path)) {
      document.querySelector(".search input").value = path;
      document.querySelector(".search").requestSubmit();
    }
    row(path).value = value;
    row(path).dispatchEvent(new Event("change"));
    await idle();
  }
  document.querySelector(".playback button").click();
  done();
})();
"""


def write(browser, name):
    """Write a picture."""
    file, pinned, changed, shown = PICTURES[name]
    system = linkages.load(linkages.find_file(f"{file}.toml"))
    server = LiveServer(Answers(Session(system), controls(system), Path(".")))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    size = {"width": 1280, "height": 2400 if shown else 800, "deviceScaleFactor": 2 if shown else 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.get("about:blank")  # an address with another part after # would not be loaded anew
    browser.get(f"{server.address}#{quote(json.dumps(pinned))}")
    browser.execute_async_script(_CHANGE, changed)
    if shown:  # curves and joints take the width of the other panels
        hide = "document.querySelector('.layout').classList.add('no-controls', 'no-numbers'); setTimeout(arguments[0], 500);"
        browser.execute_async_script(hide)
    if isinstance(shown, str):
        parts = browser.find_elements("css selector", shown)
    else:
        parts = [browser.find_element("xpath", f"//figure[figcaption[@title='{curve}']]") for curve in shown]
    shots = [part.screenshot_as_png for part in parts] or [browser.get_screenshot_as_png()]
    images = [Image.open(io.BytesIO(shot)) for shot in shots]
    whole = Image.new("RGB", (max(image.width for image in images), sum(image.height for image in images)), "white")
    for k, image in enumerate(images):
        whole.paste(image, (0, sum(before.height for before in images[:k])))
    whole.save(FIGURES / f"{name}.png")
    server.shutdown()


if __name__ == "__main__":
    with started("--window-size=1280,800") as browser:
        browser.set_script_timeout(600)
        for name in sys.argv[1:] or PICTURES:
            write(browser, name)

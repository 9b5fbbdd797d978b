"""Measure the live page: time from a changed slider to drawn curves and to the table, and updates per second of a drag.

Needs Chromium and its driver. ``python benchmarks/play.py [--changes N]``; times in ms, of a browser without a graphics
card, which draws on the processor that also computes.
"""

from __future__ import annotations

import argparse
import sys
import threading
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from browser import started

import linkages
from linkages.show.live.answers import Answers
from linkages.show.live.controls import controls
from linkages.show.live.server import LiveServer
from linkages.show.live.session import Session

_PRESS = str(Path(__file__).with_name("seven_bar_fast"))

#: Machine, the slider that is moved, its range (None: as the page has it), targets: median and 95th percentile [ms].
CASES = {
    "lubricated press": (_PRESS, "joints.A.clearance", None, (50, 100)),
    "dry slider-crank, 5000 r/min": ("slider_crank_dry", "joints.B.clearance", None, (150, 300)),
    "flexible slider-crank": ("slider_crank_flexible", "joints.B.clearance", None, (150, 300)),
    "press that locks": (_PRESS, "sdf.frames.crank1_A.pose.x", (0.15, 0.25), (600, 600)),
}

# Each change moves the slider to a new place, and waits until the curves of some reply are drawn.
CHANGES = """
const [path, count, done] = arguments, root = document.querySelector("main");
const find = () => document.querySelector(`[data-path="${path}"] [type=range]`);
const wait = () => new Promise((go) => setTimeout(go, 5));
const idle = async () => { while (root.getAttribute("aria-busy") !== "false") await wait(); };
(async () => {
  while (!find()) await wait();
  const times = [], complete = [], slider = find();
  for (let k = 0; k < count; k++) {
    await idle();
    const began = performance.now();
    const shown = new Promise((go) => root.addEventListener("shown", go, {once: true}));
    slider.value = 400 + (k * 37) % 200;
    slider.dispatchEvent(new Event("input"));
    await shown;
    await new Promise((go) => requestAnimationFrame(() => go()));
    times.push(performance.now() - began);
    slider.dispatchEvent(new Event("change"));
    while (root.querySelector(".numbers").classList.contains("older")) await wait();
    complete.push(performance.now() - began);
  }
  done([times, complete]);
})();
"""

DRAG = """
const [path, seconds, done] = arguments, root = document.querySelector("main");
const slider = document.querySelector(`[data-path="${path}"] [type=range]`);
let count = 0, k = 0;
const began = performance.now(), seen = () => { count += 1; };
root.addEventListener("shown", seen);
function move() {
  if (performance.now() - began > 1000 * seconds) {
    root.removeEventListener("shown", seen);
    slider.dispatchEvent(new Event("change"));
    return done(count / seconds);
  }
  slider.value = 400 + (k++ % 200);
  slider.dispatchEvent(new Event("input"));
  requestAnimationFrame(move);
}
move();
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--changes", type=int, default=200)
    options = parser.parse_args()
    print(f"{'':32s}{'median':>8s}{'95 %':>8s}{'target':>12s}{'computed':>10s}{'table':>8s}{'per s':>8s}")
    with started("--window-size=1280,1400") as browser:
        browser.set_script_timeout(900)
        for name, (file, path, ends, target) in CASES.items():
            system = linkages.load(linkages.find_file(f"{file}.toml"))
            session = Session(system)
            server = LiveServer(Answers(session, controls(system, ends and {path: ends}), Path(".")))
            threading.Thread(target=server.serve_forever, daemon=True).start()
            browser.get(server.address)
            browser.execute_async_script(CHANGES, path, 5)  # compiles missing kernels
            times, complete = np.array(browser.execute_async_script(CHANGES, path, options.changes))
            took = [1e3 * session.compute({path: system.value(path) * (1.0 + 0.01 * k)})["took"] for k in range(20)]
            dragged = browser.execute_async_script(DRAG, path, 4)
            middle, high = np.percentile(times, [50, 95])
            wanted = f"{target[0]} / {target[1]}"
            print(
                f"{name:32s}{middle:8.0f}{high:8.0f}{wanted:>12s}{np.median(took):10.0f}{np.median(complete):8.0f}{dragged:8.1f}"
            )
            server.shutdown()


if __name__ == "__main__":
    main()

"""Compare the live page's curves with plotly's: ``pip install plotly``, then ``python benchmarks/curve_libraries.py``.

Both libraries draw the curves of the same runs of the press in a browser without a graphics card, for the live page's
decision about its drawing code. The table has the time of a redraw until the browser has painted it [ms]: median and
95th percentile; the time of the first drawing, and the size of the script.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from browser import started

import linkages
from linkages.show.live.session import Session
from linkages.show.plots.pages import script

OWN = """
let plots = null;
const mount = (holder, curves) => { plots = drawCurves(holder, curves, () => {}); };
const update = (curves) => plots.update(curves);
"""
# The fastest of plotly's ways to draw other values: `restyle`, without interaction and animation.
PLOTLY = """
let parts = [];
const lines = (curve) => [curve.ideal, curve.run].filter(Boolean);
const mount = (holder, curves) => {
  parts = curves.map((curve) => {
    const part = document.createElement("div");
    holder.append(part);
    Plotly.newPlot(part, lines(curve).map(({time, values}) => ({x: time, y: values, mode: "lines", type: "scatter"})),
      {width: 720, height: 190, margin: {l: 78, r: 34, t: 8, b: 22}, showlegend: false}, {staticPlot: true});
    return part;
  });
};
const update = (curves) => curves.forEach((curve, k) => Plotly.restyle(parts[k],
  {x: lines(curve).map((line) => line.time), y: lines(curve).map((line) => line.values)}));
"""
MEASURE = """
const [shown, done] = arguments, holder = document.body;
const painted = () => new Promise((go) => requestAnimationFrame(() => setTimeout(go, 0)));
(async () => {
  let began = performance.now();
  mount(holder, shown[0]);
  await painted();
  const first = performance.now() - began, times = [];
  for (const curves of shown.slice(1)) {
    await new Promise((go) => setTimeout(go, 20));
    began = performance.now();
    update(curves);
    await painted();
    times.push(performance.now() - began);
  }
  done([first, times]);
})();
"""


def main() -> None:
    import plotly

    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--redraws", type=int, default=100)
    options = parser.parse_args()
    session = Session(linkages.load(Path(__file__).with_name("seven_bar_fast.toml")))
    shown = [session.compute({"joints.A.clearance": 3e-4 * (1 + 0.01 * (k % 20))})["curves"] for k in range(21)]
    shown = [shown[k % 21] for k in range(options.redraws + 1)]
    library = (Path(plotly.__file__).parent / "package_data" / "plotly.min.js").read_text(encoding="utf-8")
    print(f"{len(shown[0])} curves{'':22s}{'median':>8s}{'95 %':>8s}{'first':>8s}{'script':>10s}")
    with started("--window-size=1280,1400") as browser, tempfile.TemporaryDirectory() as folder:
        browser.set_script_timeout(600)
        for name, code, own in (("own", script(), OWN), (f"plotly {plotly.__version__}", library, PLOTLY)):
            page = Path(folder) / f"{name.split()[0]}.html"
            parts = (f"<script>{part.replace('</script', '<' + chr(92) + '/script')}</script>" for part in (code, own))
            page.write_text(f"<!DOCTYPE html><meta charset=utf-8><body>{''.join(parts)}", encoding="utf-8")
            browser.get(page.as_uri())
            first, times = browser.execute_async_script(MEASURE, shown)
            middle, high = np.percentile(times, [50, 95])
            print(f"{name:30s}{middle:8.1f}{high:8.1f}{first:8.0f}{len(code) / 1e3:8.0f} kB")


if __name__ == "__main__":
    main()

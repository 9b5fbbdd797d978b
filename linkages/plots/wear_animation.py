"""Animation of wear: a page with a slider over the service life; one file, offline, without libraries."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jinja2 import Environment
from markupsafe import Markup

from linkages.plots.curves import embedded
from linkages.plots.style import COLORS

_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{{ title }}: wear</title>
<style>
body { font: 15px sans-serif; margin: 1.5em; max-width: 60em } canvas { border: 1px solid #ccc; max-width: 100% }
figure { display: inline-block; width: 362px; max-width: 100%; margin: 1em 1em 1em 0; vertical-align: top }
label { display: block; margin: .6em 0 } input[type=range] { width: 24em; vertical-align: middle }
</style></head><body>
<h1>{{ title }}: wear</h1>
<label>cycles <input id="when" type="range" min="0" max="1000" value="0"> <output id="cycles"></output></label>
<label>wear and clearance enlarged
  <input id="zoom" type="range" min="0" max="100" value="60"> <output id="times"></output></label>
<button id="play">play</button>
<div id="joints"></div>
<script>
const life = {{ life }}, colors = {{ colors }};
const when = document.getElementById("when"), zoom = document.getElementById("zoom"), side = 360;
const views = Object.keys(life.joints).map(name => {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = side; canvas.title = "joint " + name;
  const figure = document.createElement("figure"), caption = document.createElement("figcaption");
  caption.textContent = `joint ${name}: bearing (orange) and journal (blue), each in its body frame;`
    + " dotted: the new bearing";
  figure.append(canvas, caption);
  document.getElementById("joints").append(figure);
  return [name, canvas.getContext("2d")];
});
function between(name, part, cycles) {  // profile by straight lines between the stages
  const at = life.cycles; let k = 1;
  while (k < at.length - 1 && at[k] < cycles) k++;
  const stages = life.joints[name].stages;
  const one = stages[Math.max(k - 1, 0)][part], two = stages[Math.min(k, at.length - 1)][part];
  const w = at.length > 1 ? (cycles - at[k - 1]) / (at[k] - at[k - 1]) : 0;
  return one.map((d, i) => (1 - w) * d + w * two[i]);
}
function ring(g, radius, depths, sign, scale) {
  g.beginPath();
  const n = depths.length;
  for (let i = 0; i <= n; i++) {
    const a = 2 * Math.PI * (i % n) / n, r = radius + sign * scale * depths[i % n];
    g[i ? "lineTo" : "moveTo"](side / 2 + r * Math.cos(a), side / 2 - r * Math.sin(a));
  }
  g.closePath();
}
function draw() {
  const last = life.cycles[life.cycles.length - 1], cycles = last * when.value / 1000, base = side * 0.3;
  document.getElementById("cycles").value = Math.round(cycles).toLocaleString("en");
  for (const [name, g] of views) {
    const joint = life.joints[name], most = Math.max(joint.depth, joint.clearance);
    const scale = 0.35 * base / most * zoom.value / 60, times = scale / (base / joint.radius);
    document.getElementById("times").value = `${Number(times.toPrecision(3))} times`;
    const c = scale * joint.clearance;
    g.fillStyle = "#e6e6e6"; g.fillRect(0, 0, side, side);
    g.fillStyle = "#ffffff"; ring(g, base, between(name, "bearing", cycles), 1, scale); g.fill();
    g.strokeStyle = colors[1]; g.lineWidth = 2; g.stroke();
    g.setLineDash([3, 4]); g.strokeStyle = "#777"; g.lineWidth = 1;
    g.beginPath(); g.arc(side / 2, side / 2, base, 0, 2 * Math.PI); g.stroke(); g.setLineDash([]);
    g.fillStyle = "#c9d9ea"; ring(g, base - c, between(name, "journal", cycles), -1, scale); g.fill();
    g.strokeStyle = colors[0]; g.lineWidth = 2; g.stroke();
  }
}
when.oninput = zoom.oninput = draw;
let timer = 0;
document.getElementById("play").onclick = () => {
  clearInterval(timer); when.value = 0;
  timer = setInterval(() => {
    when.value = +when.value + 5; draw();
    if (+when.value >= 1000) clearInterval(timer);
  }, 30);
};
draw();
</script></body></html>
"""


def write_animation(found: Mapping[str, Any], path: Path) -> None:
    """Write a page with the growing profiles of all joints, from the content of ``wear.json``."""
    joints = {}
    for name, joint in found["joints"].items():
        nodes = len(joint["profile"])
        stages = [
            {side: _depths(block["joints"][name], side, nodes) for side in ("bearing", "journal")}
            for block in found["blocks"]
        ]
        kept = {key: joint[key] for key in ("depth", "clearance", "radius")}
        joints[name] = kept | {"stages": stages}
    life = {"cycles": [block["cycles"] for block in found["blocks"]], "joints": joints}
    page = Environment(autoescape=True).from_string(_PAGE)
    marked = {key: Markup(embedded(value)) for key, value in (("life", life), ("colors", COLORS))}
    path.write_text(page.render(title=found["title"] or found["experiment"], **marked), encoding="utf-8")


def _depths(joint: Mapping[str, Any], side: str, nodes: int) -> list[float]:
    """Return the depths of a part at a stage [m], rounded to the visible resolution."""
    if side not in joint:
        return [0.0] * nodes
    return [float(f"{depth:.4g}") for _, depth in joint[side]["profile"]]

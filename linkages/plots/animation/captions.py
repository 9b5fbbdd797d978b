"""Text over a Meshcat recording, which Meshcat itself cannot draw.

A small script is added to the page. It finds where the camera sees the anchors of the labels and writes there what
belongs to the frame that is shown.
"""

from __future__ import annotations

import json
from dataclasses import dataclass


@dataclass(frozen=True)
class Label:
    """A text at a place in the scene.

    Attributes
    ----------
    anchor : str
        Meshcat path of the place.
    title : str
    lines : list of str
        What is written below the title, one for each frame; nothing where it is empty.
    """

    anchor: str
    title: str
    lines: list[str]


def add_captions(page: str, labels: list[Label], clock: list[str], legend: str) -> str:
    """Add labels, a clock, a legend and a bar that plays in a loop, stops and seeks to the page of a recording.

    Parameters
    ----------
    page : str
        HTML.
    labels : list of Label
    clock : list of str
        One text for each frame.
    legend : str

    Returns
    -------
    str
        HTML.

    Raises
    ------
    ValueError
        If the page has no body.
    """
    entries = [
        {"path": label.anchor.strip("/").split("/"), "title": label.title, "lines": label.lines} for label in labels
    ]
    data = json.dumps({"labels": entries, "clock": clock, "legend": legend}).replace("</", "<\\/")
    head, found, tail = page.rpartition("</body>")
    if not found:
        raise ValueError("the recording has no body to write captions into")
    return f"{head}{_CAPTIONS.replace('@DATA@', data)}{found}{tail}"


_CAPTIONS = """<style>
.caption { position: fixed; color: #1a1a1a; font: 13px/1.35 system-ui, sans-serif; pointer-events: none; }
.caption b { font-size: 15px; }
.caption.label { transform: translate(-50%, -100%); text-align: center; white-space: nowrap; padding-bottom: 4px; }
#notes { left: 12px; bottom: 8px; max-width: 92vw; }
#bar { left: 12px; top: 8px; display: flex; gap: 8px; pointer-events: auto; }
#bar button { min-width: 4.5em; }
#bar input { width: 16em; }
</style>
<div class="caption" id="bar"><button type="button">pause</button><input type="range" min="0" aria-label="time"></div>
<div class="caption" id="notes"><b></b><br><span></span></div>
<script>
(() => {
  const data = @DATA@;
  const [clock, legend] = [document.querySelector("#notes b"), document.querySelector("#notes span")];
  legend.textContent = data.legend;
  const labels = data.labels.map((label) => {
    const box = document.createElement("div");
    box.className = "caption label";
    const [title, line] = [document.createElement("b"), document.createElement("div")];
    title.textContent = label.title;
    box.append(title, line);
    document.body.append(box);
    return {box, line, lines: label.lines, node: () => viewer.scene_tree.find(label.path).object};
  });
  const point = new MeshCat.THREE.Vector3();
  const [button, slider] = [document.querySelector("#bar button"), document.querySelector("#bar input")];
  const last = slider.max = data.clock.length - 1;
  const time = () => viewer.animator.actions[0]?.time ?? 0;
  let playing = true, before = 0;
  function play(on) {
    playing = on;
    button.textContent = on ? "pause" : "play";
  }
  button.addEventListener("click", () => play(!playing));
  slider.addEventListener("input", () => {
    play(false);
    viewer.animator.pause();
    viewer.animator.seek(slider.value / last * viewer.animator.duration);
  });
  function write(now) {
    const length = viewer.animator.duration || 1;
    if (playing && viewer.animator.duration) {
      viewer.animator.pause();
      viewer.animator.seek((time() + (now - before) / 1000) % length);
    }
    before = now;
    const frame = Math.min(Math.round(time() / length * last), last);
    slider.value = frame;
    clock.textContent = data.clock[frame];
    const [width, height] = [innerWidth, innerHeight];
    for (const label of labels) {
      label.line.textContent = label.lines[frame] ?? "";
      label.node().getWorldPosition(point).project(viewer.camera);
      label.box.style.left = `${(point.x + 1) / 2 * width}px`;
      label.box.style.top = `${(1 - point.y) / 2 * height}px`;
    }
    requestAnimationFrame(write);
  }
  requestAnimationFrame(write);
})();
</script>
"""

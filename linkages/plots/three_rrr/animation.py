"""A mode vibrating over the moving robot, as one HTML file that needs no network."""

from __future__ import annotations

import html
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.plots.three_rrr.drawing import displaced_lines
from linkages.three_rrr.study import FlexibleStudy

Array = NDArray[np.floating]

_FRAMES = 121
_SHARE = 0.1  # drawn deflection as a part of the coupler's length
_EVERY = 2  # points of a line that are kept


def write_animation(study: FlexibleStudy, path: Path) -> Path:
    """Write the animation; returns its path."""
    title = html.escape(study.robot.title or "Flexible robot")
    data = json.dumps(animation_data(study), separators=(",", ":"))
    path.write_text(_PAGE.replace("@TITLE@", title).replace("@DATA@", data), encoding="utf-8")
    return path


def animation_data(study: FlexibleStudy) -> dict[str, Any]:
    """Lines at rest [mm] and their displacement in each mode, by frame.

    The shapes are those followed by MAC, with continuous signs, each scaled to the same largest deflection.
    """
    places = np.unique(np.linspace(0, len(study.motion) - 1, _FRAMES).astype(int))
    size = _SHARE * float(np.max(study.model.geometry.coupler))
    frames: list[dict[str, Any]] = []
    for index in places:
        one = study.motion.part(slice(int(index), int(index) + 1))
        rest = _points(displaced_lines(study.model, one, np.zeros(study.model.full)))
        shapes = []
        for mode in range(study.tracked.shape[1]):
            full = study.model.expand(one, study.shapes[index, :, mode][None])[0]
            moved = [
                a - b for a, b in zip(_points(displaced_lines(study.model, one, full)), rest, strict=True)
            ]
            largest = max(float(np.max(np.linalg.norm(line, axis=1))) for line in moved)
            shapes.append([_rounded(1e3 * size / largest * line) for line in moved])
        frames.append(
            {
                "t": round(float(one.time[0]), 4),
                "rest": [_rounded(1e3 * line) for line in rest],
                "shape": shapes,
            }
        )
    low = np.min([np.min(line, axis=0) for frame in frames for line in map(np.array, frame["rest"])], axis=0)
    high = np.max([np.max(line, axis=0) for frame in frames for line in map(np.array, frame["rest"])], axis=0)
    return {
        "frames": frames,
        "hz": np.round(study.tracked[places], 2).tolist(),
        "base": _rounded(1e3 * study.model.geometry.base),
        "box": [*np.round(low - 60).tolist(), *np.round(high + 60).tolist()],
    }


def _points(lines: list[tuple[Array, str]]) -> list[Array]:
    return [line if name == "platform" else line[::_EVERY] for line, name in lines]


def _rounded(points: Array) -> list[list[float]]:
    return np.round(points, 1).tolist()


_PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>@TITLE@: modes</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
body{font:15px/1.4 system-ui,sans-serif;margin:0;background:#fff;color:#222}
main{max-width:760px;margin:0 auto;padding:12px}
h1{font-size:18px;margin:4px 0 8px}
canvas{width:100%;border:1px solid #ccc;border-radius:4px;display:block}
.row{display:flex;gap:14px;flex-wrap:wrap;align-items:center;margin:10px 0}
label{display:flex;gap:6px;align-items:center}
output{font-variant-numeric:tabular-nums}
p{color:#555;font-size:13px}
</style></head><body><main>
<h1>@TITLE@</h1>
<canvas id="view" width="1480" height="1180"></canvas>
<div class="row">
<button id="play">Pause</button>
<label>mode <select id="mode"></select></label>
<label>deflection <input id="size" type="range" min="0" max="2" step="0.05" value="1"></label>
<label>pose <input id="pose" type="range" min="0" value="0" step="1"></label>
<output id="text"></output>
</div>
<p>Grey: the rigid pose. Colour: the mode's shape, its size and its vibration's speed chosen to be seen.
The mode is followed from pose to pose; its natural frequency changes with the pose.</p>
</main>
<script>
const D=@DATA@;
const el=n=>document.getElementById(n),cv=el("view"),g=cv.getContext("2d");
const colors=["#0072B2","#D55E00","#009E73","#CC79A7","#E69F00","#56B4E9"];
D.hz[0].forEach((f,i)=>el("mode").add(new Option((i+1)+" ("+f.toFixed(1)+" Hz at t = 0)",i)));
el("pose").max=D.frames.length-1;
const [x0,y0,x1,y1]=D.box,k=Math.min(cv.width/(x1-x0),cv.height/(y1-y0));
const ox=(cv.width-k*(x1-x0))/2,oy=(cv.height-k*(y1-y0))/2;
const X=x=>ox+k*(x-x0),Y=y=>cv.height-oy-k*(y-y0);
function line(p,d,s,color,width){g.beginPath();p.forEach((q,i)=>{
const x=X(q[0]+(d?s*d[i][0]:0)),y=Y(q[1]+(d?s*d[i][1]:0));
i?g.lineTo(x,y):g.moveTo(x,y)});g.strokeStyle=color;g.lineWidth=width;g.lineJoin="round";g.stroke()}
let playing=true,at=0,phase=0,last=null;
function draw(){const n=Math.round(at)%D.frames.length,F=D.frames[n],m=+el("mode").value;
const s=+el("size").value*Math.sin(phase);
g.fillStyle="#fff";g.fillRect(0,0,cv.width,cv.height);
F.rest.forEach(p=>line(p,null,0,"#bbb",3));
F.rest.forEach((p,i)=>line(p,F.shape[m][i],s,colors[m%6],i==F.rest.length-1?5:6));
g.fillStyle="#333";D.base.forEach(p=>{g.beginPath();
g.moveTo(X(p[0]),Y(p[1]));g.lineTo(X(p[0])-13,Y(p[1])+22);
g.lineTo(X(p[0])+13,Y(p[1])+22);g.fill()});
el("text").textContent="t = "+F.t.toFixed(2)+" s, "+D.hz[n][m].toFixed(1)+" Hz";
if(playing)el("pose").value=n}
function step(now){if(last!==null&&playing){const dt=Math.min((now-last)/1000,0.1);
at=(at+dt*D.frames.length/20)%D.frames.length}
if(last!==null)phase+=Math.min((now-last)/1000,0.1)*2*Math.PI*0.8;last=now;draw();requestAnimationFrame(step)}
el("play").onclick=()=>{playing=!playing;el("play").textContent=playing?"Pause":"Play"};
el("pose").oninput=()=>{playing=false;el("play").textContent="Play";at=+el("pose").value};
phase=1.2;draw();requestAnimationFrame(step);
</script></body></html>
"""

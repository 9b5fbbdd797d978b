"use strict";
// Draws curves over time into an element: ideal joints wide and pale below the run, other runs dashed, measured values
// dotted, a band shaded, a mark at the run's largest value. The wheel or + and - zoom, dragging moves, a click calls
// seek(time), arrow keys move the cursor, 0 shows the whole time; all curves share the cursor.
// A curve has name, unit, run, ideal, measured (each time and values, or null), and optionally label, others (lines with
// name and look, a class), band (time, low, high) and color, a mark of the caption. high(width) is the height of a figure
// [px]. Returns functions: point(time) moves the cursor, all() shows all of the run, update(curves) draws other curves of
// the same names, fit() takes the size of the holder.
function drawCurves(holder, curves, seek, high = (width) => Math.min(190, 60 + 0.3 * width)) {
  const [LEFT, RIGHT, BOTTOM, TOP] = [64, 18, 22, 10];
  const span = (of) => [Math.min(...of.map((c) => c.run.time[0])), Math.max(...of.map((c) => c.run.time.at(-1)))];
  let [from, to] = span(curves), view = [from, to], cursor = null, [W, H] = [720, 190];

  function make(tag, attributes, parent) {
    const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    parent?.append(node);
    return node;
  }
  function text(number) {
    const short = Number(number.toPrecision(4));
    return (short && (Math.abs(short) < 1e-3 || Math.abs(short) >= 1e5) ? short.toExponential() : short.toString()).replace("-", "−");
  }
  function marks(low, high, count) {
    const raw = (high - low) / count, unit = 10 ** Math.floor(Math.log10(raw));
    const step = unit * [1, 2, 5, 10].find((m) => m * unit >= raw);
    const found = [];
    for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k++) found.push(k * step);
    return found;
  }
  holder.replaceChildren();
  const plots = curves.map((curve) => {
    const figure = document.createElement("figure");
    const caption = document.createElement("figcaption");
    const svg = make("svg", {role: "img", tabindex: 0, "aria-label": `${curve.label ?? curve.name} over time; arrow keys move the cursor, + and - zoom`});
    if (curve.color) Object.assign(caption.style, {boxShadow: `inset 4px 0 ${curve.color}`, paddingLeft: "8px"});
    figure.append(svg, caption);
    holder.append(figure);
    return {curve, svg, caption};
  });
  const x = (t) => LEFT + (t - view[0]) / (view[1] - view[0]) * (W - LEFT - RIGHT);
  const timeAt = (svg, event) => {
    const box = svg.getBoundingClientRect(), at = (event.clientX - box.left) / box.width * W;
    return view[0] + (at - LEFT) / (W - LEFT - RIGHT) * (view[1] - view[0]);
  };
  function draw(plot) {
    const {curve, svg} = plot, {ideal, measured, run, others = [], band} = curve, inside = [];
    const edges = band ? [{time: band.time, values: band.low}, {time: band.time, values: band.high}] : [];
    const lines = [ideal, measured, ...others, run].filter(Boolean);
    for (const line of [...lines, ...edges]) {
      line.time.forEach((t, k) => {
        if (line.values[k] !== null && t >= view[0] && t <= view[1]) inside.push(line.values[k]);
      });
      for (const t of view) if (t >= line.time[0] && t <= line.time.at(-1)) inside.push(valueAt(line, t) ?? 0);
    }
    let [low, high] = [Math.min(...inside), Math.max(...inside)];
    const room = 0.06 * (high - low) || 0.5 * Math.abs(high) || 1;
    [low, high] = [low - room, high + room];
    const y = (value) => TOP + (high - value) / (high - low) * (H - TOP - BOTTOM);
    svg.setAttribute("viewBox", `0 0 ${W} ${H}`);
    svg.replaceChildren();
    for (const value of marks(low, high, Math.max(3, H / 40))) {
      make("line", {x1: LEFT, x2: W - RIGHT, y1: y(value), y2: y(value), class: "grid"}, svg);
      make("text", {x: LEFT - 6, y: y(value) + 4, "text-anchor": "end"}, svg).textContent = text(value);
    }
    for (const t of marks(view[0], view[1], W / 100)) {
      make("line", {x1: x(t), x2: x(t), y1: TOP, y2: H - BOTTOM, class: "grid"}, svg);
      make("text", {x: x(t), y: H - 6, "text-anchor": "middle"}, svg).textContent = `${text(t)} s`;
    }
    const clip = make("svg", {x: LEFT, y: 0, width: W - LEFT - RIGHT, height: H, viewBox: `${LEFT} 0 ${W - LEFT - RIGHT} ${H}`}, svg);
    if (band) {
      const there = [...band.time.map((t, k) => [t, band.low[k]]), ...band.time.map((t, k) => [t, band.high[k]]).reverse()];
      make("polygon", {points: there.map(([t, value]) => `${x(t).toFixed(1)},${y(value).toFixed(1)}`).join(" "), class: "band"}, clip);
    }
    for (const line of lines) {
      let path = "", pen = "M";
      line.time.forEach((t, k) => {
        if (line.values[k] === null) { pen = "M"; return; }
        path += `${pen}${x(t).toFixed(1)} ${y(line.values[k]).toFixed(1)}`;
        pen = "L";
      });
      make("path", {d: path, class: `curve ${line === run ? "" : line === ideal ? "ideal" : line === measured ? "measured" : `pinned ${line.look}`}`}, clip);
    }
    const top = run.values.reduce((best, value, k) => (Math.abs(value) > Math.abs(run.values[best]) ? k : best), 0);
    if (run.values[top] !== null && run.time[top] >= view[0] && run.time[top] <= view[1]) {
      const mark = make("circle", {cx: x(run.time[top]), cy: y(run.values[top]), r: 3.5, class: "peak"}, svg);
      make("title", {}, mark).textContent = `largest: ${text(run.values[top])} at ${text(run.time[top])} s`;
    }
    plot.y = y;
    plot.dot = make("circle", {r: 3, class: "dot"}, clip);
    plot.line = make("line", {y1: TOP, y2: H - BOTTOM, class: "cursor"}, clip);
    tell(plot);
  }
  function tell({curve, caption, line, dot, y}) {
    const unit = ["", "1"].includes(curve.unit) ? "" : ` [${curve.unit.replace("s2", "s²")}]`;
    line.setAttribute("visibility", cursor === null ? "hidden" : "visible");
    if (cursor !== null) for (const end of ["x1", "x2"]) line.setAttribute(end, x(cursor));
    const value = (of) => cursor === null || !of ? null : valueAt(of, cursor);
    const [now, exact] = [value(curve.run), value(curve.ideal)];
    dot.setAttribute("visibility", now === null ? "hidden" : "visible");
    if (now !== null) { dot.setAttribute("cx", x(cursor)); dot.setAttribute("cy", y(now)); }
    const numbers = [[now, ""], [exact, "ideal "], ...(curve.others ?? []).map((other) => [value(other), `${other.name} `])];
    caption.title = curve.name;
    caption.textContent = (curve.label ?? curve.name) + unit + (now === null ? " over time [s]" : ` at ${text(cursor)} s: `)
      + numbers.filter(([number]) => number !== null).map(([number, of]) => of + text(number)).join(", ")
      + (curve.measured ? "; dotted: measured" : "");
  }
  const show = () => plots.forEach(draw);
  function fit() { // text keeps its size in narrow columns
    const width = plots[0].svg.clientWidth, height = Math.round(high(width));
    if (!width || (width === W && height === H)) return;
    [W, H] = [width, height];
    show();
  }
  function point(time) {
    cursor = time;
    plots.forEach(tell);
  }
  function look(low, high) {
    const width = Math.min(Math.max(high - low, (to - from) * 1e-4), to - from);
    low = Math.min(Math.max(low, from), to - width);
    view = [low, low + width];
    show();
  }
  for (const {svg} of plots) {
    let start = null, moved = false;
    svg.addEventListener("wheel", (event) => {
      event.preventDefault();
      const t = timeAt(svg, event), factor = Math.exp(event.deltaY / 400);
      look(t + (view[0] - t) * factor, t + (view[1] - t) * factor);
    }, {passive: false});
    svg.addEventListener("pointerdown", (event) => { [start, moved] = [timeAt(svg, event), false]; svg.setPointerCapture(event.pointerId); });
    svg.addEventListener("pointermove", (event) => {
      const t = timeAt(svg, event);
      if (start === null) { point(t); return; }
      moved ||= Math.abs(x(t) - x(start)) > 4;
      if (moved) look(view[0] + start - t, view[1] + start - t);
    });
    svg.addEventListener("pointerup", () => { if (!moved && start !== null) { point(start); seek(start); } start = null; });
    svg.addEventListener("dblclick", () => look(from, to));
    svg.addEventListener("keydown", (event) => {
      const step = {ArrowLeft: -0.01, ArrowRight: 0.01}[event.key], factor = {"+": 0.7, "-": 1 / 0.7}[event.key], t = cursor ?? view[0];
      if (step) seek(Math.min(Math.max(t + step * (view[1] - view[0]), from), to));
      else if (factor) look(t + (view[0] - t) * factor, t + (view[1] - t) * factor);
      else if (event.key === "0") look(from, to);
      else return;
      event.preventDefault();
    });
  }
  function update(others) {
    const whole = view[0] === from && view[1] === to;
    [from, to] = span(others);
    if (whole || view[1] > to || view[0] < from) view = [from, to];
    plots.forEach((plot, k) => { plot.curve = others[k]; });
    show();
  }
  show();
  fit();
  new ResizeObserver(fit).observe(holder);
  return {point, all: () => look(from, to), update, fit};
}
function valueAt({time, values}, t) {
  let k = time.findIndex((other) => other >= t);
  if (k < 0) k = time.length - 1;
  if (k === 0 || values[k] === null || values[k - 1] === null) return values[k];
  return values[k - 1] + (values[k] - values[k - 1]) * (t - time[k - 1]) / (time[k] - time[k - 1] || 1);
}

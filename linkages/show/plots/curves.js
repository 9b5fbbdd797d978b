"use strict";
// Curves of pages, by `drawCurves`, and what their lines are, by `legend`; numbers as text, as linkages.show writes them.

const SVG = "http://www.w3.org/2000/svg";
const [LEFT, RIGHT, BOTTOM, TOP] = [52, 12, 20, 8]; // margins of a figure [px]

function svgElement(tag, attributes = {}, parent = null, text = "") {
  const node = document.createElementNS(SVG, tag);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.textContent = text;
  parent?.append(node);
  return node;
}

function number(value, digits = 4) { // as linkages.show.plots.quantities.number
  if (!Number.isFinite(value)) return "-";
  const power = value && Number(value.toExponential(digits - 1).split("e")[1]), short = Number(value.toPrecision(digits));
  if (power >= -4 && power < digits + 2) return String(short).replace("-", "−");
  const [mantissa, exponent] = (power > 0 ? short : Number(value.toPrecision(2))).toExponential().split("e");
  return `${mantissa.replace("-", "−")}e${Number(exponent)}`;
}

function valueAt({time, values}, t) {
  let k = time.findIndex((other) => other >= t);
  if (k < 0) k = time.length - 1;
  if (k === 0 || values[k] === null || values[k - 1] === null) return values[k];
  return values[k - 1] + (values[k] - values[k - 1]) * (t - time[k - 1]) / (time[k] - time[k - 1] || 1);
}

function legend(holder, curves) { // writes what the lines of some curves are into an element
  const others = new Map(curves.flatMap((curve) => (curve.others ?? []).map(({look, name}) => [`pinned ${look}`, name])));
  const kinds = [["", "run"], ["ideal", "ideal joints"], ["measured", "measured"], ...others, ["band", "90 % of the machines"]];
  const shown = kinds.filter(([kind]) => !kind || others.has(kind) || curves.some((curve) => curve[kind]));
  holder.classList.add("legend");
  holder.replaceChildren(...shown.map(([kind, text]) => {
    const item = document.createElement("span"), key = svgElement("svg", {viewBox: "0 0 24 8", width: 24, height: 8, "aria-hidden": true});
    svgElement("path", kind === "band" ? {class: "band", d: "M0 0H24V8H0Z"} : {class: `curve ${kind}`, d: "M0 4H24"}, key);
    item.append(key, ` ${text}`);
    return item;
  }));
}

function roundSteps(low, high, count) { // round numbers between two others
  const raw = (high - low) / count, unit = 10 ** Math.floor(Math.log10(raw));
  const step = unit * [1, 2, 5, 10].find((m) => m * unit >= raw), first = Math.ceil(low / step);
  return Array.from({length: Math.max(Math.floor(high / step + 1e-9) - first + 1, 0)}, (_, k) => (first + k) * step);
}

function decades(one, other) { // 1, 2 and 5 times powers of ten between two numbers of the same sign
  const [low, high] = [Math.abs(one), Math.abs(other)].sort((a, b) => a - b);
  const first = Math.floor(Math.log10(low)), count = Math.ceil(Math.log10(high)) - first;
  const all = Array.from({length: count + 1}, (_, k) => [1, 2, 5].map((m) => Math.sign(one) * m * 10 ** (first + k))).flat();
  return all.filter((value) => Math.abs(value) >= low && Math.abs(value) <= high);
}

// Draws curves into an element: ideal joints wide and pale below the run, other runs dashed, measured values dotted, a band
// shaded, a mark at the run's largest value. The wheel or + and - zoom, dragging moves, a click calls seek(time), arrow keys
// move the cursor, 0 shows the whole time; all curves share the cursor. A curve has name, unit, run, ideal, measured (each
// time and values, or null), and optionally label, others (lines with name and look, a class), band (time, low, high) and
// color, a mark of the caption. Options: high(width), the height of a figure [px]; unit of the abscissa, which may be
// logarithmic; dots at the points of the run. Returns functions: point(time) moves the cursor, all() shows all of the run,
// update(curves) draws other curves of the same names, fit() takes the size of the holder.
const usualHeight = (width) => Math.min(190, 60 + 0.3 * width);
function drawCurves(holder, curves, seek, {high = usualHeight, unit = "s", logarithmic = false, dots = false} = {}) {
  const span = (of) => [Math.min(...of.map((c) => c.run.time[0])), Math.max(...of.map((c) => c.run.time.at(-1)))];
  const scale = logarithmic ? (t) => Math.log(Math.abs(t)) : (t) => t;
  let [from, to] = span(curves), view = [from, to], cursor = null, [W, H] = [720, 190];

  holder.replaceChildren();
  const plots = curves.map((curve) => {
    const figure = document.createElement("figure"), caption = document.createElement("figcaption");
    const what = `${curve.label ?? curve.name} over ${unit === "s" ? "time" : "the value"}; arrow keys move the cursor, + and - zoom`;
    const svg = svgElement("svg", {role: "img", tabindex: 0, "aria-label": what});
    if (curve.color) Object.assign(caption.style, {boxShadow: `inset 4px 0 ${curve.color}`, paddingLeft: "8px"});
    figure.append(caption, svg);
    holder.append(figure);
    return {curve, svg, caption};
  });
  const x = (t) => LEFT + (scale(t) - scale(view[0])) / (scale(view[1]) - scale(view[0])) * (W - LEFT - RIGHT);
  const timeAt = (svg, event) => {
    const box = svg.getBoundingClientRect(), part = ((event.clientX - box.left) / box.width * W - LEFT) / (W - LEFT - RIGHT);
    return logarithmic ? view[0] * (view[1] / view[0]) ** part : view[0] + part * (view[1] - view[0]);
  };
  const inView = (t) => t >= view[0] && t <= view[1];

  function range({ideal, measured, run, others = [], band}) { // lines, and the least and largest value in view with room
    const lines = [ideal, measured, ...others, run].filter(Boolean), inside = [];
    const edges = band ? [{time: band.time, values: band.low}, {time: band.time, values: band.high}] : [];
    for (const {time, values} of [...lines, ...edges]) {
      inside.push(...values.filter((value, k) => value !== null && inView(time[k])));
      inside.push(...view.filter((t) => t >= time[0] && t <= time.at(-1)).map((t) => valueAt({time, values}, t)).filter(Number.isFinite));
    }
    const [low, top] = [Math.min(...inside), Math.max(...inside)], room = 0.06 * (top - low) || 0.5 * Math.abs(top) || 1;
    return [lines, low - room, top + room];
  }
  function path({time, values}, y) {
    let pen = "M";
    return time.map((t, k) => {
      const step = values[k] === null ? "" : `${pen}${x(t).toFixed(1)} ${y(values[k]).toFixed(1)}`;
      pen = values[k] === null ? "M" : "L";
      return step;
    }).join("");
  }
  function draw(plot) {
    const {curve, svg} = plot, {ideal, measured, run, band} = curve, [lines, low, top] = range(curve);
    const y = (value) => TOP + (top - value) / (top - low) * (H - TOP - BOTTOM), inner = W - LEFT - RIGHT;
    svg.setAttribute("viewBox", `0 0 ${W} ${H}`);
    svg.replaceChildren();
    const digits = Math.max(4, 2 + Math.ceil(Math.log10(Math.max(Math.abs(low), Math.abs(top)) / (top - low)))); // they differ
    for (const value of roundSteps(low, top, Math.max(3, H / 40))) {
      svgElement("line", {x1: LEFT, x2: W - RIGHT, y1: y(value), y2: y(value), class: "grid"}, svg);
      svgElement("text", {x: LEFT - 6, y: y(value) + 4, "text-anchor": "end"}, svg, number(value, digits));
    }
    const times = logarithmic ? decades(...view) : roundSteps(...view, W / 100);
    times.forEach((t, k) => {
      svgElement("line", {x1: x(t), x2: x(t), y1: TOP, y2: H - BOTTOM, class: "grid"}, svg);
      const last = k === times.length - 1, text = last ? `${number(t)} ${unit}` : number(t);
      svgElement("text", {x: last ? Math.min(x(t) + 12, W) : x(t), y: H - 5, "text-anchor": last ? "end" : "middle"}, svg, text);
    });
    const clip = svgElement("svg", {x: LEFT, y: 0, width: inner, height: H, viewBox: `${LEFT} 0 ${inner} ${H}`}, svg);
    if (band) {
      const edge = (values) => band.time.map((t, k) => `${x(t).toFixed(1)},${y(values[k]).toFixed(1)}`);
      svgElement("polygon", {points: [...edge(band.low), ...edge(band.high).reverse()].join(" "), class: "band"}, clip);
    }
    const look = (line) => (line === run ? "" : line === ideal ? "ideal" : line === measured ? "measured" : `pinned ${line.look}`);
    for (const line of lines) svgElement("path", {d: path(line, y), class: `curve ${look(line)}`}, clip);
    const highest = run.values.reduce((best, value, k) => (Math.abs(value) > Math.abs(run.values[best]) ? k : best), 0);
    run.time.forEach((t, k) => {
      if (run.values[k] === null || !inView(t) || !(dots || k === highest)) return;
      const mark = svgElement("circle", {cx: x(t), cy: y(run.values[k]), r: 3.5, class: dots ? "point" : "peak"}, svg);
      const value = number(run.values[k], dots ? 6 : 4);
      svgElement("title", {}, mark, dots ? `${number(t)}: ${value}` : `largest: ${value} at ${number(t)} ${unit}`);
    });
    plot.y = y;
    plot.dot = svgElement("circle", {r: 3, class: "dot"}, clip);
    plot.line = svgElement("line", {y1: TOP, y2: H - BOTTOM, class: "cursor"}, clip);
    tell(plot);
  }
  function tell({curve, caption, line, dot, y}) {
    const value = (of) => (cursor === null || !of ? null : valueAt(of, cursor)), now = value(curve.run);
    const shown = ["", "1"].includes(curve.unit) ? "" : ` [${curve.unit.replace("s2", "s²")}]`;
    line.setAttribute("visibility", cursor === null ? "hidden" : "visible");
    dot.setAttribute("visibility", now === null ? "hidden" : "visible");
    if (cursor !== null) for (const end of ["x1", "x2"]) line.setAttribute(end, x(cursor));
    if (now !== null) { dot.setAttribute("cx", x(cursor)); dot.setAttribute("cy", y(now)); }
    const others = (curve.others ?? []).map((other) => [value(other), `${other.name} `]);
    const told = [[now, ""], [value(curve.ideal), "ideal "], ...others].filter(([one]) => one !== null).map(([one, of]) => of + number(one));
    caption.title = curve.name;
    caption.textContent = (curve.label ?? curve.name) + shown + (now === null ? "" : ` at ${number(cursor)} ${unit}: ${told.join(", ")}`);
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
  function look(low, top) {
    const width = Math.min(Math.max(top - low, (to - from) * 1e-4), to - from);
    low = Math.min(Math.max(low, from), to - width);
    view = [low, low + width];
    show();
  }
  const zoom = (t, factor) => look(t + (view[0] - t) * factor, t + (view[1] - t) * factor);
  for (const {svg} of plots) {
    let start = null, moved = false;
    svg.addEventListener("wheel", (event) => {
      event.preventDefault();
      zoom(timeAt(svg, event), Math.exp(event.deltaY / 400));
    }, {passive: false});
    svg.addEventListener("pointerdown", (event) => { [start, moved] = [timeAt(svg, event), false]; svg.setPointerCapture(event.pointerId); });
    svg.addEventListener("pointermove", (event) => {
      const t = timeAt(svg, event);
      if (start === null) return point(t);
      moved ||= Math.abs(x(t) - x(start)) > 4;
      if (moved) look(view[0] + start - t, view[1] + start - t);
    });
    svg.addEventListener("pointerup", () => { if (!moved && start !== null) { point(start); seek(start); } start = null; });
    svg.addEventListener("dblclick", () => look(from, to));
    svg.addEventListener("keydown", (event) => {
      const step = {ArrowLeft: -0.01, ArrowRight: 0.01}[event.key], factor = {"+": 0.7, "-": 1 / 0.7}[event.key], t = cursor ?? view[0];
      if (step) { point(Math.min(Math.max(t + step * (view[1] - view[0]), from), to)); seek(cursor); }
      else if (factor) zoom(t, factor);
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

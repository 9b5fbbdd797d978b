// The moving picture of the machine, the magnified joints beside it, and the time that both show.

import {button, draw, g, make, marked, select} from "./dom.js";
import {unitOf} from "./words.js";

const FRAME = 100; // time between frames while a run is computed: drawing takes the same processor [ms]
const LEAST = 11; // size of names on the screen [px]
const LOOP = 4; // time in which the shown part of the run is played at the speed 1 [s]

export function machine(page) {
  const {root, at, state, send} = page;
  let shapes = [], spots = [], names = [], playing = !matchMedia("(prefers-reduced-motion: reduce)").matches, last = performance.now();
  at(".machine").append(
    make("div", {class: "picture"}),
    make("div", {class: "playback"},
      button("pause", togglePlay, "play or pause (space)"),
      make("label", {}, "speed ", select(["0.25", "0.5", "1", "2", "4"], "1")),
      make("input", {type: "range", min: 0, max: 1000, value: 0, class: "phase", "aria-label": "time"}),
      make("output", {class: "clock"})));
  tellPlay();
  at(".phase").addEventListener("input", (event) => hold(event.target.value / 1000));

  async function redraw(values) {
    const reply = await send("picture", {values});
    if (reply.error) return page.fail(reply.error);
    state.picture = reply.picture;
    if (reply.poses && state.view?.picture === reply.picture) state.view.poses = reply.poses;
    at(".picture").innerHTML = reply.svg;
    if (state.frame) { // while a pin is dragged, places stay where they are on the screen
      const {low, high, scale, width, height} = state.frame, k = reply.scale / scale;
      at(".picture svg").setAttribute("viewBox", [(low - reply.low) * reply.scale, (reply.high - high) * reply.scale, k * width, k * height].join(" "));
    }
    state.scene = reply;
    shapes = [...at(".picture").querySelectorAll("[data-at]")].map((element) =>
      [element, element.dataset.at.split(" ").map((row) => row.split(",").map(Number))]);
    names = [...at(".picture").querySelectorAll("text")].sort((a, b) => b.hasAttribute("font-weight") - a.hasAttribute("font-weight"))
      .map((text) => [text, Number(text.getAttribute("font-size"))]);
    seek(state.phase);
  }
  function drawOrbits() {
    const [unit, factor] = unitOf("m", state.units);
    spots = [];
    at(".orbits").replaceChildren(...state.view.orbits.filter((orbit) => orbit.turns).map((orbit) => {
      const pins = state.pins.map(({view, look}) => [view.orbits.find(({name}) => name === orbit.name), `orbit pinned ${look}`]);
      const paths = [...pins.filter(([one]) => one), [orbit, "orbit"]];
      const most = ({path}) => Math.max(...path[0].map((x, k) => Math.hypot(x, path[1][k])));
      const half = 1.15 * Math.min(1, 1.3 * Math.max(...paths.map(([one]) => most(one)), 1e-6));
      const top = 10 ** Math.floor(Math.log10(1.15 / half)), larger = Math.max(1, Math.floor(1.15 / half / top) * top), size = 1.15 / larger;
      const svg = draw("svg", {viewBox: `${-size} ${-size} ${2 * size} ${2 * size}`, role: "img", "aria-label": `orbit of joint ${orbit.name}`});
      svg.append(draw("circle", {r: 1, class: "clearance"}), draw("path", {d: `M${-size} 0H${size}M0 ${-size}V${size}`, class: "axes"}));
      for (const [{path}, look] of paths)
        svg.append(draw("path", {d: path[0].map((x, k) => `${k ? "L" : "M"}${x} ${-path[1][k]}`).join(""), class: look}));
      const spot = draw("circle", {r: 0.03 * size, class: "spot"});
      svg.append(spot);
      spots.push([spot, orbit.now]);
      const film = orbit.film === null ? "" : `, film ${g(factor * orbit.film, 3)} ${unit}`;
      const text = `${orbit.name}: ${g(factor * orbit.clearance, 3)} ${unit}, e/c ${g(most(orbit), 3)}${film}`;
      const caption = marked(make("figcaption", {}, larger > 1 ? `${text}; ${g(larger, 3)} ×` : text), state.start.colors[orbit.name]);
      return make("figure", {title: `joint ${orbit.name}: clearance, largest eccentricity ratio, thinnest film`}, svg, caption);
    }));
  }
  function seek(phase) {
    const {view, scene} = state;
    if (!view) return;
    state.phase = Math.min(Math.max(phase, 0), 1);
    const place = state.phase * (view.time.length - 1), k = Math.min(Math.floor(place), view.time.length - 2), part = place - k;
    const mix = (a, b) => a + part * (b - a);
    if (scene && k >= 0 && view.picture === state.picture && view.poses?.length) {
      const pose = view.poses[k].map((row, body) => row.map((value, j) => mix(value, view.poses[k + 1][body][j])));
      placeShapes(shapes, pose, scene);
      placeNames(names);
    }
    for (const [spot, [x, y]] of spots) {
      if (k < 0 || !x.length) continue;
      spot.setAttribute("cx", mix(x[k], x[k + 1]));
      spot.setAttribute("cy", -mix(y[k], y[k + 1]));
    }
    const time = state.phase * (view.to - view.from);
    at(".phase").value = 1000 * state.phase;
    at(".clock").value = `${g(time, 4)} s`;
    state.plots?.point(time);
  }
  function hold(phase) {
    playing = false;
    tellPlay();
    seek(phase);
  }
  function togglePlay() { playing = !playing; tellPlay(); }
  function tellPlay() { at(".playback button").textContent = playing ? "pause" : "play"; }
  function animate(now) {
    if (!root.isConnected) return;
    requestAnimationFrame(animate);
    if (state.busy && now - last < FRAME) return;
    const passed = Math.min(now - last, 2 * FRAME) / 1e3;
    last = now;
    if (!playing || !state.view) return;
    const next = state.phase + passed / LOOP * Number(at(".playback select").value);
    seek(next > 1 ? next - 1 : next);
  }
  for (const event of ["shown", "units", "pinned"]) root.addEventListener(event, () => { if (state.view) { drawOrbits(); seek(state.phase); } });
  root.addEventListener("ready", () => requestAnimationFrame(animate));
  return {redraw, hold, togglePlay};
}

function placeNames(names) { // readable in a small picture; one that lies on another is hidden, those of joints are seen first
  const seen = [], scale = names[0]?.[0].getScreenCTM()?.a ?? 1;
  for (const [text, size] of names) {
    const wanted = `${Math.max(size, LEAST / scale).toFixed(1)}px`;
    if (text.style.fontSize !== wanted) text.style.fontSize = wanted;
  }
  for (const [text] of names) {
    const box = text.getBoundingClientRect();
    const hidden = seen.some((other) => box.left < other.right && other.left < box.right && box.top < other.bottom && other.top < box.bottom);
    text.style.visibility = hidden ? "hidden" : "";
    if (!hidden) seen.push(box);
  }
}
function placeShapes(shapes, pose, {low, high, scale}) {
  for (const [element, rows] of shapes) {
    const points = rows.map(([body, x, y, dx, dy]) => {
      const [px, py, angle] = pose[body], c = Math.cos(angle), s = Math.sin(angle);
      return [(px + c * x - s * y + dx - low) * scale, (high - (py + s * x + c * y + dy)) * scale];
    });
    if (element.points) element.setAttribute("points", points.map((p) => p.map((v) => v.toFixed(2)).join(",")).join(" "));
    else for (const [k, axis] of ["x", "y"].entries())
      element.setAttribute(element.tagName === "circle" ? `c${axis}` : axis, points[0][k].toFixed(2));
  }
}

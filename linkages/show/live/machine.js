// The moving picture of the machine, the magnified joints beside it, and the time that both show.

import {number, placeShapes, shapesOf, svgElement} from "./curves.js";
import {button, make, marked, scaled, select} from "./dom.js";

const FRAME = 100; // time between frames while a run is computed: drawing takes the same processor [ms]
const LEAST = 11; // size of names on the screen [px]
const LOOP = 4; // time in which the shown part of the run is played at the speed 1 [s]
const JOURNAL = 0.7; // radius of a journal in the picture of its joint, over the clearance
const INSET = 4, SIDE = 1.1; // times from which an orbit is magnified in a corner, whose size this is, over the clearance

export function machine(page) {
  const {root, at, state, send} = page;
  let shapes = [], moving = [], names = [], playing = !matchMedia("(prefers-reduced-motion: reduce)").matches, last = performance.now();
  const speed = select(["0.25", "0.5", "1", "2", "4"], "1", "speed of the picture");
  const slider = make("input", {type: "range", min: 0, max: 1000, value: 0, class: "phase", "aria-label": "time"});
  const player = button("pause", togglePlay, "play or pause (space)"), clock = make("output", {class: "clock"});
  at(".machine").append(make("div", {class: "picture"}), make("div", {class: "playback"}, player, speed, slider, clock));
  slider.addEventListener("input", () => hold(slider.value / 1000));
  tellPlay();

  async function redraw(values) {
    const reply = await send("picture", {values});
    if (reply.error) return page.fail(reply.error);
    state.picture = reply.picture;
    if (reply.poses && state.view?.picture === reply.picture) state.view.poses = reply.poses;
    at(".picture").innerHTML = reply.svg;
    const svg = at(".picture svg");
    if (state.frame) { // while a pin is dragged, places stay where they are on the screen
      const {low, high, scale, width, height} = state.frame, k = reply.scale / scale;
      svg.setAttribute("viewBox", [(low - reply.low) * reply.scale, (reply.high - high) * reply.scale, k * width, k * height].join(" "));
    }
    state.scene = reply;
    shapes = shapesOf(svg);
    names = [...svg.querySelectorAll("text")].sort((a, b) => b.hasAttribute("font-weight") - a.hasAttribute("font-weight"))
      .map((text) => [text, Number(text.getAttribute("font-size"))]);
    seek(state.phase);
  }
  function drawOrbits() {
    moving = [];
    at(".orbits").replaceChildren(...state.view.orbits.filter(({turns}) => turns).map((orbit) => {
      const pins = state.pins.map(({view, look}) => [view.orbits.find(({name}) => name === orbit.name), `orbit pinned ${look}`]);
      return drawOrbit(orbit, [...pins.filter(([one]) => one), [orbit, "orbit"]]);
    }));
  }
  function drawOrbit(orbit, paths) { // bearing, journal and the path of its centre, in parts of the clearance; a bar of one clearance
    const [unit, factor] = page.unitOf("m"), most = Math.max(...paths.map(([one]) => farthest(one))), length = `${number(factor * orbit.clearance, 3)} ${unit}`;
    const half = 1.04 * (Math.max(1, most) + JOURNAL), size = 0.17 * half, box = `${-half} ${-half} ${2 * half} ${2 * half + 1.6 * size}`;
    const svg = svgElement("svg", {viewBox: box, role: "img", "aria-label": `orbit of joint ${orbit.name}`});
    const draw = (tag, attributes, into = svg, text = "") => svgElement(tag, attributes, into, text);
    const put = (into) => paths.forEach(([one, look]) => draw("path", {d: pathOf(one.path), class: look}, into));
    draw("circle", {r: 1 + JOURNAL, class: "bearing"});
    const journal = draw("circle", {r: JOURNAL, class: "journal"});
    draw("circle", {r: 1, class: "clearance"});
    put(svg);
    const spot = draw("circle", {r: 0.04 * half, class: "spot"});
    draw("path", {d: `M${-half} ${half + 0.7 * size}h1`, class: "scale"});
    draw("text", {x: 1.1 - half, y: half + size, "font-size": size}, svg, length);
    moving.push([[journal, spot], orbit.now]);
    const {x, y, larger} = corner(paths);
    if (larger >= INSET) { // a small orbit is seen in the corner
      const place = {x: half - SIDE, y: -half, width: SIDE, height: SIDE}, part = SIDE / larger;
      draw("rect", {...place, class: "inset"});
      put(draw("svg", {...place, viewBox: `${x - part / 2} ${y - part / 2} ${part} ${part}`}));
      draw("text", {x: half, y: half + size, "font-size": size, "text-anchor": "end"}, svg, `corner: ${number(larger)} ×`);
    }
    const film = orbit.film === null ? "" : `, film ${number(scaled(factor, orbit.film), 3)} ${unit}`;
    const caption = make("figcaption", {}, `${orbit.name}: ${length}, e/c ${number(farthest(orbit), 3)}${film}`);
    return make("figure", {title: `joint ${orbit.name}: clearance, largest eccentricity ratio, thinnest film`}, svg, marked(caption, state.start.colors[orbit.name]));
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
    for (const [circles, [x, y]] of moving) {
      if (k >= 0 && x.length) for (const circle of circles) {
        circle.setAttribute("cx", mix(x[k], x[k + 1]));
        circle.setAttribute("cy", -mix(y[k], y[k + 1]));
      }
    }
    const time = state.phase * (view.to - view.from);
    slider.value = 1000 * state.phase;
    clock.value = `${number(time)} s`;
    state.plots?.point(time);
  }
  function hold(phase) {
    playing = false;
    tellPlay();
    seek(phase);
  }
  function togglePlay() { playing = !playing; tellPlay(); }
  function tellPlay() { player.textContent = playing ? "pause" : "play"; }
  function animate(now) {
    if (!root.isConnected) return;
    requestAnimationFrame(animate);
    if (state.busy && now - last < FRAME) return;
    const passed = Math.min(now - last, 2 * FRAME) / 1e3, next = state.phase + passed / LOOP * Number(speed.value);
    last = now;
    if (playing && state.view) seek(next > 1 ? next - 1 : next);
  }
  for (const event of ["shown", "units", "pinned"]) root.addEventListener(event, () => { if (state.view) { drawOrbits(); seek(state.phase); } });
  root.addEventListener("ready", () => requestAnimationFrame(animate));
  return {redraw, hold, togglePlay};
}

const farthest = ({path: [x, y]}) => Math.max(...x.map((value, k) => Math.hypot(value, y[k])));
const pathOf = ([x, y]) => x.map((value, k) => `${k ? "L" : "M"}${value} ${-y[k]}`).join("");
function corner(paths) { // the middle of some orbits, and a round number of times with which they fill the corner
  const [[left, right], [low, high]] = [0, 1].map((k) => paths.flatMap(([one]) => one.path[k])).map((of) => [Math.min(...of), Math.max(...of)]);
  const times = SIDE / (1.2 * Math.max(right - left, high - low, 1e-6)), unit = 10 ** Math.floor(Math.log10(times));
  return {x: (left + right) / 2, y: -(low + high) / 2, larger: Math.floor(times / unit) * unit};
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
    for (const part of [text, text.previousElementSibling?.closest(".mark")]) if (part) part.style.visibility = hidden ? "hidden" : "";
    if (!hidden) seen.push(box);
  }
}

// The live page: controls, a moving picture, orbits, curves and a table of one machine.
// mount(root, send) builds it into an element; send(kind, request) returns the promise of a reply.

import {drawCurves} from "./curves.js";
import {explore} from "./explore.js";
import {joints} from "./joints.js";
import {button, draw, g, make, percent, select} from "./dom.js";

const RETRIES = 12; // runs after a change until the motion is steady
const SHARE = 0.1; // most of the time that picture and table take while values change
const SLOW = 400; // time after which a run is slow: what is shown becomes pale [ms]
const REST = 400; // time without a change after which warnings are computed [ms]
const FRAME = 100; // time between frames while a run is computed: drawing takes the same processor [ms]
const LOOP = 4; // time in which the shown part of the run is played at the speed 1 [s]

export function mount(root, ask) {
  const page = crypto.getRandomValues(new Uint32Array(3)).join("-"); // the server keeps the runs of pages apart
  const send = (kind, request) => ask(kind, {...request, page});
  const state = {
    began: null, start: null, controls: new Map(), shown: [], values: {}, past: [], future: [], view: null, pinned: null,
    picture: null, wanted: null, busy: false, tries: 0, next: 0, playing: true, phase: 0, plots: null, names: "",
  };
  root.replaceChildren();
  root.append(
    make("header", {}, make("h1"), make("span", {class: "state", role: "status"}), make("div", {class: "buttons"}), make("div", {class: "tools"})),
    make("p", {class: "error", role: "alert", hidden: ""}),
    make("div", {class: "columns"},
      make("section", {class: "machine", "aria-label": "machine"},
        make("div", {class: "picture"}),
        make("div", {class: "playback"},
          button("pause", togglePlay, "space"),
          make("label", {}, "speed ", select(["0.25", "0.5", "1", "2", "4"], "1")),
          make("input", {type: "range", min: 0, max: 1000, value: 0, class: "phase", "aria-label": "time"}),
          make("output", {class: "clock"})),
        make("div", {class: "orbits"})),
      make("section", {class: "controls", "aria-label": "values"},
        make("div", {class: "rows"}),
        make("form", {class: "search"},
          make("label", {}, "further value ", make("input", {list: "paths", placeholder: "part of its path"})),
          make("datalist", {id: "paths"}), make("button", {type: "submit"}, "show")))),
    make("div", {class: "below"},
      make("section", {class: "numbers", "aria-label": "peaks"}, make("table"), make("ul", {class: "said"})),
      make("section", {class: "curves", "aria-label": "curves"}, make("button", {type: "button"}, "whole time"), make("div"))),
    make("dialog", {}, make("form", {method: "dialog"})),
  );
  const at = (selector) => root.querySelector(selector);
  const buttons = {
    pin: button("pin", pin, "keep this run for comparison (p)"), unpin: button("unpin", unpin, "forget the pinned run"),
    undo: button("undo", undo, "Ctrl+Z"), redo: button("redo", redo, "Ctrl+Shift+Z"),
    reset: button("reset", reset, "all values of the file"),
    save: button("save", () => write("save"), "write an experiment file"),
    export: button("export", () => write("export"), "write the folder of linkages simulate"),
    link: button("link", copyLink, "copy an address that restores all values"),
  };
  at(".buttons").append(...Object.values(buttons));
  for (const name of ["unpin", "undo", "redo"]) buttons[name].disabled = true;
  at(".search").addEventListener("submit", (event) => {
    event.preventDefault();
    const field = at(".search input"), text = field.value.trim().toLowerCase();
    const found = [...state.controls.values()].find((c) => c.path.toLowerCase() === text)
      ?? [...state.controls.values()].find((c) => c.path.toLowerCase().includes(text) && !state.shown.includes(c.path));
    if (!text || !found) return complain(`no value has "${field.value}" in its path`);
    complain("");
    field.value = "";
    show(found.path);
    at(`[data-path="${CSS.escape(found.path)}"] input, [data-path="${CSS.escape(found.path)}"] select`).focus();
  });
  at(".curves button").addEventListener("click", () => state.plots?.all());
  at(".phase").addEventListener("input", (event) => { state.playing = false; tellPlay(); seek(event.target.value / 1000); });
  (root.dataset.server ? document : root).addEventListener("keydown", (event) => {
    const typing = event.target.matches("input:not([type=range]), select, textarea");
    const key = event.key.toLowerCase(), control = event.ctrlKey || event.metaKey;
    if (control && (key === "y" || (key === "z" && event.shiftKey))) redo();
    else if (control && key === "z") undo();
    else if (!typing && !control && key === " " && !event.target.matches("button")) togglePlay();
    else if (!typing && !control && key === "p") pin();
    else return;
    event.preventDefault();
  });

  // -- values ----------------------------------------------------------------------------------------------------------

  const valueOf = (path) => state.values[path] ?? state.controls.get(path).value;

  function change(values, remember = true) {
    const changes = Object.entries(values).filter(([path, value]) => value !== valueOf(path));
    if (!changes.length) return;
    if (remember) { state.past.push({...state.values}); state.future = []; }
    state.values = {...state.values, ...Object.fromEntries(changes)};
    for (const [path, value] of changes) {
      if (value === state.controls.get(path).value) delete state.values[path];
      tell(path);
    }
    changed();
  }
  function restore(values, from, to) {
    to.push({...state.values});
    state.values = values;
    changed();
    state.shown.forEach((path) => tell(path));
  }
  function apply(values, controls = []) { // all values at once
    for (const control of controls) state.controls.set(control.path, control);
    state.future = [];
    restore({...values}, null, state.past);
    controls.forEach(({path}) => show(path));
  }
  function undo() { if (state.past.length) restore(state.past.pop(), state.past, state.future); }
  function redo() { if (state.future.length) restore(state.future.pop(), state.future, state.past); }
  function reset() {
    state.past.push({...state.values});
    state.future = [];
    state.values = {};
    changed(true);
    state.shown.forEach((path) => tell(path));
  }
  function changed(restart = false) {
    state.tries = 0;
    state.wanted = {restart};
    buttons.undo.disabled = !state.past.length;
    buttons.redo.disabled = !state.future.length;
    pump();
  }

  // -- runs: one at a time, always the latest values ---------------------------------------------------------------------

  async function pump() {
    if (state.busy) return;
    state.busy = true;
    clearTimeout(state.resting);
    root.setAttribute("aria-busy", "true");
    while (state.wanted) {
      const {restart} = state.wanted, values = {...state.values};
      state.wanted = null;
      state.began = performance.now();
      const slow = setInterval(tellSlow, SLOW);
      try {
        const reply = await send("run", {values, restart});
        state.began = null;
        if (reply.error) fail(reply.error);
        else if (reply.outdated) state.wanted = {restart: restart || Boolean(state.wanted?.restart)};
        else {
          fail("");
          display(reply);
          if (!reply.settled && !state.wanted && ++state.tries < RETRIES) state.wanted = {restart: false};
          if (!state.wanted || performance.now() > state.next) await complete(values);
        }
      } catch (problem) {
        fail(`the server does not answer (${problem.message}); is the command still running? The picture is the last one.`);
      }
      state.began = null;
      clearInterval(slow);
    }
    state.busy = false;
    root.setAttribute("aria-busy", "false");
    clearTimeout(state.resting);
    state.resting = setTimeout(warn, REST);
  }
  async function complete(values) { // picture and table can take longer than curves: they get a part of the time
    const {view} = state, began = performance.now();
    if (view.picture !== state.picture) await redraw(values);
    const reply = await send("numbers", {});
    state.next = performance.now() + (performance.now() - began) / SHARE;
    if (reply.error) return fail(reply.error);
    Object.assign(view, reply);
    drawNumbers();
    root.dispatchEvent(new CustomEvent("counted"));
  }
  async function warn() { // some warnings take longer than a run: they wait until nothing is changed
    const {view} = state;
    try {
      const {warnings} = await send("warnings", {});
      if (state.view === view && !state.busy) at(".said").append(...warnings.map(({text}) => make("li", {class: "warning"}, text)));
    } catch { /* the run before has reported the failure */ }
  }
  async function tellSlow() {
    const {began} = state;
    if (began === null) return;
    root.classList.add("waiting");
    try {
      if (state.wanted && performance.now() - began > 2 * SLOW) await send("stop", {}); // newer values wait
      const {said} = await send("status", {});
      if (state.began === began) at(".state").textContent = said || "computing ...";
    } catch { /* the request that runs will say it */ }
  }
  async function redraw(values) {
    const reply = await send("picture", {values});
    if (reply.error) return fail(reply.error);
    state.picture = reply.picture;
    if (reply.poses && state.view.picture === reply.picture) state.view.poses = reply.poses;
    at(".picture").innerHTML = reply.svg;
    state.scene = reply;
    state.shapes = [...at(".picture").querySelectorAll("[data-at]")].map((element) =>
      [element, element.dataset.at.split(" ").map((row) => row.split(",").map(Number))]);
    seek(state.phase);
    root.dispatchEvent(new CustomEvent("drawn"));
  }
  function complain(text) {
    if (!text && root.classList.contains("stale")) return; // the reason is still shown
    at(".error").textContent = text;
    at(".error").hidden = !text;
  }
  function fail(text) { // what is shown belongs to other values
    root.classList.toggle("stale", Boolean(text));
    complain(text);
    root.classList.remove("waiting");
    if (text) at(".state").textContent = "not computed";
  }

  // -- what is shown -----------------------------------------------------------------------------------------------------

  function display(view) {
    state.view = view;
    for (const [path, value] of Object.entries(view.numbers)) tell(path, value);
    const kind = !view.settled ? "settling" : view.periodic ? "periodic" : "not periodic";
    at(".state").textContent = view.status === "ok" ? `${kind}; computed in ${Math.max(1, Math.round(1e3 * view.took))} ms` : `${view.status}: ${view.remedy}`;
    at(".numbers").classList.toggle("older", !view.table);
    if (view.table) drawNumbers();
    drawLines();
    drawOrbits();
    seek(state.phase);
    root.dispatchEvent(new CustomEvent("shown"));
  }
  function drawLines() {
    const {view, pinned} = state, of = new Map((pinned?.curves ?? []).map((curve) => [curve.name, curve.run]));
    const curves = view.curves.map((curve) => ({...curve, pinned: of.get(curve.name)}));
    const names = curves.map((curve) => curve.name).join(" ");
    if (state.plots && names === state.names) state.plots.update(curves);
    else if (curves.length) {
      state.plots = drawCurves(at(".curves div"), curves, (time) => { state.playing = false; tellPlay(); seek(time / (view.to - view.from)); });
      state.names = names;
    }
  }
  function drawNumbers() {
    const {view, pinned} = state, before = new Map((pinned?.table ?? []).map((row) => [row.name, row.value]));
    at(".numbers").classList.remove("older");
    at(".said").replaceChildren(...view.motion.map((text) => make("li", {}, text)));
    const spread = view.table.some((row) => row.least !== null);
    const heads = ["peak of", "unit", "ideal", "now", "to ideal", ...(spread ? ["single periods"] : []), ...(pinned ? ["pinned", "to pinned"] : [])];
    const rows = view.table.map((row) => {
      const old = before.get(row.name) ?? null, ends = row.least === null ? "" : `${g(row.least)} to ${g(row.most)}`;
      const cells = [row.name, row.unit === "1" ? "" : row.unit.replace("s2", "s²"), g(row.ideal), g(row.value), percent(row.value, row.ideal)];
      if (spread) cells.push(ends);
      if (pinned) cells.push(g(old), percent(row.value, old));
      return make("tr", {"data-name": row.name}, ...cells.map((cell, k) => make(k ? "td" : "th", k ? {} : {scope: "row"}, cell)));
    });
    at(".numbers table").replaceChildren(
      make("thead", {}, make("tr", {}, ...heads.map((head) => make("th", {scope: "col"}, head)))), make("tbody", {}, ...rows));
    buttons.unpin.disabled = !pinned;
  }
  function drawOrbits() {
    const old = new Map((state.pinned?.orbits ?? []).map((orbit) => [orbit.name, orbit]));
    state.spots = [];
    at(".orbits").replaceChildren(...state.view.orbits.filter((orbit) => orbit.turns).map((orbit) => {
      const paths = [old.get(orbit.name), orbit].filter(Boolean);
      const reach = Math.max(...paths.flatMap(({path}) => path[0].map((x, k) => Math.hypot(x, path[1][k]))), 1e-6);
      const half = 1.15 * Math.min(1, 1.3 * reach), top = 10 ** Math.floor(Math.log10(1.15 / half));
      const factor = Math.max(1, Math.floor(1.15 / half / top) * top), size = 1.15 / factor;
      const svg = draw("svg", {viewBox: `${-size} ${-size} ${2 * size} ${2 * size}`, role: "img", "aria-label": `orbit of joint ${orbit.name}`});
      svg.append(draw("circle", {r: 1, class: "clearance"}), draw("path", {d: `M${-size} 0H${size}M0 ${-size}V${size}`, class: "axes"}));
      for (const {path} of paths) {
        const d = path[0].map((x, k) => `${k ? "L" : "M"}${x} ${-path[1][k]}`).join("");
        svg.append(draw("path", {d, class: path === orbit.path ? "orbit" : "orbit pinned"}));
      }
      const spot = draw("circle", {r: 0.03 * size, class: "spot"});
      svg.append(spot);
      state.spots.push([spot, orbit.now]);
      const text = `${orbit.name}: clearance ${g(1e3 * orbit.clearance, 3)} mm, e/c up to ${g(Math.max(...orbit.path[0].map((x, k) => Math.hypot(x, orbit.path[1][k]))), 3)}`;
      return make("figure", {}, svg, make("figcaption", {}, factor > 1 ? `${text}; enlarged ${g(factor, 3)} times` : text));
    }));
  }
  function seek(phase) {
    const {view, scene} = state;
    if (!view) return;
    state.phase = Math.min(Math.max(phase, 0), 1);
    const place = state.phase * (view.time.length - 1), k = Math.min(Math.floor(place), view.time.length - 2), part = place - k;
    const mix = (a, b) => a + part * (b - a);
    if (scene && k >= 0 && view.picture === state.picture && view.poses) {
      const pose = view.poses[k].map((row, body) => row.map((value, j) => mix(value, view.poses[k + 1][body][j])));
      placeShapes(state.shapes, pose, scene);
    }
    for (const [spot, [x, y]] of state.spots ?? []) {
      spot.setAttribute("cx", mix(x[k], x[k + 1]));
      spot.setAttribute("cy", -mix(y[k], y[k + 1]));
    }
    const time = state.phase * (view.to - view.from);
    at(".phase").value = 1000 * state.phase;
    at(".clock").value = `${g(time, 4)} s`;
    state.plots?.point(time);
  }
  function togglePlay() { state.playing = !state.playing; tellPlay(); }
  function tellPlay() { at(".playback button").textContent = state.playing ? "pause" : "play"; }
  let last = performance.now();
  function animate(now) {
    if (!root.isConnected) return;
    requestAnimationFrame(animate);
    if (state.busy && now - last < FRAME) return;
    const passed = Math.min(now - last, 2 * FRAME) / 1e3;
    last = now;
    if (state.playing && state.view) {
      const next = state.phase + passed / LOOP * Number(at(".playback select").value);
      seek(next > 1 ? next - 1 : next);
    }
  }

  // -- controls ----------------------------------------------------------------------------------------------------------

  function show(path) {
    if (state.shown.includes(path)) return;
    state.shown.push(path);
    const control = state.controls.get(path), row = make("div", {class: "row", "data-path": path});
    row.append(make("label", {for: `value-${path}`}, path));
    if (control.choices.length) {
      const field = select(control.choices, valueOf(path));
      field.id = `value-${path}`;
      field.addEventListener("change", () => change({[path]: field.value}));
      row.append(field);
    } else {
      const field = make("input", {id: `value-${path}`, class: "typed", inputmode: "text", autocomplete: "off", title: `a number, or one with a unit; the file has ${g(control.value)} ${control.unit}`});
      const slider = make("input", {type: "range", min: 0, max: 1000, "aria-label": `${path}, slider`});
      let began = null;
      slider.addEventListener("input", () => {
        if (began === null) { began = true; state.past.push({...state.values}); state.future = []; }
        change({[path]: fromSlider(control, slider.value)}, false);
      });
      slider.addEventListener("change", () => { began = null; });
      field.addEventListener("change", () => {
        const text = field.value.trim(), number = Number(text);
        if (text) change({[path]: Number.isFinite(number) ? number : text});
        tell(path);
      });
      const ends = make("span", {class: "ends"}, make("span", {}, g(control.low, 3)), make("span", {}, g(control.high, 3)));
      row.append(field, make("span", {class: "unit"}, control.unit === "1" ? "" : control.unit.replace("s2", "s²")), make("div", {class: "slider"}, slider, ends));
    }
    at(".rows").append(row);
    tell(path);
  }
  function tell(path, number = null) {
    const row = at(`[data-path="${CSS.escape(path)}"]`);
    if (!row) return;
    const control = state.controls.get(path), value = valueOf(path);
    row.classList.toggle("changed", path in state.values);
    if (control.choices.length) { row.querySelector("select").value = value; return; }
    const field = row.querySelector(".typed"), slider = row.querySelector("[type=range]");
    if (number === null) field.value = typeof value === "number" ? g(value, 6) : value;
    const known = number ?? value;
    if (typeof known === "number") slider.value = toSlider(control, known);
  }

  // -- keeping -----------------------------------------------------------------------------------------------------------

  function pin() {
    if (!state.view) return;
    state.pinned = state.view;
    display(state.view);
  }
  function unpin() { state.pinned = null; if (state.view) display(state.view); }
  async function copyLink() {
    const address = linkOf(state.values);
    globalThis.history?.replaceState(null, "", address);
    try { await navigator.clipboard.writeText(address); note("the address of these values is copied"); }
    catch { note(`the address bar has these values: ${address}`); }
  }
  function note(text) { at(".state").textContent = text; }
  function write(kind) {
    const dialog = at("dialog"), form = dialog.querySelector("form");
    const name = make("input", {value: state.start.name, "aria-label": "name"}), replace = make("input", {type: "checkbox"});
    const what = kind === "save" ? "Write the experiment file" : "Write the experiment file and, by linkages simulate, the folder of its results";
    form.replaceChildren(
      make("p", {}, `${what} in ${state.start.folder}:`), make("label", {}, "name ", name), make("label", {}, replace, " replace a file of this name"),
      make("div", {class: "buttons"}, button("cancel", () => dialog.close(), "write nothing"), make("button", {value: "write"}, kind)));
    dialog.addEventListener("close", async () => {
      if (dialog.returnValue !== "write") return;
      note(kind === "save" ? "saving ..." : "exporting ...");
      try {
        const reply = await send(kind, {values: state.values, name: name.value, replace: replace.checked});
        complain(reply.error ?? "");
        note(reply.error ? "not written" : `written: ${reply.written}; ${reply.command}`);
      } catch (problem) { complain(`the server does not answer (${problem.message})`); }
    }, {once: true});
    dialog.returnValue = "";
    dialog.showModal();
    name.select();
  }

  // -- start -------------------------------------------------------------------------------------------------------------

  const api = {root, at, send, state, valueOf, change, show, apply, note, complain, make, button, select, g};
  joints(api);
  explore(api);
  (async () => {
    try {
      state.start = await send("start", {});
    } catch (problem) { return fail(`the server does not answer (${problem.message})`); }
    if (state.start.error) return fail(state.start.error);
    at("h1").textContent = state.start.title;
    if (root.dataset.server) document.title = `${state.start.file} - linkages play`;
    state.controls = new Map(state.start.controls.map((control) => [control.path, control]));
    at("#paths").replaceChildren(...state.start.controls.map(({path}) => make("option", {value: path})));
    state.values = root.dataset.server ? valuesOf(location.hash, state.controls) : {};
    state.start.controls.filter(({first, path}) => first || path in state.values).forEach(({path}) => show(path));
    root.dispatchEvent(new CustomEvent("ready"));
    changed();
    requestAnimationFrame(animate);
  })();
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
function linkOf(values) {
  const address = new URL(location.href);
  address.hash = Object.keys(values).length ? encodeURIComponent(JSON.stringify(values)) : "";
  return address.href;
}
function valuesOf(hash, controls) {
  try {
    const found = JSON.parse(decodeURIComponent(hash.slice(1)) || "{}");
    return Object.fromEntries(Object.entries(found).filter(([path]) => controls.has(path)));
  } catch { return {}; }
}
function fromSlider({low, high, logarithmic, whole}, place) {
  const part = place / 1000, value = logarithmic ? low * (high / low) ** part : low + (high - low) * part;
  return whole ? Math.round(value) : Number(value.toPrecision(4));
}
function toSlider({low, high, logarithmic}, value) {
  const part = logarithmic ? Math.log(Math.max(value, 1e-300) / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(1000 * Math.min(Math.max(part, 0), 1));
}
// -- the page, and the widget of a notebook --------------------------------------------------------------------------------

const page = globalThis.document?.querySelector("main[data-server]");
if (page) {
  mount(page, async (kind, request) => {
    const reply = await fetch(kind, {method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify(request)});
    if (!reply.ok) throw new Error(`${reply.status} ${reply.statusText}`);
    return reply.json();
  });
}

export default {
  render({model, el}) {
    const waiting = new Map();
    let count = 0;
    model.on("msg:custom", ({n, reply}) => { waiting.get(n)?.(reply); waiting.delete(n); });
    const holder = make("div", {class: "linkages-live"});
    el.append(holder);
    mount(holder, (kind, request) => ["status", "stop"].includes(kind) ? Promise.resolve({said: ""}) : new Promise((done) => {
      const n = `${request.page} ${++count}`; // all views of the model hear each reply
      waiting.set(n, done);
      model.send({n, kind, request});
    }));
  },
};

// The live page: controls, a moving picture, magnified joints, curves and a table of one machine.
// mount(root, answer) builds it into an element; answer(kind, request) returns the promise of a reply.

import {charts} from "./charts.js";
import {controls} from "./controls.js";
import {number} from "./curves.js";
import {button, make} from "./dom.js";
import {explore} from "./explore.js";
import {joints} from "./joints.js";
import {layout} from "./layout.js";
import {machine} from "./machine.js";
import {numbers} from "./numbers.js";
import {panel} from "./panel.js";
import {runs} from "./runs.js";

const RETRIES = 12; // runs after a change until the motion is steady
const SHARE = 0.1; // most of the time that picture and table take while values change
const SLOW = 400; // time after which a run is slow: what is shown becomes pale [ms]
const REST = 400; // time without a change after which warnings are computed [ms]

export function mount(root, answer) {
  const own = crypto.getRandomValues(new Uint32Array(3)).join("-"), served = Boolean(root.dataset.server);
  const send = (kind, request) => answer(kind, {...request, page: own}); // the server keeps the runs of pages apart
  const state = { // limits: {least, value [SI]} by output
    limits: {}, began: null, since: null, start: null, controls: new Map(), shown: [], values: {}, past: [], future: [], view: null, pins: [],
    units: {}, picture: null, wanted: null, busy: false, refining: false, tries: 0, next: 0, phase: 0, plots: null, bands: null, frame: null,
  };
  const at = (selector) => root.querySelector(selector), section = (name, label) => make("section", {class: name, "aria-label": label});
  const announce = (event) => root.dispatchEvent(new CustomEvent(event));
  root.replaceChildren(
    make("header", {}, make("h1"), make("div", {class: "settings"}),
      make("div", {class: "bar"}, make("div", {class: "buttons"}), make("div", {class: "buttons tools"}), make("span", {class: "state", role: "status"}))),
    make("p", {class: "error", role: "alert", hidden: ""}),
    make("div", {class: "layout"},
      make("div", {class: "side"}, make("section", {class: "panel", hidden: ""}), section("controls", "values")),
      make("div", {class: "stage"}, section("machine", "machine"), section("orbits", "joints")),
      section("curves", "curves"), section("numbers", "peaks")));
  const page = {root, at, send, state, ask, valueOf, labelOf, unitOf, change, apply, note, complain, fail, keep};
  layout(page);
  for (const part of [panel, controls, machine, numbers]) Object.assign(page, part(page));
  page.find = (text) => { at(".search input").value = text; at(".search input").dispatchEvent(new Event("input")); at(".search input").focus(); };
  charts(page);
  const buttons = {
    pin: button("pin", page.pin, "keep this run for comparison (p)"),
    undo: button("undo", () => step(-1), "Ctrl+Z, or back"), redo: button("redo", () => step(1), "Ctrl+Shift+Z, or forward"),
    reset: button("reset", () => { state.future = []; restore({}, state.past, true); visit(); }, "all values of the file"),
    save: button("save", () => write("save", "an experiment file"), "write an experiment file"),
    export: button("export", () => write("export", "an experiment file, and the folder of its results"), "write the folder of linkages simulate"),
    link: button("link", copyLink, "copy an address that restores all values"),
  };
  if (!served) delete buttons.link; // the address is a notebook's
  at(".buttons").append(...Object.values(buttons));
  for (const part of [runs, joints, explore]) part(page);
  (served ? document : root).addEventListener("keydown", (event) => {
    const typing = event.target.matches("input:not([type=range]), select, textarea"), control = event.ctrlKey || event.metaKey, key = event.key.toLowerCase();
    if (control && (key === "y" || (key === "z" && event.shiftKey))) step(1);
    else if (control && key === "z") step(-1);
    else if (!typing && !control && key === " " && !event.target.matches("button")) page.togglePlay();
    else if (!typing && !control && key === "p") page.pin();
    else return;
    event.preventDefault();
  });

  // -- values; `past` and `future` have those of the steps of undo and redo, and the browser's history their addresses

  function valueOf(path) { return state.values[path] ?? fileValue(path); }
  function fileValue(path) { return state.controls.get(path)?.value ?? null; }
  function labelOf(path) { return state.controls.get(path)?.label ?? path; }
  function unitOf(si) { // unit as text, and how many of it are one SI unit
    return state.units[si] ?? [si === "1" ? "" : si.replace("degC", "°C").replace(/2\b/g, "²").replace(/3\b/g, "³"), 1];
  }
  function change(values, remember = true) {
    const changes = Object.entries(values).filter(([path, value]) => value !== valueOf(path));
    if (!changes.length) return;
    if (remember) { state.past.push({...state.values}); state.future = []; }
    state.values = {...state.values, ...Object.fromEntries(changes)};
    for (const [path, value] of changes) {
      if (value === fileValue(path)) delete state.values[path];
      page.tell(path);
    }
    changed();
    if (remember) visit();
  }
  function restore(values, to, restart = false) {
    to.push({...state.values});
    state.values = {...values};
    changed(restart);
    state.shown.forEach((path) => page.tell(path));
  }
  function apply(values, added = []) { // all values at once
    for (const control of added) state.controls.set(control.path, control);
    state.future = [];
    restore(values, state.past);
    visit();
    added.filter(({first}) => first).forEach(({path}) => page.show(path));
  }
  function step(way) { // undo, or redo
    const [from, to] = way < 0 ? [state.past, state.future] : [state.future, state.past];
    if (!from.length) return;
    restore(from.pop(), to);
    if (served) history.go(way);
  }
  function changed(restart = false) {
    state.tries = 0;
    state.since ??= performance.now(); // from now on what is shown belongs to other values
    Object.keys(state.values).filter((path) => state.controls.has(path)).forEach(page.show);
    page.mark(null);
    state.bands = null;
    state.wanted = {restart};
    buttons.undo.disabled = !state.past.length;
    buttons.redo.disabled = !state.future.length;
    announce("changed");
    if (state.refining) send("stop", {}).catch(() => {}); // the request that runs will say it
    pump();
  }

  // -- runs: one at a time, always the latest values

  async function pump() {
    if (state.busy) return;
    state.busy = true;
    clearTimeout(state.resting);
    root.setAttribute("aria-busy", "true");
    while (state.wanted) {
      const {restart, refine = false} = state.wanted, values = {...state.values}, slow = setInterval(tellSlow, SLOW);
      Object.assign(state, {wanted: null, refining: refine, began: performance.now()});
      try {
        const reply = await send("run", {values, restart, refine});
        state.began = null;
        if (reply.error) {
          fail(refusal(reply));
          page.mark(reply.path);
          if (!state.picture) await page.redraw(values); // a machine whose first run fails is drawn as its file has it
        } else if (reply.outdated) state.wanted = {restart: restart || Boolean(state.wanted?.restart)};
        else {
          fail("");
          display(reply);
          if (!state.wanted && reply.coarse) state.wanted = {restart: false, refine: true};
          else if (!reply.settled && !state.wanted && ++state.tries < RETRIES) state.wanted = {restart: false};
          if (!state.wanted || performance.now() > state.next) await complete(values);
        }
      } catch (problem) {
        fail(`${unanswered(problem)}; is the command still running? The picture is the last one.`);
      }
      Object.assign(state, {began: null, refining: false});
      clearInterval(slow);
    }
    state.busy = false;
    root.setAttribute("aria-busy", "false");
    clearTimeout(state.resting);
    state.resting = setTimeout(warn, REST);
    keep();
    if (state.view && !root.classList.contains("stale")) announce("rested");
  }
  async function complete(values) { // picture and table can take longer than curves: they get a part of the time
    const {view} = state, began = performance.now();
    if (view.picture !== state.picture) {
      const slow = setTimeout(() => at(".stage").classList.add("older"), SLOW);
      await page.redraw(values);
      clearTimeout(slow);
      at(".stage").classList.remove("older");
    }
    const locked = {table: [], motion: [view.remedy, "a linkage that locks has no steady motion and no peaks"]};
    const reply = view.locked === null ? await send("numbers", {}) : locked;
    state.next = performance.now() + (performance.now() - began) / SHARE;
    if (reply.error) return fail(reply.error);
    Object.assign(view, reply);
    announce("counted");
  }
  async function warn() { // some warnings take longer than a run: they wait until nothing is changed
    const {view} = state;
    if (!view || view.locked !== null) return;
    try {
      const {warnings} = await send("warnings", {});
      if (state.view === view && !state.busy) page.say(warnings);
    } catch { /* the run before has reported the failure */ }
  }
  async function tellSlow() {
    const {began, since} = state;
    root.classList.toggle("waiting", since !== null && performance.now() - since > SLOW);
    if (began === null) return;
    try {
      if (state.wanted && performance.now() - began > 2 * SLOW) await send("stop", {}); // newer values wait
      const {said} = await send("status", {});
      if (state.began === began) note(said || (state.refining ? "a preview; computing in full ..." : "computing ..."));
    } catch { /* the request that runs will say it */ }
  }
  function display(view) {
    state.view = view;
    state.since = state.wanted ? performance.now() : null; // newer values wait
    for (const [path, value] of Object.entries(view.numbers)) page.tell(path, value);
    const kind = view.coarse ? "preview" : !view.settled ? "settling" : view.periodic ? "periodic" : "not periodic";
    const run = `${kind}; computed in ${Math.max(1, Math.round(1e3 * view.took))} ms`;
    note(view.locked !== null ? `locks at ${number(view.locked)} s` : view.status === "ok" ? run : `${view.status}: ${view.remedy}`);
    announce("shown");
    if (view.locked !== null) page.hold(1);
  }
  async function ask(kind, request) { // a reply; its error is shown, too
    const reply = await send(kind, request).catch((problem) => ({error: unanswered(problem)}));
    complain(refusal(reply));
    return reply;
  }
  function unanswered({message}) { return `the server does not answer (${message})`; }
  function refusal({error = "", path, problem}) { return error && state.controls.has(path) ? `${labelOf(path)}: ${problem}` : error; } // in words
  function note(text) { at(".state").textContent = at(".state").title = text; }
  function complain(text) {
    if (!text && root.classList.contains("stale")) return; // the reason is still shown
    at(".error").replaceChildren(...text.split(/(?<=\s)|(?=\s)/).map((word) => { // a value that the page has can be shown
      const path = word.replace(/[,;:.]+$/, "");
      return path.includes(".") && state.controls.has(path) ? button(word, () => page.pick(path), "show this value") : word;
    }));
    at(".error").hidden = !text;
  }
  function fail(text) { // what is shown belongs to other values
    root.classList.toggle("stale", Boolean(text));
    state.since = null;
    complain(text);
    root.classList.remove("waiting");
    if (text) note("not computed");
  }

  // -- keeping: each step of undo has an address with its values and the limits, so that back is undo

  function address() {
    const {values, limits} = state, found = new URL(location.href), kept = Object.keys(limits).length ? {...values, limits} : values;
    found.hash = Object.keys(kept).length ? encodeURIComponent(JSON.stringify(kept)) : "";
    return found;
  }
  function visit() { if (served) history.pushState({at: state.past.length}, "", address()); }
  function keep() { if (served) history.replaceState({at: state.past.length}, "", address()); }
  if (served) addEventListener("popstate", ({state: visited}) => {
    const at = visited?.at ?? 0, {limits, ...wanted} = valuesOf(location.hash);
    const [from, to] = at < state.past.length ? [state.past, state.future] : [state.future, state.past];
    while (state.past.length !== at && from.length) restore(from.pop(), to);
    if (JSON.stringify(wanted) !== JSON.stringify(state.values)) location.reload(); // another link, or steps of an earlier page
  });
  async function copyLink() {
    keep();
    try { await navigator.clipboard.writeText(location.href); note("the address of these values is copied"); }
    catch { note(`the address bar has these values: ${location.href}`); }
  }
  async function write(kind, what) {
    const [name, replace] = await page.form(kind, `Write ${what} in ${state.start.folder}:`, [["name", state.start.name]], kind, true);
    note("writing ...");
    const reply = await ask(kind, {values: state.values, name, replace});
    note(reply.error ? "not written" : `written: ${reply.written}; ${reply.command}`);
  }

  // -- start

  (async () => {
    const {limits, ...linked} = served ? valuesOf(location.hash) : {};
    Object.assign(state.limits, limits);
    try {
      state.start = await send("start", {values: linked});
    } catch (problem) { return fail(unanswered(problem)); }
    if (state.start.error) return fail(state.start.error);
    at("h1").textContent = state.start.title;
    if (served) document.title = `${state.start.file} - linkages play`;
    state.controls = new Map(state.start.controls.map((control) => [control.path, control]));
    state.values = Object.fromEntries(Object.entries(linked).filter(([path]) => state.controls.has(path)));
    state.start.controls.filter(({first, path}) => first || path in state.values).forEach(({path}) => page.show(path));
    announce("ready");
    changed();
  })();
}

function valuesOf(hash) {
  try { return JSON.parse(decodeURIComponent(hash.slice(1)) || "{}") ?? {}; } catch { return {}; }
}

// -- the page, and the widget of a notebook

const element = globalThis.document?.querySelector("main[data-server]");
if (element) mount(element, async (kind, request) => {
  const reply = await fetch(kind, {method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify(request)});
  if (!reply.ok) throw new Error(`${reply.status} ${reply.statusText}`);
  return reply.json();
});

export default {
  render({model, el}) {
    const waiting = new Map(), holder = make("div", {class: "linkages-live"});
    let count = 0;
    model.on("msg:custom", ({n, reply}) => { waiting.get(n)?.(reply); waiting.delete(n); });
    el.append(holder);
    mount(holder, (kind, request) => ["status", "stop"].includes(kind) ? Promise.resolve({said: ""}) : new Promise((done) => {
      const n = `${request.page} ${++count}`; // all views of the model hear each reply
      waiting.set(n, done);
      model.send({n, kind, request});
    }));
  },
};

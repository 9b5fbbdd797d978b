// The live page: controls, a moving picture, magnified joints, curves and a table of one machine.
// mount(root, answer) builds it into an element; answer(kind, request) returns the promise of a reply.

import {charts} from "./charts.js";
import {controls} from "./controls.js";
import {ask, button, g, make} from "./dom.js";
import {explore} from "./explore.js";
import {joints} from "./joints.js";
import {layout} from "./layout.js";
import {machine} from "./machine.js";
import {numbers} from "./numbers.js";
import {runs} from "./runs.js";
import {refusal} from "./words.js";

const RETRIES = 12; // runs after a change until the motion is steady
const SHARE = 0.1; // most of the time that picture and table take while values change
const SLOW = 400; // time after which a run is slow: what is shown becomes pale [ms]
const REST = 400; // time without a change after which warnings are computed [ms]

export function mount(root, answer) {
  const own = crypto.getRandomValues(new Uint32Array(3)).join("-"); // the server keeps the runs of pages apart
  const send = (kind, request) => answer(kind, {...request, page: own});
  const state = { // limits: {least, value [SI]} by output
    limits: {}, began: null, since: null, start: null, controls: new Map(), shown: [], values: {}, past: [], future: [], view: null, pins: [],
    picture: null, wanted: null, busy: false, refining: false, tries: 0, next: 0, phase: 0, plots: null, bands: null, frame: null,
  };
  const at = (selector) => root.querySelector(selector);
  const announce = (event) => root.dispatchEvent(new CustomEvent(event));
  root.replaceChildren(
    make("header", {}, make("h1"), make("div", {class: "settings"}),
      make("div", {class: "bar"}, make("div", {class: "buttons"}), make("div", {class: "buttons tools"}), make("span", {class: "state", role: "status"}))),
    make("p", {class: "error", role: "alert", hidden: ""}),
    make("div", {class: "layout"},
      make("section", {class: "controls", "aria-label": "values"}),
      make("div", {class: "stage"}, make("section", {class: "machine", "aria-label": "machine"}), make("section", {class: "orbits", "aria-label": "joints"})),
      make("section", {class: "curves", "aria-label": "curves"}),
      make("section", {class: "numbers", "aria-label": "peaks"})),
    make("dialog"),
    make("dialog", {class: "runs", "aria-label": "runs"}),
  );
  const page = {root, at, send, state, valueOf, change, apply, note, complain, fail, keep};
  layout(page);
  Object.assign(page, controls(page), machine(page), numbers(page));
  charts(page);
  const buttons = {
    pin: button("pin", page.pin, "keep this run for comparison (p)"),
    undo: button("undo", undo, "Ctrl+Z"), redo: button("redo", redo, "Ctrl+Shift+Z"),
    reset: button("reset", reset, "all values of the file"),
    save: button("save", () => write("save"), "write an experiment file"),
    export: button("export", () => write("export"), "write the folder of linkages simulate"),
    link: button("link", copyLink, "copy an address that restores all values"),
  };
  if (!root.dataset.server) delete buttons.link; // the address is a notebook's
  at(".buttons").append(...Object.values(buttons));
  for (const name of ["undo", "redo"]) buttons[name].disabled = true;
  runs(page);
  joints(page);
  explore(page);
  (root.dataset.server ? document : root).addEventListener("keydown", (event) => {
    const typing = event.target.matches("input:not([type=range]), select, textarea");
    const key = event.key.toLowerCase(), control = event.ctrlKey || event.metaKey;
    if (control && (key === "y" || (key === "z" && event.shiftKey))) redo();
    else if (control && key === "z") undo();
    else if (!typing && !control && key === " " && !event.target.matches("button")) page.togglePlay();
    else if (!typing && !control && key === "p") page.pin();
    else return;
    event.preventDefault();
  });

  // -- values ----------------------------------------------------------------------------------------------------------

  function valueOf(path) { return state.values[path] ?? state.controls.get(path).value; }
  function change(values, remember = true) {
    const changes = Object.entries(values).filter(([path, value]) => value !== valueOf(path));
    if (!changes.length) return;
    if (remember) { state.past.push({...state.values}); state.future = []; }
    state.values = {...state.values, ...Object.fromEntries(changes)};
    for (const [path, value] of changes) {
      if (value === state.controls.get(path).value) delete state.values[path];
      page.tell(path);
    }
    changed();
  }
  function restore(values, from, to, restart = false) {
    to.push({...state.values});
    state.values = {...values};
    changed(restart);
    state.shown.forEach((path) => page.tell(path));
  }
  function apply(values, added = []) { // all values at once
    for (const control of added) state.controls.set(control.path, control);
    state.future = [];
    restore(values, null, state.past);
    added.filter(({first}) => first).forEach(({path}) => page.show(path));
  }
  function undo() { if (state.past.length) restore(state.past.pop(), state.past, state.future); }
  function redo() { if (state.future.length) restore(state.future.pop(), state.future, state.past); }
  function reset() {
    state.future = [];
    restore({}, null, state.past, true);
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
    if (state.refining) send("stop", {}).catch(() => {}); // the request that runs will say it
    pump();
  }

  // -- runs: one at a time, always the latest values ---------------------------------------------------------------------

  async function pump() {
    if (state.busy) return;
    state.busy = true;
    clearTimeout(state.resting);
    root.setAttribute("aria-busy", "true");
    while (state.wanted) {
      const {restart, refine = false} = state.wanted, values = {...state.values};
      state.wanted = null;
      state.refining = refine;
      state.began = performance.now();
      const slow = setInterval(tellSlow, SLOW);
      try {
        const reply = await send("run", {values, restart, refine});
        state.began = null;
        if (reply.error) {
          fail(refusal(reply, state.controls));
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
        fail(`the server does not answer (${problem.message}); is the command still running? The picture is the last one.`);
      }
      state.began = null;
      state.refining = false;
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
    if (view.locked !== null) note(`locks at ${g(view.locked, 4)} s`);
    else note(view.status === "ok" ? `${kind}; computed in ${Math.max(1, Math.round(1e3 * view.took))} ms` : `${view.status}: ${view.remedy}`);
    announce("shown");
    if (view.locked !== null) page.hold(1);
  }
  function note(text) { at(".state").textContent = at(".state").title = text; }
  function complain(text) {
    if (!text && root.classList.contains("stale")) return; // the reason is still shown
    at(".error").replaceChildren(...text.split(/(?<=\s)|(?=\s)/).map((word) => { // a value that the page has can be shown
      const path = word.replace(/[,;:.]+$/, "");
      return state.controls.has(path) ? button(word, () => page.pick(path), "show this value") : word;
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

  // -- keeping -----------------------------------------------------------------------------------------------------------

  function keep() { // values and limits in the address: a page that is loaded again has them
    if (!root.dataset.server) return "";
    const {values, limits} = state, address = new URL(location.href), kept = Object.keys(limits).length ? {...values, limits} : values;
    address.hash = Object.keys(kept).length ? encodeURIComponent(JSON.stringify(kept)) : "";
    history.replaceState(null, "", address);
    return address.href;
  }
  async function copyLink() {
    const address = keep();
    try { await navigator.clipboard.writeText(address); note("the address of these values is copied"); }
    catch { note(`the address bar has these values: ${address}`); }
  }
  async function write(kind) {
    const what = kind === "save" ? "Write the experiment file" : "Write the experiment file and, by linkages simulate, the folder of its results";
    const [name, replace] = await ask(at("dialog"), `${what} in ${state.start.folder}:`, [["name", state.start.name]], kind, true);
    note(kind === "save" ? "saving ..." : "exporting ...");
    try {
      const reply = await send(kind, {values: state.values, name, replace});
      complain(reply.error ?? "");
      note(reply.error ? "not written" : `written: ${reply.written}; ${reply.command}`);
    } catch (problem) { complain(`the server does not answer (${problem.message})`); }
  }

  // -- start -------------------------------------------------------------------------------------------------------------

  (async () => {
    const {limits, ...linked} = root.dataset.server ? valuesOf(location.hash) : {};
    Object.assign(state.limits, limits);
    try {
      state.start = await send("start", {values: linked});
    } catch (problem) { return fail(`the server does not answer (${problem.message})`); }
    if (state.start.error) return fail(state.start.error);
    at("h1").textContent = state.start.title;
    if (root.dataset.server) document.title = `${state.start.file} - linkages play`;
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

// -- the page, and the widget of a notebook --------------------------------------------------------------------------------

const served = globalThis.document?.querySelector("main[data-server]");
if (served) {
  addEventListener("hashchange", () => location.reload()); // another link was typed
  mount(served, async (kind, request) => {
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

// Joints and links of the live page: a click on one edits it, a drag moves a pin.
//
// `page` is what the modules of the page share:
//   root, at(selector)        the element of the page; an element in it
//   send(kind, request)       a reply of the server, see server.py
//   state                     start, controls (a Map by path), values, view, phase, scene (the reply of "picture"),
//                             frame (place of the picture while a pin is dragged)
//   apply(values, controls)   set all values at once, as one step of undo; controls are added, and their rows shown
//   change(values, remember)  set some values, by default as one step of undo; valueOf(path) is the present one
//   show(path)                show the row of a control
//   note(text), complain(text), hold(phase)
// Events on the root: "shown" after a new view, "counted" after a new table, "row" for a new row of a control, with
// {row, control} as its detail. ".tools" is for buttons of further actions.

import {button, draw, make, select} from "./dom.js";
import {labelOfPath, refusal} from "./words.js";

const NEAR = 16, MOVED = 5; // distance of a click from a pin, way of the mouse that is a drag [px]
const FIRST = /(\.mass|\.inertia|\.pose\.x|\.pose\.y|\.model|\.width|\.height|\.diameter|\.outer|\.inner|\.second_moment)$/;

export function joints(page) {
  const {root, at, send, state, change, apply} = page;
  const editor = make("dialog", {class: "part", "aria-label": "joint or link"});
  root.append(editor);
  let drag = null;

  // -- what is where ---------------------------------------------------------------------------------------------------

  const svg = () => at(".picture svg");
  function pose(body) {
    const {view, phase} = state, place = phase * (view.time.length - 1), k = Math.min(Math.floor(place), view.time.length - 2);
    return view.poses[k][body].map((value, j) => value + (place - k) * (view.poses[k + 1][body][j] - value));
  }
  function pins() { // places of the joints in the picture, by name
    if (!state.view?.poses?.length || state.view.picture !== state.picture) return [];
    return Object.entries(state.scene.joints).map(([name, [body, x, y]]) => {
      const [px, py, angle] = pose(body), c = Math.cos(angle), s = Math.sin(angle);
      return [name, px + c * x - s * y, py + s * x + c * y];
    });
  }
  const toScreen = ([, x, y]) => {
    const {low, high, scale} = state.scene;
    return new DOMPoint((x - low) * scale, (high - y) * scale).matrixTransform(svg().getScreenCTM());
  };
  function toPlane(event) {
    const {low, high, scale} = state.scene, at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg().getScreenCTM().inverse());
    return [low + at.x / scale, high - at.y / scale];
  }
  function jointsAt(event) {
    const away = (pin) => { const at = toScreen(pin); return Math.hypot(at.x - event.clientX, at.y - event.clientY); };
    return pins().map((pin) => [away(pin), pin[0]]).filter(([way]) => way < NEAR).sort(([a], [b]) => a - b).map(([, name]) => name);
  }
  function linkAt(event) {
    const body = event.target.dataset?.at?.split(",")[0], link = state.scene?.bodies[body];
    return state.start.parts.links.some(({name}) => name === link) ? link : null;
  }

  // -- the mouse -------------------------------------------------------------------------------------------------------

  at(".machine").addEventListener("pointerdown", (event) => {
    if (!svg()?.contains(event.target) || event.button) return;
    const names = jointsAt(event), link = names.length ? null : linkAt(event);
    if (!names.length && !link) return;
    event.preventDefault();
    at(".picture").setPointerCapture(event.pointerId);
    drag = {names, link, from: [event.clientX, event.clientY], base: null, next: null, busy: false, first: true};
  });
  at(".machine").addEventListener("pointermove", (event) => {
    if (!drag && svg()?.contains(event.target)) {
      const names = jointsAt(event), link = names.length ? null : linkAt(event);
      svg().style.cursor = names.length ? "grab" : link ? "pointer" : "";
    }
    if (!drag?.names.length) return;
    const way = Math.hypot(event.clientX - drag.from[0], event.clientY - drag.from[1]);
    if (!drag.base && way < MOVED) return;
    if (!drag.base) {
      const {width, height} = svg().viewBox.baseVal;
      drag.base = {...state.values};
      state.frame = {...state.scene, width, height};
      page.hold(state.phase);
      drag.mark = draw("circle", {r: 14, fill: "none", stroke: "currentColor", "stroke-dasharray": "4 3"});
    }
    drag.next = toPlane(event);
    const {low, high, scale} = state.scene, [x, y] = drag.next;
    drag.mark.setAttribute("cx", (x - low) * scale);
    drag.mark.setAttribute("cy", (high - y) * scale);
    svg().append(drag.mark);
    follow(drag);
  });
  for (const end of ["pointerup", "pointercancel"]) at(".machine").addEventListener(end, () => {
    if (!drag) return;
    const {names, link, base, mark} = drag;
    mark?.remove();
    drag.over = true;
    drag = state.frame = null;
    if (base) page.redraw(state.values);
    else open(names, link);
  });
  async function follow(own) { // one request at a time, always the latest place
    if (own.busy) return;
    own.busy = true;
    while (own.next) {
      const to = own.next;
      own.next = null;
      const reply = await send("move", {values: own.base, joint: own.names[0], to, phase: state.phase}).catch(({message}) => ({error: message}));
      page.complain(refusal(reply, state.controls));
      if (reply.error) continue;
      const before = {...state.values};
      change(reply.values, own.first);
      if (JSON.stringify(before) !== JSON.stringify(state.values)) own.first = false;
    }
    own.busy = false;
  }

  // -- the editor ------------------------------------------------------------------------------------------------------

  const chooser = make("select", {"aria-label": "joint or link", title: "a joint or a link"}); // a list opens nothing by itself: arrow keys walk through it
  const opener = button("edit", () => {
    const [kind, name] = chooser.value.split(" ");
    open(kind === "joint" ? [name] : [], kind === "link" ? name : null);
  }, "edit this joint or link; or click it in the picture");
  root.addEventListener("ready", () => {
    const {joints: all, links} = state.start.parts, option = (kind) => ({name}) => make("option", {value: `${kind} ${name}`}, `${kind} ${name}`);
    chooser.replaceChildren(...all.filter(({models}) => models.length).map(option("joint")), ...links.map(option("link")));
    at(".tools").prepend(chooser, opener);
  });
  function open(names, link) {
    const {joints: all, links} = state.start.parts;
    const parts = link ? [links.find(({name}) => name === link)] : all.filter(({name, models}) => names.includes(name) && models.length);
    if (!parts.length) return page.note(`joint ${names.join(", ")} has no other model`);
    editor.replaceChildren(...parts.map((part) => fieldset(part, link ? "link" : "joint")), button("close", () => editor.close(), "Escape"));
    if (!editor.open) editor.showModal();
  }
  function fieldset(part, kind) {
    const path = `${kind}s.${part.name}.model`, now = state.values[path] ?? part.model;
    const models = part.models.map((model) => {
      const one = button(model, () => edit(kind, part.name, {model}), `make the ${kind} ${model}`);
      one.setAttribute("aria-pressed", model === now);
      return one;
    });
    const added = kind === "link" || now === "ideal" ? [] : [
      ...(now === "dry" ? [] : [button("add a groove", () => edit(kind, part.name, {add: "groove"}), "a feed groove, and the cavitation that it needs")]),
      ...(now === "lubricated" ? [] : [button("add wear", () => edit(kind, part.name, {add: "wear"}), "wear and a shallow recess of the bearing")])];
    const start = [`${kind}s.${part.name}.`, `sdf.${kind}s.${part.name}.`], own = (one) => start.some((begin) => one.startsWith(begin)) || part.paths?.includes(one);
    const values = [...state.controls.keys()].filter((one) => own(one) && page.valueOf(one) !== null && one !== path && (kind === "joint" ? !one.includes(".pose.") : FIRST.test(one)));
    const list = select(["show a value ...", ...values.sort((a, b) => !page.valueOf(a) - !page.valueOf(b))], "show a value ...");
    [...list.options].slice(1).forEach((option) => { option.textContent = labelOfPath(option.title = option.value); });
    list.setAttribute("aria-label", `values of ${kind} ${part.name}`);
    list.addEventListener("change", () => { editor.close(); page.show(list.value); at(`[data-path="${CSS.escape(list.value)}"]`).querySelector("input, select").focus(); });
    const noted = kind === "link" && part.models.length < 2 ? [make("small", {}, "A flexible link needs two ends.")] : [];
    return make("fieldset", {}, make("legend", {}, `${kind} ${part.name}${part.driven ? " (driven)" : ""}`),
      make("div", {class: "buttons"}, ...models, ...added), list, ...noted);
  }
  async function edit(part, name, what) {
    editor.close();
    const reply = await send("edit", {values: state.values, part, name, ...what}).catch(({message}) => ({error: message}));
    page.complain(refusal(reply, state.controls));
    if (!reply.error) apply(reply.values, reply.controls);
    return !reply.error;
  }
  root.addEventListener("row", ({detail: {row, control: {path, choices}}}) => { // the row of a model offers all, with proposed values
    const [kind, name, key] = path.split("."), part = state.start.parts[kind]?.find((one) => one.name === name), field = row.querySelector("select");
    if (key !== "model" || !part || !field) return;
    field.replaceChildren(...part.models.map((model) => make("option", {value: model}, model)));
    field.value = page.valueOf(path);
    row.addEventListener("change", async (event) => {
      if (choices.includes(field.value)) return; // the file has all that this model needs
      event.stopImmediatePropagation();
      if (!await edit(kind.slice(0, -1), name, {model: field.value})) field.value = page.valueOf(path);
    }, true);
  });
}

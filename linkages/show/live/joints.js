// Joints and links of the live page: a click on one edits it, a drag moves a pin.
//
// `page` is what the modules of the page share:
//   root, at(selector)        the element of the page; an element in it
//   send(kind, request)       a reply of the server, see server.py; ask(kind, request) shows an error, too
//   state                     start, controls (a Map by path), values, view, phase, scene (the reply of "picture"),
//                             frame (place of the picture while a pin is dragged)
//   apply(values, controls)   set all values at once, as one step of undo; controls are added, and their rows shown
//   change(values, remember)  set some values, by default as one step of undo; valueOf(path) is the present one
//   labelOf(path), unitOf(si), inWords(path, value): a name, a unit with its factor, a value with its unit
//   show(path), pick(path)    show the row of a control; go to it
//   open(title, content), close(), form(title, text, fields, action): the panel at the side
//   note(text), complain(text), hold(phase)
// Events on the root: "ready", "shown" after a new view, "counted" after a new table, "changed" after other values, "rested"
// when all is computed, "row" for a new row of a control, with {row, control} as its detail. ".tools" is for buttons.

import {svgElement} from "./curves.js";
import {button, make, select} from "./dom.js";

const NEAR = 16, MOVED = 5; // distance of a click from a pin, way of the mouse that is a drag [px]

export function joints(page) {
  const {root, at, state, change, apply} = page, svg = () => at(".picture svg");
  let drag = null;

  // -- what is where

  function pins() { // places of the joints in the picture, by name
    const {view, phase, scene} = state;
    if (!view?.poses?.length || view.picture !== state.picture) return [];
    const place = phase * (view.time.length - 1), k = Math.min(Math.floor(place), view.time.length - 2);
    return Object.entries(scene.joints).map(([name, [body, x, y]]) => {
      const [px, py, angle] = view.poses[k][body].map((value, j) => value + (place - k) * (view.poses[k + 1][body][j] - value));
      const c = Math.cos(angle), s = Math.sin(angle);
      return [name, px + c * x - s * y, py + s * x + c * y];
    });
  }
  function jointsAt({clientX, clientY}) {
    const {low, high, scale} = state.scene, toScreen = svg().getScreenCTM();
    const away = ([, x, y]) => {
      const place = new DOMPoint((x - low) * scale, (high - y) * scale).matrixTransform(toScreen);
      return Math.hypot(place.x - clientX, place.y - clientY);
    };
    return pins().map((pin) => [away(pin), pin[0]]).filter(([way]) => way < NEAR).sort(([a], [b]) => a - b).map(([, name]) => name);
  }
  function linkAt(event) {
    const body = event.target.dataset?.at?.split(",")[0], link = state.scene?.bodies[body];
    return state.start.parts.links.some(({name}) => name === link) ? link : null;
  }

  // -- the mouse

  at(".machine").addEventListener("pointerdown", (event) => {
    if (!svg()?.contains(event.target) || event.button) return;
    const names = jointsAt(event), link = names.length ? null : linkAt(event);
    if (!names.length && !link) return;
    event.preventDefault();
    at(".picture").setPointerCapture(event.pointerId);
    drag = {names, link, from: [event.clientX, event.clientY], base: null, next: null, busy: false, first: true};
  });
  at(".machine").addEventListener("pointermove", (event) => {
    if (!drag && svg()?.contains(event.target)) svg().style.cursor = jointsAt(event).length ? "grab" : linkAt(event) ? "pointer" : "";
    if (!drag?.names.length) return;
    if (!drag.base && Math.hypot(event.clientX - drag.from[0], event.clientY - drag.from[1]) < MOVED) return;
    if (!drag.base) begin();
    const {low, high, scale} = state.scene, place = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg().getScreenCTM().inverse());
    drag.next = [low + place.x / scale, high - place.y / scale];
    drag.mark.setAttribute("cx", place.x);
    drag.mark.setAttribute("cy", place.y);
    svg().append(drag.mark);
    follow(drag);
  });
  for (const end of ["pointerup", "pointercancel"]) at(".machine").addEventListener(end, () => {
    if (!drag) return;
    const {names, link, base, mark} = drag;
    mark?.remove();
    drag = state.frame = null;
    if (base) page.redraw(state.values);
    else edit(names, link);
  });
  function begin() {
    const {width, height} = svg().viewBox.baseVal;
    drag.base = {...state.values};
    state.frame = {...state.scene, width, height};
    page.hold(state.phase);
    drag.mark = svgElement("circle", {r: 14, fill: "none", stroke: "currentColor", "stroke-dasharray": "4 3"});
  }
  async function follow(own) { // one request at a time, always the latest place
    if (own.busy) return;
    own.busy = true;
    while (own.next) {
      const to = own.next;
      own.next = null;
      const reply = await page.ask("move", {values: own.base, joint: own.names[0], to, phase: state.phase}), before = JSON.stringify(state.values);
      if (reply.error) continue;
      change(reply.values, own.first);
      if (before !== JSON.stringify(state.values)) own.first = false;
    }
    own.busy = false;
  }

  // -- the editor

  root.addEventListener("ready", () => {
    const {joints: all, links} = state.start.parts, option = (kind) => ({name}) => `${kind} ${name}`;
    const chooser = select([...all.filter(({models}) => models.length).map(option("joint")), ...links.map(option("link"))], "", "joint or link");
    chooser.selectedIndex = 0; // a list opens nothing by itself: arrow keys walk through it
    at(".tools").prepend(chooser, button("edit", () => {
      const [kind, name] = chooser.value.split(" ");
      edit(kind === "joint" ? [name] : [], kind === "link" ? name : null);
    }, "edit this joint or link; or click it in the picture"));
  });
  function edit(names, link) {
    const {joints: all, links} = state.start.parts;
    const parts = link ? links.filter(({name}) => name === link) : all.filter(({name, models}) => names.includes(name) && models.length);
    if (!parts.length) return page.note(`joint ${names.join(", ")} has no other model`);
    page.open(parts.map(({name}) => `${link ? "link" : "joint"} ${name}`).join(", "), parts.map((part) => fieldset(part, link ? "link" : "joint")));
  }
  function fieldset(part, kind) {
    const now = state.values[`${kind}s.${part.name}.model`] ?? part.model, has = (model) => kind === "joint" && ![model, "ideal"].includes(now);
    const models = part.models.map((model) => {
      const one = button(model, () => give(kind, part.name, {model}), `make the ${kind} ${model}`);
      one.setAttribute("aria-pressed", model === now);
      return one;
    });
    const added = [
      ...(has("dry") ? [button("add a groove", () => give(kind, part.name, {add: "groove"}), "a feed groove, and the cavitation that it needs")] : []),
      ...(has("lubricated") ? [button("add wear", () => give(kind, part.name, {add: "wear"}), "wear and a shallow recess of the bearing")] : []),
      button("its values", () => page.find(part.name), "search the values of this part")];
    return make("fieldset", {}, make("legend", {}, `${kind} ${part.name}${part.driven ? " (driven)" : ""}`), make("div", {class: "buttons"}, ...models, ...added),
      ...(kind === "link" && part.models.length < 2 ? [make("small", {}, "A flexible link needs two ends.")] : []));
  }
  async function give(part, name, what) {
    const reply = await page.ask("edit", {values: state.values, part, name, ...what});
    if (!reply.error) apply(reply.values, reply.controls);
    page.close();
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
      if (!await give(kind.slice(0, -1), name, {model: field.value})) field.value = page.valueOf(path);
    }, true);
  });
}

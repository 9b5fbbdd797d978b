// Rows of values: a slider and a field for a number, a list for a choice; a search for all values; the list of changed ones.

import {number} from "./curves.js";
import {button, make, select} from "./dom.js";

const plain = (value, digits) => number(value, digits).replace("−", "-"); // a number that can be typed

export function controls(page) {
  const {root, at, state, change, valueOf} = page;
  at(".controls").append(
    make("form", {class: "search", role: "search"},
      make("input", {type: "search", "aria-label": "search any value", autocomplete: "off"}), make("ul", {class: "hits"})),
    make("section", {class: "changes", "aria-label": "changed values", hidden: ""}), make("div", {class: "rows"}));
  const rowOf = (path) => at(`[data-path="${CSS.escape(path)}"]`), field = at(".search input");

  function show(path) {
    if (state.shown.includes(path)) return;
    state.shown.push(path);
    const control = state.controls.get(path), row = make("div", {class: "row", "data-path": path});
    row.append(make("label", {for: `value-${path}`, title: path}, control.label));
    row.append(...(control.choices.length ? [choice(path, control)] : numeric(path, control)));
    at(".rows").append(row);
    tell(path);
    root.dispatchEvent(new CustomEvent("row", {detail: {row, control}}));
  }
  function choice(path, control) {
    const chosen = select(control.choices, valueOf(path), "", (value) => change({[path]: value}));
    chosen.id = `value-${path}`;
    return chosen;
  }
  function numeric(path, control) {
    const typed = make("input", {id: `value-${path}`, class: "typed", inputmode: "text", autocomplete: "off"});
    const slider = make("input", {type: "range", min: 0, max: 1000, "aria-label": `${control.label}, slider`});
    let began = false; // a drag is one step of undo
    slider.addEventListener("input", () => {
      change({[path]: fromSlider(control, slider.value)}, !began);
      began = true;
    });
    slider.addEventListener("change", () => { began = false; });
    typed.addEventListener("change", () => {
      const text = typed.value.trim(), value = Number(text), factor = page.unitOf(control.unit)[1];
      if (text) change({[path]: Number.isFinite(value) ? Number((value / factor).toPrecision(15)) : text});
      tell(path);
    });
    return [typed, make("span", {class: "unit"}), make("div", {class: "slider"}, make("span"), slider, make("span"))];
  }
  function tell(path, known = valueOf(path)) { // `known`: the number of a typed text
    const row = rowOf(path), control = state.controls.get(path), value = valueOf(path);
    if (!row) return;
    row.hidden = value === null; // the file has no such value, and nothing adds it now
    if (row.hidden) return;
    row.classList.toggle("changed", path in state.values);
    if (control.choices.length) { row.querySelector("select").value = value; return; }
    const typed = row.querySelector(".typed"), [unit, factor] = page.unitOf(control.unit), ends = row.querySelectorAll(".slider span");
    typed.value = typeof known === "number" ? plain(factor * known, 6) : known;
    typed.title = `a number in ${unit || "1"}, or one with a unit` + (control.value === null ? "" : `; the file has ${inWords(path, control.value)}`);
    row.querySelector(".unit").textContent = unit;
    [control.low, control.high].forEach((end, k) => { ends[k].textContent = number(factor * end); });
    if (typeof known === "number") row.querySelector("[type=range]").value = toSlider(control, known);
  }
  function inWords(path, value) { // a value with its unit
    const [unit, factor] = page.unitOf(state.controls.get(path)?.unit ?? "");
    return typeof value === "number" ? `${number(factor * value, 5)} ${unit}`.trim() : value ?? "none";
  }
  function listChanges() { // all that differs from the file, dragged pins and edits too
    const paths = Object.keys(state.values), list = at(".changes");
    list.hidden = !paths.length;
    list.replaceChildren(make("h2", {}, `Changed: ${paths.length}`), make("ul", {}, ...paths.map((path) => {
      const name = page.labelOf(path), before = state.controls.get(path)?.value ?? null;
      const back = button("undo", () => change({[path]: before}), `back to ${inWords(path, before)}`);
      back.setAttribute("aria-label", `undo ${name}`);
      const shown = state.controls.has(path) ? button(name, () => pick(path), path) : make("span", {title: path}, name);
      return make("li", {}, shown, make("span", {}, `${inWords(path, before)} → ${inWords(path, state.values[path])}`), back);
    })));
  }
  function mark(wrong) { // the field of a value that is refused; null for none
    if (state.controls.has(wrong)) show(wrong);
    for (const row of at(".rows").children) {
      const refused = row.dataset.path === wrong, input = row.querySelector(".typed, select");
      row.classList.toggle("wrong", refused);
      if (refused) input.setAttribute("aria-invalid", "true");
      else input.removeAttribute("aria-invalid");
    }
  }
  function hits() { // all values with each word in their path or label; those that matter in the plane first, zeros behind
    const words = field.value.toLowerCase().split(/\s+/).filter(Boolean), rank = (one) => 2 * one.aside + (valueOf(one.path) === 0);
    const found = [...state.controls.values()].filter(({sought}) => words.length && words.every((word) => sought.includes(word)));
    return found.sort((a, b) => rank(a) - rank(b));
  }
  function list() {
    const found = hits().map(({path, label}) => make("li", {}, button(label, () => pick(path), path)));
    found.forEach((hit) => hit.firstChild.append(make("small", {}, hit.firstChild.title)));
    at(".hits").replaceChildren(...(field.value.trim() && !found.length ? [make("li", {}, "no such value")] : found));
  }
  function pick(path) {
    page.complain("");
    field.value = "";
    list();
    show(path);
    rowOf(path).querySelector("input, select").focus();
    rowOf(path).scrollIntoView({block: "nearest"});
  }
  field.addEventListener("input", list);
  at(".search").addEventListener("submit", (event) => {
    event.preventDefault();
    const text = field.value.trim(), found = hits().map(({path}) => path);
    const path = found.find((one) => one === text) ?? found.find((one) => !state.shown.includes(one)) ?? found[0];
    if (path) pick(path);
    else page.complain(`no value has "${text}" in its path`);
  });
  root.addEventListener("ready", () => { field.placeholder = `search any of ${state.controls.size} values`; });
  root.addEventListener("changed", listChanges);
  root.addEventListener("units", () => { state.shown.forEach((path) => tell(path)); listChanges(); });
  return {mark, pick, show, tell, inWords};
}

function fromSlider({low, high, logarithmic, whole}, place) {
  const part = place / 1000, value = logarithmic ? low * (high / low) ** part : low + (high - low) * part;
  return whole ? Math.round(value) : Number(value.toPrecision(4));
}
function toSlider({low, high, logarithmic}, value) {
  const part = logarithmic ? Math.log(Math.max(value / low, 1e-300)) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(1000 * Math.min(Math.max(part, 0), 1));
}

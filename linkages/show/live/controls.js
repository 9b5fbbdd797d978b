// Rows of values: a slider and a field for a number, a list for a choice; a search for all other values.

import {g, make, select} from "./dom.js";
import {labelOfPath, OUT_OF_PLANE, unitOf} from "./words.js";

export function controls(page) {
  const {root, at, state, change, valueOf} = page;
  at(".controls").append(
    make("form", {class: "search", role: "search"},
      make("input", {type: "search", placeholder: "search any value", "aria-label": "search any value", autocomplete: "off"}),
      make("ul", {class: "hits"})),
    make("div", {class: "rows"}));

  function show(path) {
    if (state.shown.includes(path)) return;
    state.shown.push(path);
    const control = state.controls.get(path), row = make("div", {class: "row", "data-path": path});
    row.append(make("label", {for: `value-${path}`, title: path}, labelOfPath(path)));
    row.append(...(control.choices.length ? [choice(path, control)] : number(path, control)));
    at(".rows").append(row);
    tell(path);
    root.dispatchEvent(new CustomEvent("row", {detail: {row, control}}));
  }
  function choice(path, control) {
    const field = select(control.choices, valueOf(path));
    field.id = `value-${path}`;
    field.addEventListener("change", () => change({[path]: field.value}));
    return field;
  }
  function number(path, control) {
    const field = make("input", {id: `value-${path}`, class: "typed", inputmode: "text", autocomplete: "off"});
    const slider = make("input", {type: "range", min: 0, max: 1000, "aria-label": `${labelOfPath(path)}, slider`});
    let began = false; // a drag is one step of undo
    slider.addEventListener("input", () => {
      change({[path]: fromSlider(control, slider.value)}, !began);
      began = true;
    });
    slider.addEventListener("change", () => { began = false; });
    field.addEventListener("change", () => {
      const text = field.value.trim(), typed = Number(text), factor = unitOf(control.unit, state.units)[1];
      if (text) change({[path]: Number.isFinite(typed) ? Number((typed / factor).toPrecision(15)) : text});
      tell(path);
    });
    return [field, make("span", {class: "unit"}), make("div", {class: "slider"}, make("span"), slider, make("span"))];
  }
  function tell(path, known = valueOf(path)) { // `known`: the number of a typed text
    const row = at(`[data-path="${CSS.escape(path)}"]`);
    if (!row) return;
    const control = state.controls.get(path), value = valueOf(path);
    row.hidden = value === null; // the file has no such value, and nothing adds it now
    if (row.hidden) return;
    row.classList.toggle("changed", path in state.values);
    if (control.choices.length) { row.querySelector("select").value = value; return; }
    const field = row.querySelector(".typed"), [unit, factor] = unitOf(control.unit, state.units);
    field.value = typeof known === "number" ? g(factor * known, 6) : known;
    field.title = `a number in ${unit || "1"}, or one with a unit` + (control.value === null ? "" : `; the file has ${g(factor * control.value)} ${unit}`);
    row.querySelector(".unit").textContent = unit;
    [control.low, control.high].forEach((end, k) => { row.querySelectorAll(".slider span")[k].textContent = g(factor * end, 5); });
    if (typeof known === "number") row.querySelector("[type=range]").value = toSlider(control, known);
  }
  function mark(wrong) { // the field of a value that is refused; null for none
    if (state.controls.has(wrong)) show(wrong);
    for (const row of at(".rows").children) {
      const refused = row.dataset.path === wrong, field = row.querySelector(".typed, select");
      row.classList.toggle("wrong", refused);
      if (refused) field.setAttribute("aria-invalid", "true");
      else field.removeAttribute("aria-invalid");
    }
  }
  function hits() { // all values with each word in their path or label; those that matter in the plane first, zeros behind
    const words = at(".search input").value.toLowerCase().split(/\s+/).filter(Boolean);
    const found = [...state.controls.keys()].filter((path) => {
      const text = `${path} ${labelOfPath(path)} ${state.controls.get(path).unit === "m" && !path.includes(".com.") ? "length" : ""}`.toLowerCase();
      return words.length && words.every((word) => text.includes(word));
    });
    const rank = (path) => 2 * OUT_OF_PLANE.test(path) + (valueOf(path) === 0);
    return found.sort((a, b) => rank(a) - rank(b));
  }
  function list() {
    const found = hits();
    at(".hits").replaceChildren(...found.map((path) => {
      const hit = make("button", {type: "button", title: path}, labelOfPath(path), make("small", {}, path));
      hit.addEventListener("click", () => pick(path));
      return make("li", {}, hit);
    }));
    if (at(".search input").value.trim() && !found.length) at(".hits").append(make("li", {}, "no such value"));
  }
  function pick(path) {
    page.complain("");
    at(".search input").value = "";
    list();
    show(path);
    const row = at(`[data-path="${CSS.escape(path)}"]`);
    row.querySelector("input, select").focus();
    row.scrollIntoView({block: "nearest"});
  }
  at(".search input").addEventListener("input", list);
  at(".search").addEventListener("submit", (event) => {
    event.preventDefault();
    const text = at(".search input").value.trim(), found = hits();
    const path = found.find((one) => one === text) ?? found.find((one) => !state.shown.includes(one)) ?? found[0];
    if (path) pick(path);
    else page.complain(`no value has "${text}" in its path`);
  });
  root.addEventListener("ready", () => { at(".search input").placeholder = `search any of ${state.controls.size} values`; });
  root.addEventListener("units", () => state.shown.forEach((path) => tell(path)));
  return {mark, pick, show, tell};
}

function fromSlider({low, high, logarithmic, whole}, place) {
  const part = place / 1000, value = logarithmic ? low * (high / low) ** part : low + (high - low) * part;
  return whole ? Math.round(value) : Number(value.toPrecision(4));
}
function toSlider({low, high, logarithmic}, value) {
  const part = logarithmic ? Math.log(Math.max(value, 1e-300) / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(1000 * Math.min(Math.max(part, 0), 1));
}

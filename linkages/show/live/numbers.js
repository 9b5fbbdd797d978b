// The table of peaks with the change against another run, limits and margins; the pinned runs; warnings and remedies.

import {number} from "./curves.js";
import {button, changeOf, make, marked, scaled, select, table} from "./dom.js";

const LOOKS = ["pin1", "pin2", "pin3", "pin4"]; // colours and dashes of pinned runs

export function numbers(page) {
  const {root, at, state} = page;
  let reference = null; // the pin to compare with; null: ideal joints
  const said = (event) => root.dispatchEvent(new CustomEvent(event));
  at(".numbers").append(make("div", {class: "head"}, make("h2", {}, "Peaks"), make("label", {}, "against ", make("select"))),
    make("div", {class: "pins"}), make("div", {class: "peaks"}), make("ul", {class: "said"}));

  function pin() {
    const look = LOOKS.find((one) => state.pins.every((other) => other.look !== one));
    if (!state.view) return;
    if (!look) return page.complain(`at most ${LOOKS.length} runs are pinned; remove one`);
    reference = {name: `pin ${look.at(-1)}`, view: state.view, values: {...state.values}, look};
    state.pins.push(reference);
    said("pinned");
  }
  function unpin(pinned) {
    state.pins = state.pins.filter((one) => one !== pinned);
    if (reference === pinned) reference = state.pins.at(-1) ?? null;
    said("pinned");
  }
  function drawPins() {
    const choices = [["", "ideal joints"], ...state.pins.map(({name}, k) => [k, name])], chosen = state.pins.indexOf(reference);
    const compare = (k) => { reference = state.pins[k] ?? null; said("pinned"); };
    at(".numbers .head select").replaceWith(select(choices, chosen < 0 ? "" : chosen, "the run to compare with", compare));
    at(".pins").replaceChildren(...state.pins.map((pinned) => {
      const name = make("input", {value: pinned.name, size: 7, "aria-label": "name of a pinned run"});
      name.addEventListener("change", () => { pinned.name = name.value; said("pinned"); });
      return make("span", {class: `pin ${pinned.look}`}, name,
        button("back", () => page.apply(pinned.values), `go back to the values of ${pinned.name}`),
        button("×", () => unpin(pinned), `remove ${pinned.name}`));
    }));
  }
  function drawTable() {
    const {view} = state;
    at(".numbers").classList.toggle("older", !view?.table);
    if (!view?.table) return;
    const compared = reference ? (reference.view.table ?? []).map(({name, value}) => [name, value]) : view.table.map(({name, ideal}) => [name, ideal]);
    const before = new Map(compared), heads = ["peak of", "now", reference?.name ?? "ideal", "change", "limit"];
    const drawn = table(heads, view.table.map((row) => cellsOf(row, before.get(row.name) ?? null)));
    view.table.forEach(({name}, k) => {
      const row = drawn.tBodies[0].rows[k];
      row.dataset.name = row.cells[0].title = name;
      marked(row.cells[0], state.start.colors[name.split(".")[0]]);
      ["", "now", "other", "change", ""].forEach((kind, column) => { row.cells[column].className = kind; });
    });
    at(".peaks").replaceChildren(drawn);
  }
  function cellsOf({name, label, unit: si, value, least, most}, before) {
    const [unit, factor] = page.unitOf(si), shown = (one, digits) => number(scaled(factor, one), digits);
    const [low, high] = [least, most].map((one) => shown(one, 3)), differ = state.view.settled && low !== high;
    const periods = make("div", {class: "periods", title: "smallest and largest peak of single periods"}, differ ? `${low} to ${high}` : "");
    const first = make("span", {}, label, make("small", {}, unit)), now = make("span", {title: `${value ?? "no value"} ${si}`}, shown(value));
    return [first, make("span", {}, now, ...(differ ? [" ", periods] : [])), shown(before), changeOf(value, before),
      make("span", {}, limitField(name, label, unit, factor), ...margin(state.limits[name], value))];
  }
  function limitField(name, label, unit, factor) {
    const limit = state.limits[name], text = limit ? `${limit.least ? ">" : "<"} ${number(factor * limit.value).replace("−", "-")}` : "";
    const field = make("input", {class: "limit", value: text, placeholder: "<", "aria-label": `limit of ${label}`, title: `such as "< 7" or "> 0.2" [${unit || "1"}]`});
    field.addEventListener("change", () => {
      const [, sense, typed] = /^\s*([<>]?)=?\s*([-+.\deE]+)\s*$/.exec(field.value) ?? [];
      if (Number.isFinite(Number(typed))) state.limits[name] = {least: sense === ">", value: Number(typed) / factor};
      else if (field.value.trim()) return page.complain(`"${field.value}" is no limit of ${name}; type such as "< 7" or "> 0.2"`);
      else delete state.limits[name];
      page.complain("");
      page.keep();
      drawTable();
    });
    return field;
  }
  function margin(limit, value) {
    if (!limit || value === null) return [];
    const room = (limit.least ? value - limit.value : limit.value - value) / Math.abs(limit.value || 1), good = room >= 0;
    return [make("div", {class: good ? "within" : "beyond", title: "margin"}, `${good ? "✓" : "✗"} ${number(100 * room, 3)} %`)];
  }
  function say(warnings = []) {
    const remedied = ({label, values}) => button(label, () => page.change(values), Object.keys(values).join(", "));
    at(".said").replaceChildren(...(state.view.motion ?? []).map((text) => make("li", {}, text)),
      ...warnings.map(({text, remedies}) => make("li", {class: "warning"}, text, ...remedies.map(remedied))));
  }
  for (const event of ["shown", "counted", "units", "pinned"]) root.addEventListener(event, drawTable);
  root.addEventListener("counted", () => say());
  root.addEventListener("pinned", drawPins);
  drawPins();
  return {pin, say, reference: () => reference};
}

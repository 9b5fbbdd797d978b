// The table of peaks with the change against another run, limits and margins; the pinned runs; warnings and remedies.

import {button, g, make, marked, percent} from "./dom.js";
import {labelOfOutput, unitOf} from "./words.js";

const LOOKS = ["pin1", "pin2", "pin3", "pin4"]; // colours and dashes of pinned runs

export function numbers(page) {
  const {root, at, state} = page;
  let reference = null; // the pin to compare with; null: ideal joints
  const compared = make("select", {"aria-label": "compare with", title: "the run to compare with"});
  compared.addEventListener("change", () => { reference = state.pins[compared.value] ?? null; root.dispatchEvent(new CustomEvent("pinned")); });
  at(".numbers").append(make("div", {class: "head"}, make("h2", {}, "Peaks"), make("label", {}, "against ", compared)),
    make("div", {class: "pins"}), make("table"), make("ul", {class: "said"}));

  function pin() {
    const look = LOOKS.find((one) => state.pins.every((other) => other.look !== one));
    if (!state.view) return;
    if (!look) return page.complain(`at most ${LOOKS.length} runs are pinned; remove one`);
    reference = {name: `pin ${look.at(-1)}`, view: state.view, values: {...state.values}, look};
    state.pins.push(reference);
    root.dispatchEvent(new CustomEvent("pinned"));
  }
  function unpin(pinned) {
    state.pins = state.pins.filter((one) => one !== pinned);
    if (reference === pinned) reference = state.pins.at(-1) ?? null;
    root.dispatchEvent(new CustomEvent("pinned"));
  }
  function drawPins() {
    compared.replaceChildren(make("option", {value: ""}, "ideal joints"), ...state.pins.map(({name}, k) => make("option", {value: k}, name)));
    compared.value = state.pins.includes(reference) ? state.pins.indexOf(reference) : "";
    at(".pins").replaceChildren(...state.pins.map((pinned) => {
      const name = make("input", {value: pinned.name, size: 7, "aria-label": "name of a pinned run"});
      name.addEventListener("change", () => { pinned.name = name.value; root.dispatchEvent(new CustomEvent("pinned")); });
      return make("span", {class: `pin ${pinned.look}`}, name,
        button("back", () => page.apply(pinned.values), `go back to the values of ${pinned.name}`),
        button("×", () => unpin(pinned), `remove ${pinned.name}`));
    }));
  }
  function drawTable() {
    const {view} = state;
    at(".numbers").classList.toggle("older", !view?.table);
    if (!view?.table) return;
    const rows = view.table, before = new Map(reference ? (reference.view.table ?? []).map(({name, value}) => [name, value]) : rows.map(({name, ideal}) => [name, ideal]));
    const heads = ["peak of", "now", reference?.name ?? "ideal", "change", "limit"];
    at(".numbers table").replaceChildren(
      make("thead", {}, make("tr", {}, ...heads.map((head) => make("th", {scope: "col"}, head)))),
      make("tbody", {}, ...rows.map((row) => tableRow(row, before.get(row.name) ?? null))));
  }
  function tableRow({name, unit: si, value, least, most}, before) {
    const [unit, factor] = unitOf(si, state.units), shown = (one, digits = 5) => (one === null ? "–" : String(Number((factor * one).toPrecision(digits))));
    const head = marked(make("th", {scope: "row", title: name}, labelOfOutput(name), make("small", {}, unit)), state.start.colors[name.split(".")[0]]);
    const [low, high] = [least, most].map((one) => shown(one, 3)), differ = state.view.settled && low !== high;
    const periods = differ ? [make("div", {class: "periods", title: "smallest and largest peak of single periods"}, `${low} to ${high}`)] : [];
    return make("tr", {"data-name": name}, head, make("td", {class: "now"}, make("span", {}, shown(value)), ...periods),
      make("td", {class: "other"}, shown(before)), make("td", {class: "change"}, percent(value, before)),
      make("td", {}, limitField(name, unit, factor), ...margin(state.limits[name], value)));
  }
  function limitField(name, unit, factor) {
    const limit = state.limits[name], text = limit ? `${limit.least ? ">" : "<"} ${g(factor * limit.value)}` : "";
    const field = make("input", {class: "limit", value: text, placeholder: "<", "aria-label": `limit of ${labelOfOutput(name)}`, title: `such as "< 7" or "> 0.2" [${unit || "1"}]`});
    field.addEventListener("change", () => {
      const [, sense, number] = /^\s*([<>]?)=?\s*([-+.\deE]+)\s*$/.exec(field.value) ?? [];
      if (Number.isFinite(Number(number))) state.limits[name] = {least: sense === ">", value: Number(number) / factor};
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
    return [make("div", {class: good ? "within" : "beyond", title: "margin"}, `${good ? "✓" : "✗"} ${g(100 * room, 3).replace("-", "−")} %`)];
  }
  function say(warnings = []) {
    at(".said").replaceChildren(...(state.view.motion ?? []).map((text) => make("li", {}, text)), ...warnings.map(({text, remedies}) =>
      make("li", {class: "warning"}, text, ...remedies.map(({label, values}) => button(label, () => page.change(values), Object.keys(values).join(", "))))));
  }
  for (const event of ["shown", "counted", "units", "pinned"]) root.addEventListener(event, drawTable);
  root.addEventListener("counted", () => say());
  root.addEventListener("pinned", drawPins);
  drawPins();
  return {pin, say, reference: () => reference};
}

// All runs since the page was opened: what was changed for each, and a table that can be sorted and written as CSV.

import {number} from "./curves.js";
import {button, download, make, scaled, table} from "./dom.js";

export function runs(page) {
  const {root, at, state} = page, list = []; // {number, change, values, table}
  let order = {key: "run", down: false};
  const shower = button("runs", show, "all runs since the page was opened");
  at(".buttons").append(shower);

  root.addEventListener("rested", () => {
    const {view} = state, values = {...state.values, ...view.numbers}, before = list.at(-1)?.values ?? values;
    if (!view.settled || !view.table?.length || (list.length && JSON.stringify(values) === JSON.stringify(before))) return;
    const changed = [...new Set([...Object.keys(before), ...Object.keys(values)])].filter((path) => before[path] !== values[path]);
    const change = changed.map((path) => `${page.labelOf(path)} ${page.inWords(path, values[path] ?? state.controls.get(path)?.value)}`).join(", ");
    list.push({number: list.length + 1, change, values, table: view.table});
    shower.textContent = `runs (${list.length})`;
  });
  function columns() { // key, label, unit, and the numbers of all runs in the shown units
    const paths = [...new Set(list.flatMap(({values}) => Object.keys(values)))], peaks = new Map(list.flatMap((run) => run.table.map((row) => [row.name, row])));
    const inUnit = (key, label, si, of) => {
      const [unit, factor] = page.unitOf(si);
      return {key, label, unit, of: (run) => { const value = of(run); return typeof value === "number" ? scaled(factor, value) : value ?? ""; }};
    };
    return [inUnit("run", "run", "", (run) => run.number), inUnit("change", "what was changed", "", ({change}) => change),
      ...paths.map((path) => [path, state.controls.get(path)]).map(([path, control]) =>
        inUnit(path, page.labelOf(path), control?.unit ?? "", ({values}) => values[path] ?? control?.value)),
      ...[...peaks.values()].map(({name, label, unit}) => inUnit(name, label, unit, (run) => run.table.find((row) => row.name === name)?.value))];
  }
  function show() {
    const all = columns(), {of} = all.find(({key}) => key === order.key) ?? all[0], sense = order.down ? -1 : 1;
    const sorted = [...list].sort((a, b) => sense * (of(a) > of(b) ? 1 : of(a) < of(b) ? -1 : 0));
    const heads = all.map(({key, label, unit}) => {
      const sort = button(unit ? `${label} [${unit}]` : label, () => { order = {key, down: key === order.key && !order.down}; show(); }, key);
      return make("th", {scope: "col", "aria-sort": key !== order.key ? "none" : order.down ? "descending" : "ascending"}, sort);
    });
    const rows = sorted.map((run) => [button(`${run.number}`, () => page.apply(run.values), `go back to run ${run.number}`),
      ...all.slice(1).map((column) => column.of(run)).map((cell) => (typeof cell === "number" ? number(cell, 5) : cell))]);
    page.open("Runs", [make("div", {class: "scroll", tabindex: 0, role: "region", "aria-label": "table of runs"}, table(heads, rows, {class: "runs"}))],
      button("CSV", () => write(all), "write all runs as CSV"));
  }
  function write(all) {
    const cell = (value) => (typeof value === "number" ? value : `"${String(value).replaceAll('"', '""')}"`);
    const lines = [all.map(({key, unit}) => cell(unit ? `${key} [${unit}]` : key)), ...list.map((run) => all.map(({of}) => cell(of(run))))];
    download(`${state.start.name}_runs.csv`, lines.map((line) => line.join(",")).join("\r\n"), "text/csv");
  }
}

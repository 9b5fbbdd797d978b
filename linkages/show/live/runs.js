// All runs since the page was opened: a table that can be sorted and written as CSV; a row goes back to its values.

import {button, download, g, make} from "./dom.js";
import {labelOfOutput, labelOfPath, unitOf} from "./words.js";

export function runs(page) {
  const {root, at, state} = page, list = []; // {number, values, table}
  let order = {column: "run", down: false};
  const shower = button("runs", show, "all runs since the page was opened");
  at(".buttons").append(shower);

  root.addEventListener("rested", () => {
    const {view} = state, values = {...state.values, ...view.numbers};
    if (!view.settled || !view.table?.length || JSON.stringify(values) === JSON.stringify(list.at(-1)?.values)) return;
    list.push({number: list.length + 1, values, table: view.table});
    shower.textContent = `runs (${list.length})`;
  });
  function table() { // heads and rows of numbers in the shown units
    const paths = [...new Set(list.flatMap(({values}) => Object.keys(values)))], outputs = new Map(list.flatMap((run) => run.table.map(({name, unit}) => [name, unit])));
    const heads = [["run", "run", "", 1],
      ...paths.map((path) => [path, labelOfPath(path), ...unitOf(state.controls.get(path)?.unit ?? "", state.units)]),
      ...[...outputs].map(([name, unit]) => [name, labelOfOutput(name), ...unitOf(unit, state.units)])];
    const rows = list.map((run) => {
      const known = {run: run.number, ...Object.fromEntries(paths.map((path) => [path, run.values[path] ?? state.controls.get(path)?.value ?? null])),
        ...Object.fromEntries(run.table.map(({name, value}) => [name, value]))};
      return {run, cells: heads.map(([key, , , factor]) => (typeof known[key] === "number" ? factor * known[key] : known[key] ?? ""))};
    });
    return {heads, rows};
  }
  function show() {
    const {heads, rows} = table(), column = Math.max(heads.findIndex(([key]) => key === order.column), 0);
    rows.sort((a, b) => (order.down ? -1 : 1) * (a.cells[column] > b.cells[column] ? 1 : a.cells[column] < b.cells[column] ? -1 : 0));
    const text = (cell) => (typeof cell === "number" ? g(cell) : cell);
    const dialog = at("dialog.runs");
    dialog.replaceChildren(
      make("div", {class: "head"}, make("h2", {}, "Runs"), button("CSV", write, "write all runs as CSV"), button("close", () => dialog.close(), "Escape")),
      make("div", {class: "scrolled"}, make("table", {},
        make("thead", {}, make("tr", {}, ...heads.map(([key, label, unit]) => make("th", {scope: "col", "aria-sort": key !== order.column ? "none" : order.down ? "descending" : "ascending"},
          button(unit ? `${label} [${unit}]` : label, () => { order = {column: key, down: key === order.column && !order.down}; show(); }, key))))),
        make("tbody", {}, ...rows.map(({run, cells}) => make("tr", {},
          make("td", {}, button(`${cells[0]}`, () => { dialog.close(); page.apply(run.values); }, `go back to run ${run.number}`)), ...cells.slice(1).map((cell) => make("td", {}, text(cell)))))))));
    if (!dialog.open) dialog.showModal();
  }
  function write() {
    const {heads, rows} = table(), quoted = (cell) => `"${String(cell).replaceAll('"', '""')}"`;
    const lines = [heads.map(([key, , unit]) => quoted(unit ? `${key} [${unit}]` : key)), ...rows.map(({cells}) => cells.map((cell) => (typeof cell === "number" ? cell : quoted(cell))))];
    download(`${state.start.name}_runs.csv`, lines.map((line) => line.join(",")).join("\r\n"), "text/csv");
  }
}
